"""All files of a sweep as one archive: whole, with digests, never in memory at once, and never with a damaged file."""

import hashlib
import subprocess
import tracemalloc
import zipfile
from dataclasses import replace
from pathlib import Path

import httpx
import pytest

from service.client.client import Client
from service.client.connection import ServiceError, Unreachable
from service.files.artifacts import digest
from tests.claims.marked import Compared
from tests.claims.rows import at_most, equal
from tests.service.support.api import ALL_RUNS, COVERS, FILES, Api, served
from tests.service.support.command import run

STATE = bytes(range(256)) * (32 << 12)  # 32 MiB, of each run
MEMORY = 16 << 20  # bytes of server and client together while they send and receive 64 MiB: sixteen pieces of a file
LOG = b"step 1\n"


def ended(api: Api) -> str:
    """A sweep of two runs with large files, one of which failed."""
    id = api.submit()
    first, second = api.store.leases.take(2, api.term())
    for lease in (first, second):
        contents = {"result.json": b"{}", "state.npz": STATE, "log.txt": LOG}
        stored = tuple(api._stored(f"{lease.id}/{name}", content) for name, content in contents.items())
        api.store.leases.finish(lease, replace(api.result(lease.id), files=stored, succeeded=lease is first))
    api.compute()
    return id


@pytest.mark.claim("pages", "archive-has-every-file")
def test_archive__has_every_file_with_its_digest_and_is_never_in_memory(
    api: Api, tmp_path: Path, compared: Compared
) -> None:
    """The archive of a sweep has every file of it and of its runs, each with its registered digest, sent in pieces."""
    id = ended(api)
    runs = {point.run.id for point in api.store.sweeps.points(id).items}
    published = {*FILES, *ALL_RUNS, *COVERS}
    of_runs = {f"runs/{run}/{name}" for run in runs for name in ("result.json", "state.npz", "log.txt")}
    with served(api) as url, Client(url) as client:
        tracemalloc.start()
        archive = client.sweep(id).fetch_archive(tmp_path / "archive.zip")
        _, peak = tracemalloc.get_traced_memory()
        tracemalloc.stop()
        assert run("fetch", id[:8], "--out", tmp_path / "other", "--zip", "--url", url) == 0
        assert client.sweep(id).document() == api.http.get(f"/v1/sweeps/{id}/document").json()
    compared(at_most("bytes of server and client", limit=MEMORY, got=peak))
    with zipfile.ZipFile(archive) as opened:
        names = set(opened.namelist())
        compared(equal("files", expected=sorted({*published, *of_runs, "sweep.json", "SHA256SUMS"}), got=sorted(names)))
        opened.extractall(tmp_path / "all")
    registered = {stored.name: stored.sha256 for stored in api.store.publications.files(id)}
    registered |= {f"runs/{run}/{each.name}": each.sha256 for run in runs for each in api.store.runs.files(run)}
    compared(equal("digests", expected=registered, got={name: digest(tmp_path / "all" / name) for name in registered}))
    checked = subprocess.run(
        ["sha256sum", "--check", "SHA256SUMS"], cwd=tmp_path / "all", capture_output=True, text=True
    )
    assert checked.returncode == 0, checked.stderr
    assert checked.stdout.count(": OK") == len(names) - 1
    assert (tmp_path / "other" / "archive.zip").stat().st_size == archive.stat().st_size


def test_archive__is_refused_before_a_sweep_has_ended_and_linked_afterwards(api: Api) -> None:
    id = api.submit()
    here = f"/v1/sweeps/{id}"
    assert api.http.get(f"{here}/archive.zip").status_code == 409
    assert "archive.zip" not in api.http.get(here).json()["links"]
    api.compute()
    response = api.http.get(api.http.get(here).json()["links"]["archive.zip"])
    assert int(response.headers["Content-Length"]) == len(response.content)
    assert response.headers["Content-Disposition"] == 'attachment; filename="two-speeds-archive.zip"'


def test_archive__with_a_damaged_file_is_never_whole(api: Api, tmp_path: Path) -> None:
    id = ended(api)
    [point, _] = api.store.sweeps.points(id).items
    path = api.settings.data / api.store.runs.file(point.run.id, "state.npz").path
    path.write_bytes(STATE[:-1] + b"x")
    with served(api) as url, Client(url, patience=0.1) as client:
        with pytest.raises(Unreachable, match="closed"):
            client.sweep(id).fetch_archive(tmp_path / "archive.zip")
        path.unlink()
        with pytest.raises(ServiceError, match=r"1 files are lost or damaged.*state\.npz"):
            client.sweep(id).fetch_archive(tmp_path / "archive.zip")
    assert not list(tmp_path.glob("*.zip*"))


@pytest.mark.parametrize(
    "content",
    [{"cube.nc": b"other"}, {"cube.nc": b"cube", "more.txt": b"not listed"}, {}],
    ids=["other", "more", "less"],
)
def test_client__takes_no_archive_whose_files_are_not_those_of_its_digests(
    content: dict[str, bytes], tmp_path: Path
) -> None:
    listed = f"{hashlib.sha256(b'cube').hexdigest()}  cube.nc\n".encode()
    file = tmp_path / "served.zip"
    with zipfile.ZipFile(file, "w") as archive:
        for name, text in {**content, "SHA256SUMS": listed}.items():
            archive.writestr(name, text)
    transport = httpx.MockTransport(lambda _: httpx.Response(200, content=file.read_bytes()))
    with Client(transport=transport, patience=0.0) as client, pytest.raises(ServiceError, match="digest"):
        client.sweep("0" * 32).fetch_archive(tmp_path / "archive.zip")
    assert not (tmp_path / "archive.zip").exists()
