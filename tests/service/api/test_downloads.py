"""Files over HTTP: tags, digests, parts; of sweeps, of runs, and of a log that grows."""

import base64
import hashlib
import re
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from service.files.artifacts import Artifacts
from service.records.jobs import Cause, Lease
from studies.quantities.files import APPENDIX_HTML
from tests.service.support.api import ALL_RUNS, FILES, Api, sweep_of

STATE = bytes(range(256)) * 4096  # a megabyte: several chunks
LOG = b"step 1\nstep 2\n\xc3\xa9\n"


@pytest.fixture(scope="module")
def addresses(shared_api: Api) -> dict[str, tuple[str, bytes]]:
    """Every kind of file: where it is, and what is in it."""
    api = shared_api
    id = api.submit()
    run = ""
    for lease in api.store.leases.take(100, api.term()):
        run = lease.id
        contents = {"result.json": b"{}", "state.npz": STATE, "log.txt": LOG}
        stored = tuple(api._stored(f"{run}/{name}", content) for name, content in contents.items())
        api.store.leases.finish(lease, replace(api.result(run), files=stored))
    api.compute()
    sweep = {name: (f"/v1/sweeps/{id}/{name}", content) for name, content in FILES.items()}
    return sweep | {
        "runs-all.csv": (f"/v1/sweeps/{id}/runs.csv?all=true", ALL_RUNS["runs-all.csv"]),
        "state.npz": (f"/v1/runs/{run}/files/state.npz", STATE),
        "result.json": (f"/v1/runs/{run}/files/result.json", b"{}"),
        "log": (f"/v1/runs/{run}/log", LOG),
    }


KINDS = (*FILES, *ALL_RUNS, "state.npz", "result.json", "log")


@pytest.fixture(params=KINDS)
def file(request: pytest.FixtureRequest, addresses: Any) -> tuple[str, bytes]:
    return addresses[request.param]


def test_file__is_whole_with_tag_digest_and_length(shared_api: Api, file: tuple[str, bytes]) -> None:
    path, content = file
    response = shared_api.http.get(path)
    sha256 = hashlib.sha256(content)
    assert (response.status_code, response.content) == (200, content)
    digest = base64.b64encode(sha256.digest()).decode()
    expected = {
        "ETag": f'"{sha256.hexdigest()}"',
        "Repr-Digest": f"sha-256=:{digest}:",
        "Content-Length": str(len(content)),
        "Accept-Ranges": "bytes",
        "X-Content-Type-Options": "nosniff",
    }
    assert {name: response.headers[name] for name in expected} == expected


def test_file__is_sent_by_the_tags_of_the_request(shared_api: Api, file: tuple[str, bytes]) -> None:
    """Not again where it is known, in part where the copy is the same, and not where another one is meant."""
    path, content = file
    tag = shared_api.http.head(path).headers["ETag"]

    def ask(method: str = "GET", **headers: str) -> tuple[int, bytes]:
        named = {name.replace("_", "-"): value for name, value in headers.items()}
        response = shared_api.http.request(method, path, headers=named)
        assert response.status_code == 412 or response.headers["ETag"] == tag
        return response.status_code, response.content

    for known in (tag, f"W/{tag}", f'"other", {tag}', "*"):
        assert ask(If_None_Match=known) == ask("HEAD", If_None_Match=known) == (304, b"")
    assert ask(If_None_Match='"x"')[0] == 200
    assert ask(Range="bytes=1-3", If_Range=tag) == (206, content[1:4])
    assert ask("HEAD", Range="bytes=0-0") == (206, b"")
    for other in ('"old"', f"W/{tag}", "Sat, 21 Nov 2026 00:00:00 GMT"):
        assert ask(Range="bytes=1-3", If_Range=other) == (200, content)
    for meant in (tag, f'"old", {tag}', "*"):
        assert ask(If_Match=meant) == (200, content)
    for other in ('"old"', f"W/{tag}"):  # a weak tag is never the same as a strong one
        assert {ask(method, If_Match=other, Range="bytes=0-0")[0] for method in ("GET", "HEAD")} == {412}


def test_sweep_file__is_offered_under_a_plain_name(api: Api) -> None:
    id = api.submit(name='Ärger/../x"; A: b')
    api.compute()
    disposition = api.http.get(f"/v1/sweeps/{id}/cube.nc").headers["Content-Disposition"]
    assert re.fullmatch(r'attachment; filename="[A-Za-z0-9._-]+-cube\.nc"', disposition)


def test_appendix__has_the_headers_of_the_report(shared_api: Api, addresses: Any) -> None:
    report, appendix = (shared_api.http.head(addresses[name][0]).headers for name in ("report.html", APPENDIX_HTML))
    assert "sandbox allow-scripts" in report["Content-Security-Policy"]
    for name in ("Content-Security-Policy", "X-Frame-Options", "Content-Type", "Cache-Control", "Accept-Ranges"):
        assert appendix[name] == report[name]


def test_run__lists_its_files(shared_api: Api, addresses: Any) -> None:
    run = addresses["log"][0].split("/")[3]
    items = shared_api.http.get(f"/v1/runs/{run}/files").json()["items"]
    assert [item["name"] for item in items] == ["log.txt", "result.json", "state.npz"]
    for item in items:
        content = shared_api.http.get(item["href"]).content
        assert (len(content), hashlib.sha256(content).hexdigest()) == (item["size"], item["sha256"])


@pytest.mark.parametrize("name", ["nope", "film.npz", "..%2Fresult.json", "log.txt%00", "%2e%2e"])
def test_run_file__that_is_not_kept_is_a_404(shared_api: Api, addresses: Any, name: str) -> None:
    run = addresses["log"][0].split("/")[3]
    response = shared_api.http.get(f"/v1/runs/{run}/files/{name}")
    assert response.status_code == 404
    assert response.headers["Content-Type"] == "application/problem+json"


def written_log(api: Api, lease: Lease, content: bytes) -> Path:
    """What an attempt has printed so far."""
    log = Artifacts(api.settings.data).attempt_directory(lease) / "log.txt"
    log.parent.mkdir(parents=True)
    log.write_bytes(content)
    return log


def test_log__of_a_running_run_grows(api: Api) -> None:
    id = api.submit(axes={"speed": ["9 km/s"]})
    here = f"/v1/runs/{api.store.sweeps.points(id).items[0].run.id}/log"
    assert api.http.get(here).status_code == 404  # it has not begun
    [lease] = api.store.leases.take(1, api.term())
    assert api.http.get(here).status_code == 404  # nothing is printed yet
    log = written_log(api, lease, b"step 1\n")
    first = api.http.get(here)
    assert (first.status_code, first.content) == (200, b"step 1\n")
    assert first.headers["Content-Type"] == "text/plain; charset=utf-8"
    log.write_bytes(b"step 1\nstep 2\n")
    more = api.http.get(here, headers={"Range": f"bytes={len(first.content)}-"})
    assert (more.status_code, more.content) == (206, b"step 2\n")
    assert api.http.get(f"/v1/sweeps/{id}").json()["state"] == "running"
    api.store.leases.fail(lease, Cause.ERROR, failure="ValueError", reason="x")
    assert api.http.get(here).content == b"step 1\nstep 2\n"


def test_log__of_a_run_that_is_computed_again_is_that_of_the_attempt(api: Api) -> None:
    id = api.submit()
    api.compute()
    asked = api.http.post("/v1/sweeps", params={"keep": "film"}, json=sweep_of())
    assert asked.json()["new"] == 2
    [lease] = api.store.leases.take(1, api.term())
    written_log(api, lease, b"once more\n")
    assert api.http.get(f"/v1/runs/{lease.id}/log").content == b"once more\n"
    assert api.http.get(f"/v1/sweeps/{id}").json()["state"] == "succeeded"


def test_file__that_no_longer_has_its_digest_is_not_served(api: Api) -> None:
    id = api.submit()
    api.compute()
    path = f"/v1/sweeps/{id}/cube.nc"
    tag = api.http.get(path).headers["etag"]
    _, stored = api.store.sweeps.get_with_file(id, "cube.nc")
    assert stored is not None
    file = api.settings.data / stored.path
    content = file.read_bytes()
    file.write_bytes(b"x" * len(content))
    for headers in ({}, {"If-None-Match": tag}, {"Range": "bytes=0-3"}):
        response = api.http.get(path, headers=headers)
        assert (response.status_code, response.json()["title"]) == (500, "File damaged")
        assert "etag" not in response.headers
    [publication] = api.store.leases.take(9, api.term())
    assert api.http.get(path).status_code == 500
    assert api.http.get(f"/v1/sweeps/{id}").json()["state"] == "publishing"
    files = [api._stored(f"again/{name}", each) for name, each in FILES.items()]
    assert api.store.leases.publish(publication, files, seconds=0.1)  # the requests leave the one that is under way
    assert api.http.get(path).content == content
