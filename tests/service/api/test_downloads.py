"""Files over HTTP: tags, digests, parts; of sweeps, of runs, and of a log that grows."""

import base64
import hashlib
import re
from collections.abc import Iterator
from typing import Any

import httpx
import pytest

from service.files.artifacts import Artifacts
from service.records.jobs import Cause, Result
from tests.service.support.api import FILES, Api, open_api, served, sweep_of

STATE = bytes(range(256)) * 4096  # a megabyte: several chunks
LOG = b"step 1\nstep 2\n\xc3\xa9\n"


@pytest.fixture(scope="module")
def api(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Api]:
    with open_api(tmp_path_factory.mktemp("files")) as opened:
        yield opened


@pytest.fixture(scope="module")
def addresses(api: Api) -> dict[str, tuple[str, bytes]]:
    """Every kind of file: where it is, and what is in it."""
    id = api.submit()
    run = ""
    for claim in api.store.lease(100, api.term()):
        run = claim.id
        stored = [
            api._stored(f"{claim.id}/{name}", content)
            for name, content in (("result.json", b"{}"), ("state.npz", STATE), ("log.txt", LOG))
        ]
        plain = api.result(claim.id)
        api.store.finish(claim, Result(**{**vars(plain), "files": tuple(stored)}))
    api.compute()
    sweep = {name: (f"/v1/sweeps/{id}/{name}", content) for name, content in FILES.items()}
    return sweep | {
        "state.npz": (f"/v1/runs/{run}/files/state.npz", STATE),
        "result.json": (f"/v1/runs/{run}/files/result.json", b"{}"),
        "log": (f"/v1/runs/{run}/log", LOG),
    }


KINDS = (*FILES, "state.npz", "result.json", "log")


@pytest.fixture(params=KINDS)
def file(request: pytest.FixtureRequest, addresses: Any) -> tuple[str, bytes]:
    return addresses[request.param]


def test_file__is_whole_with_tag_digest_and_length(api: Api, file: tuple[str, bytes]) -> None:
    path, content = file
    response = api.http.get(path)
    sha256 = hashlib.sha256(content)
    assert (response.status_code, response.content) == (200, content)
    assert response.headers["ETag"] == f'"{sha256.hexdigest()}"'
    digest = base64.b64encode(sha256.digest()).decode()
    assert response.headers["Repr-Digest"] == f"sha-256=:{digest}:"
    assert response.headers["Content-Length"] == str(len(content))
    assert response.headers["Accept-Ranges"] == "bytes"
    assert response.headers["X-Content-Type-Options"] == "nosniff"


def test_file__is_not_sent_twice(api: Api, file: tuple[str, bytes]) -> None:
    path, _ = file
    tag = api.http.get(path).headers["ETag"]
    for existing in (tag, f"W/{tag}", f'"other", {tag}', "*"):
        for method in ("GET", "HEAD"):
            again = api.http.request(method, path, headers={"If-None-Match": existing})
            assert (again.status_code, again.content) == (304, b"")
            assert again.headers["ETag"] == tag
    assert api.http.get(path, headers={"If-None-Match": '"x"'}).status_code == 200


def test_file__head_answers_what_get_would(api: Api, file: tuple[str, bytes]) -> None:
    path, _ = file
    for headers in ({}, {"Range": "bytes=0-0"}):
        head, get = api.http.head(path, headers=headers), api.http.get(path, headers=headers)
        assert head.content == b""
        assert head.status_code == get.status_code
        drop = {"x-request-id", "date"}
        assert {k: v for k, v in head.headers.items() if k not in drop} == {
            k: v for k, v in get.headers.items() if k not in drop
        }


def test_file__is_sent_in_part_where_the_copy_is_the_same(api: Api, file: tuple[str, bytes]) -> None:
    path, content = file
    tag = api.http.head(path).headers["ETag"]
    part = {"Range": "bytes=1-3", "If-Range": tag}
    response = api.http.get(path, headers=part)
    assert (response.status_code, response.content) == (206, content[1:4])
    for other in ('"old"', f"W/{tag}", "Sat, 21 Nov 2026 00:00:00 GMT"):
        whole = api.http.get(path, headers=part | {"If-Range": other})
        assert (whole.status_code, whole.content) == (200, content)


def test_file__that_is_another_one_now_is_a_412_problem(api: Api, file: tuple[str, bytes]) -> None:
    path, content = file
    tag = api.http.get(path).headers["ETag"]
    for meant in (tag, f'"old", {tag}', "*"):
        assert api.http.get(path, headers={"If-Match": meant}).content == content
    for other in ('"old"', f"W/{tag}"):  # a weak tag is never the same as a strong one
        for method in ("GET", "HEAD"):
            refused = api.http.request(method, path, headers={"If-Match": other, "Range": "bytes=0-0"})
            assert refused.status_code == 412
    assert refused.headers["Content-Type"] == "application/problem+json"


def test_download__that_broke_off_is_completed_bit_for_bit(api: Api, addresses: Any) -> None:
    path, content = addresses["state.npz"]
    with served(api) as url:
        with httpx.stream("GET", url + path, timeout=60) as response:
            tag = response.headers["ETag"]
            begun = next(response.iter_bytes(100_000))
        rest = {"Range": f"bytes={len(begun)}-", "If-Range": tag}
        response = httpx.get(url + path, headers=rest, timeout=60)
    assert response.status_code == 206
    assert begun + response.content == content


# --- sweeps -------------------------------------------------------------------------------------------


def test_sweep_file__is_offered_under_a_plain_name(api: Api) -> None:
    id = api.submit(name='Ärger/../x"; A: b')
    api.compute()
    disposition = api.http.get(f"/v1/sweeps/{id}/cube.nc").headers["Content-Disposition"]
    assert re.fullmatch(r'attachment; filename="[A-Za-z0-9._-]+-cube\.nc"', disposition)


def test_sweep_file__of_an_unfinished_sweep_is_a_409_that_says_how_far_it_is(api: Api) -> None:
    id = api.submit(axes={"speed": ["8.5 km/s"]})
    for name in FILES:
        response = api.http.get(f"/v1/sweeps/{id}/{name}")
        assert response.status_code == 409
        assert response.json()["type"].endswith("not-ready")
        assert "queued" in response.json()["detail"]


def test_sweep_file__that_was_removed_by_hand_is_a_404(api: Api) -> None:
    id = api.submit()
    api.compute()
    (api.settings.data / api.store.artifacts(id)[0].path).unlink()
    assert api.http.get(f"/v1/sweeps/{id}/cube.nc").status_code == 404


# --- runs ---------------------------------------------------------------------------------------------


def test_run__lists_its_files(api: Api, addresses: Any) -> None:
    run = addresses["log"][0].split("/")[3]
    items = api.http.get(f"/v1/runs/{run}/files").json()["items"]
    assert [item["name"] for item in items] == ["log.txt", "result.json", "state.npz"]
    for item in items:
        content = api.http.get(item["href"]).content
        assert (len(content), hashlib.sha256(content).hexdigest()) == (item["size"], item["sha256"])


@pytest.mark.parametrize("name", ["nope", "film.npz", "..%2Fresult.json", "log.txt%00", "%2e%2e"])
def test_run_file__that_is_not_kept_is_a_404(api: Api, addresses: Any, name: str) -> None:
    run = addresses["log"][0].split("/")[3]
    response = api.http.get(f"/v1/runs/{run}/files/{name}")
    assert response.status_code == 404
    assert response.headers["Content-Type"] == "application/problem+json"


@pytest.mark.parametrize("path", ["files", "files/result.json", "log"])
def test_run_file__of_no_run_is_a_404(api: Api, path: str) -> None:
    assert api.http.get(f"/v1/runs/{'0' * 32}/{path}").status_code == 404


def test_log__of_a_running_run_is_what_there_is_and_grows(api: Api) -> None:
    api.compute()
    id = api.submit(axes={"speed": ["9 km/s"]})
    [claim] = api.store.lease(1, api.term())
    here = f"/v1/runs/{claim.id}/log"
    assert api.http.get(here).status_code == 404  # nothing is printed yet
    log = Artifacts(api.settings.data).attempt_directory(claim) / "log.txt"
    log.parent.mkdir(parents=True)
    log.write_bytes(b"step 1\n")
    first = api.http.get(here)
    assert (first.status_code, first.content) == (200, b"step 1\n")
    assert first.headers["Content-Type"] == "text/plain; charset=utf-8"
    log.write_bytes(b"step 1\nstep 2\n")
    more = api.http.get(here, headers={"Range": f"bytes={len(first.content)}-"})
    assert (more.status_code, more.content) == (206, b"step 2\n")
    assert api.http.get(f"/v1/sweeps/{id}").json()["state"] == "running"
    api.store.fail(claim, Cause.ERROR, failure="ValueError", reason="x")
    assert api.http.get(here).content == b"step 1\nstep 2\n"


def test_log__of_a_run_that_is_computed_again_is_that_of_the_attempt(api: Api) -> None:
    id = api.submit()
    api.compute()
    asked = api.http.post("/v1/sweeps", params={"keep": "film"}, json=sweep_of())
    assert asked.json()["new"] == 2
    [claim] = api.store.lease(1, api.term())
    here = f"/v1/runs/{claim.id}/log"
    log = Artifacts(api.settings.data).attempt_directory(claim) / "log.txt"
    log.parent.mkdir(parents=True)
    log.write_bytes(b"once more\n")
    assert api.http.get(here).content == b"once more\n"
    assert api.http.get(f"/v1/sweeps/{id}").json()["state"] == "succeeded"


def test_log__that_grows_while_it_is_sent_has_the_length_that_was_announced(api: Api) -> None:
    api.compute()
    api.submit(axes={"speed": ["9.5 km/s"]})
    [claim] = api.store.lease(1, api.term())
    log = Artifacts(api.settings.data).attempt_directory(claim) / "log.txt"
    log.parent.mkdir(parents=True)
    log.write_bytes(b"x" * 3_000_000)
    with served(api) as url, httpx.stream("GET", f"{url}/v1/runs/{claim.id}/log", timeout=60) as response:
        chunks = response.iter_bytes()
        length = len(next(chunks))
        with log.open("ab") as end:
            end.write(b"y" * 1_000_000)
        length += sum(map(len, chunks))
    assert length == int(response.headers["Content-Length"]) == 3_000_000


def test_log__of_a_run_that_has_not_begun_is_a_404(api: Api) -> None:
    run = api.store.sweep_runs(api.submit(axes={"speed": ["9.9 km/s"]})).items[0].run.id
    assert api.http.get(f"/v1/runs/{run}/log").status_code == 404


def test_file__that_no_longer_has_its_digest_is_not_served(api: Api) -> None:
    id = api.submit(resolution=10)
    api.compute()
    path = f"/v1/sweeps/{id}/cube.nc"
    tag = api.http.get(path).headers["etag"]
    _, stored = api.store.sweep_and_file(id, "cube.nc")
    assert stored is not None
    file = api.settings.data / stored.path
    content = file.read_bytes()
    file.write_bytes(b"x" * len(content))
    for headers in ({}, {"If-None-Match": tag}, {"Range": "bytes=0-3"}):
        response = api.http.get(path, headers=headers)
        assert (response.status_code, response.json()["title"]) == (500, "File damaged")
        assert "etag" not in response.headers
    file.write_bytes(content)
    assert api.http.get(path).content == content
