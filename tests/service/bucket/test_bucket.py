"""Files in a bucket: before rows name them, back when the disk lacks them, mended, and cleared away."""

import hashlib
import json
import os
import time
from collections import deque
from collections.abc import Iterator
from contextlib import ExitStack, closing, contextmanager
from dataclasses import replace
from pathlib import Path
from unittest.mock import patch

import pytest
from fastapi.testclient import TestClient
from fsspec.implementations.memory import MemoryFileSystem

from service.api.app import build_app
from service.bucket.bucket import ObjectBucket
from service.bucket.keeping import HOUR, BucketKeeper
from service.files.artifacts import Artifacts
from service.files.stores import FilesAway
from service.maintenance.backup import back_up
from service.maintenance.doctor import CheckStatus, check_bucket
from service.queue import data_identity as identity
from service.queue.clock_watch import ClockWatch
from service.queue.garbage_collection import forget_lost_states
from service.records.jobs import Cause, Keep, State, Stored, SweepState
from service.settings import Settings
from service.workers.timings import DEFAULT
from studies.quantities.findings import InvalidInput
from tests.service.support.api import ADDRESS, FakeDispatcher
from tests.service.support.attempts import published
from tests.service.support.fakes import DEADLINE, open_store, run_id, runs_of, settings_in
from tests.service.support.harness import Harness, open_harness


@pytest.fixture
def harness(tmp_path: Path) -> Iterator[Harness]:
    """A service with a bucket, and a sweep that was submitted to it."""
    with open_harness(tmp_path, artifacts=f"memory://{tmp_path.name}") as opened:
        identity.settle(opened.settings, opened.store)
        opened.artifacts = Artifacts.of(opened.settings)
        opened.submit(runs_of("fine", "fine"), keep=Keep.FILM)
        yield opened


def bucket(harness: Harness) -> ObjectBucket:
    assert isinstance(harness.artifacts.bucket, ObjectBucket)
    return harness.artifacts.bucket


def files(harness: Harness) -> list[Stored]:
    return [file for _, file in harness.store.retention.files()]


def http(harness: Harness, **settings: object) -> TestClient:
    chosen = harness.settings.model_copy(update=settings)
    return TestClient(build_app(chosen, harness.store, FakeDispatcher()), base_url=ADDRESS, follow_redirects=False)


def keep_bucket(harness: Harness, **settings: object) -> None:
    """Go round the bucket, and twice over the disk."""
    chosen = harness.settings.model_copy(update=settings)
    clock = ClockWatch(chosen, harness.store)
    keeper = BucketKeeper(chosen, harness.store, harness.artifacts, clock, DEFAULT)
    for parts in (keeper._folders(bucket(harness)), keeper._pages(), keeper._pages()):
        deque(parts)


@contextmanager
def away(*methods: str) -> Iterator[None]:
    """Let methods of every bucket fail, as its library does when nobody answers."""
    with ExitStack() as ends:
        for method in methods:
            ends.enter_context(patch.object(MemoryFileSystem, method, _refuse))
        yield


def _refuse(*_arguments: object, **_options: object) -> None:
    raise RuntimeError("Could not connect to the endpoint URL")


def put(harness: Harness, name: str, content: bytes) -> None:
    bucket(harness).files.pipe_file(bucket(harness)._path(name), content)


# --- before rows name them, and back --------------------------------------------------------------


def test_files__that_the_bucket_alone_has_are_backed_up_and_not_lost(harness: Harness, tmp_path: Path) -> None:
    harness.compute_all()
    [sweep] = harness.store.sweeps.page().items
    registered = files(harness)
    for file in registered:
        harness.artifacts.path(file).unlink()
    forget_lost_states(harness.store, harness.artifacts, sweep.id)
    assert files(harness) == registered
    done = back_up(harness.settings, tmp_path.with_name("backup"), harness.store)
    assert (done.copied, done.lost) == (len(registered), ())


def test_bucket_that_is_away__is_waited_for(harness: Harness) -> None:
    first, second = harness.tick()
    harness.end_well(first)
    harness.end_badly(second, Cause.TIME_LIMIT)
    Path(second.directory).mkdir(parents=True)
    (Path(second.directory) / "log.txt").write_text("until then\n")
    with away("put_file"):
        harness.tick()
        assert harness.tick() == []
        assert [harness.run(number).state for number in (0, 1)] == [State.RUNNING, State.RUNNING]
        assert "Could not connect" in str(harness.dispatcher.blocked_reason())
    harness.tick()
    assert [harness.run(number).state for number in (0, 1)] == [State.SUCCEEDED, State.FAILED]
    assert harness.dispatcher.blocked_reason() is None
    assert {file.path for file in files(harness)} == set(bucket(harness).names("runs"))


def test_upload_that_fails__is_not_excused_by_a_read(harness: Harness, tmp_path: Path) -> None:
    with away("put_file"), pytest.raises(FilesAway):
        bucket(harness).put(tmp_path / "whipple.id", "probe")
    assert bucket(harness).names("") == ["whipple.id"]
    assert bucket(harness).blocked_reason() is not None
    bucket(harness).put(tmp_path / "whipple.id", "probe")
    assert bucket(harness).blocked_reason() is None


def test_download__of_a_bucket_that_is_away_is_tried_again(harness: Harness) -> None:
    harness.compute_all()
    [sweep] = harness.store.sweeps.page().items
    for file in files(harness):
        harness.artifacts.path(file).unlink()
    client, path = http(harness), f"/v1/sweeps/{sweep.id}/cube.nc"
    with away("get_file"):
        response = client.get(path)
    assert (response.status_code, response.json()["title"]) == (503, "Bucket unavailable")
    assert response.headers["Retry-After"] == "10"
    assert client.get(path).status_code == 503  # nobody waits for a store that hangs, for so long
    with patch("service.bucket.bucket.AGAIN_SECONDS", 0.0):
        assert client.get(path).status_code == 200


def test_publication__brings_results_and_sections_back(harness: Harness) -> None:
    for attempt in harness.tick():
        ending = harness.compute(attempt)
        sections = Path(attempt.directory) / "sections.npz"
        sections.write_text(attempt.key)
        described = replace(ending.files[0], name=sections.name, path=str(sections))
        size, sha256 = len(attempt.key), hashlib.sha256(attempt.key.encode()).hexdigest()
        harness.end(attempt, replace(ending, files=(*ending.files, replace(described, size=size, sha256=sha256))))
    [publication] = harness.tick()
    for file in files(harness):
        harness.artifacts.path(file).unlink()
    Path(publication.directory).mkdir(parents=True)
    losses = [
        {"run_id": each["run_id"], "path": each["path"], "sha256": each["sha256"]}
        for each in published(publication)["outcomes"]
    ]
    (Path(publication.directory) / "losses.json").write_text(json.dumps(losses))
    with away("get_file"):
        harness.end_badly(publication, Cause.ERROR, failure="ResultsLost")
        assert harness.tick() == []
    [again] = harness.tick()
    back = {file.name for file in files(harness) if harness.artifacts.is_intact(file)}
    assert back == {"result.json", "sections.npz"}
    harness.end_well(again)
    harness.tick()
    assert [sweep.state for sweep in harness.store.sweeps.page().items] == [SweepState.SUCCEEDED]
    assert [harness.run(number).attempt for number in (0, 1)] == [1, 1]


# --- links ----------------------------------------------------------------------------------------


def test_link__is_given_for_whole_files_that_no_browser_shows(harness: Harness) -> None:
    harness.compute_all()
    [sweep] = harness.store.sweeps.page().items
    cube, client = f"/v1/sweeps/{sweep.id}/cube.nc", http(harness, artifacts_links=60)
    assert client.get(cube).status_code == 200  # this store signs nothing
    with patch.object(MemoryFileSystem, "sign", lambda _self, path, expiration: f"https://s3{path}?for={expiration}"):
        linked = client.get(cube)
        stored = next(file for file in files(harness) if file.name == "cube.nc")
        assert (linked.status_code, linked.headers["ETag"]) == (307, f'"{stored.sha256}"')
        assert linked.headers["Location"].endswith(f"{stored.path}?for=60")
        assert client.head(cube).status_code == 200
        assert client.get(cube, headers={"Range": "bytes=0-1"}).status_code == 206
        assert client.get(f"/v1/sweeps/{sweep.id}/report.html").status_code == 200
        assert http(harness).get(cube).status_code == 200


# --- what goes ------------------------------------------------------------------------------------


def test_object__that_no_row_names_goes_and_others_stay(harness: Harness) -> None:
    lost, under_way = harness.tick()
    harness.end_well(lost)
    harness.tick()
    named = set(bucket(harness).names(""))
    orphan, unknown = (f"{run}/a7-c0ffee/state.npz" for run in ("runs/00/" + run_id(0), "runs/00/" + run_id(99)))
    current = f"{harness.artifacts.relative(Path(under_way.directory))}/state.npz"
    for name in (orphan, unknown, current):
        put(harness, name, b"...")
    keep_bucket(harness)
    assert set(bucket(harness).names("")) == named | {orphan, unknown, current}  # the orphan is young
    keep_bucket(harness, retire_seconds=1e-9)
    assert set(bucket(harness).names("")) == named | {unknown, current}
    harness.end_badly(under_way, Cause.TIME_LIMIT)
    harness.tick()
    keep_bucket(harness, retire_seconds=1e-9)
    assert set(bucket(harness).names("")) == named | {unknown}


def test_objects__of_a_deleted_sweep_and_of_dropped_files_go(harness: Harness) -> None:
    harness.compute_all()
    [sweep] = harness.store.sweeps.page().items
    harness.store.sweeps.delete(sweep.id)
    keep_bucket(harness)
    assert bucket(harness).names("sweeps") == []
    harness.store.retention.drop(harness.store.retention.discardable(100, ""))
    keep_bucket(harness, retire_seconds=1e-9)
    assert {name.rpartition("/")[2] for name in bucket(harness).names("runs")} == {"result.json", "log.txt"}


def test_cache__gives_up_what_was_read_least_recently_and_is_in_the_bucket(harness: Harness) -> None:
    harness.compute_all()
    by_age = [file for file in files(harness) if file.name in ("state.npz", "film.npz")]
    for hours, file in enumerate(by_age, start=2):
        moment = time.time() - hours * HOUR
        os.utime(harness.artifacts.path(file), (moment, moment))
    bucket(harness).remove(by_age[-1].path)
    total = sum(file.size for file in files(harness))
    keep_bucket(harness, artifacts_cache=total - by_age[-1].size - by_age[-2].size)
    here = [harness.artifacts.is_there(file) for file in by_age]
    assert here == [True, True, False, True]  # the oldest is in no bucket, and stays
    keep_bucket(harness, artifacts_cache=0)
    assert {file.name for file in files(harness) if harness.artifacts.is_there(file)} >= {"result.json", "cube.nc"}
    assert [harness.artifacts.is_there(file) for file in by_age] == [False, False, False, True]


# --- files that rot -------------------------------------------------------------------------------


def test_rot__of_one_copy_is_mended_and_of_both_is_made_again(harness: Harness) -> None:
    harness.compute_all()
    registered = {file.name: file for file in files(harness) if run_id(1) not in file.path}
    whole = {file.path: harness.artifacts.path(file).read_bytes() for file in files(harness)}
    put(harness, registered["state.npz"].path, b"rot")
    harness.artifacts.path(registered["film.npz"]).write_bytes(b"rot")
    harness.artifacts.path(registered["log.txt"]).unlink()  # no more than a smaller cache
    bucket(harness).remove(registered["result.json"].path)  # as before there was a bucket
    put(harness, registered["cube.nc"].path, b"rot")
    harness.artifacts.path(registered["cube.nc"]).unlink()
    harness.scrubber().step()
    assert harness.store.retention.scrub().whole[1:] == [len(whole), 3]  # a file that was in no bucket is not damaged
    for name in ("state.npz", "film.npz", "result.json"):
        path = registered[name].path
        assert bytes(bucket(harness).files.cat_file(bucket(harness)._path(path))) == whole[path]
        assert harness.artifacts.path(registered[name]).read_bytes() == whole[path]
    assert not harness.artifacts.path(registered["log.txt"]).exists()
    assert harness.run(0).attempt == 1
    assert [sweep.state for sweep in harness.store.sweeps.page().items] == [SweepState.PUBLISHING]


def test_scrub__of_a_bucket_that_is_away_finds_no_damage(harness: Harness) -> None:
    harness.compute_all()
    for file in files(harness):
        harness.artifacts.path(file).unlink()
    with away("_open", "exists", "info"), pytest.raises(FilesAway):
        harness.scrubber().step()
    assert harness.store.retention.scrub().files == 0
    assert [sweep.state for sweep in harness.store.sweeps.page().items] == [SweepState.SUCCEEDED]


# --- whose bucket it is ---------------------------------------------------------------------------


def test_emptied_directory__of_a_bucket_is_taken_and_the_bucket_of_another_database_is_not(tmp_path: Path) -> None:
    url = f"sqlite:///{tmp_path / 'whipple.db'}"
    here, there = (
        settings_in(tmp_path / name, database_url=url, artifacts=f"memory://{tmp_path.name}") for name in ("a", "b")
    )
    with closing(open_store(here)) as store:
        identity.settle(here, store)
        identity.settle(there, store)
        assert identity.read(here.data) == identity.read(there.data) is not None
        other = settings_in(tmp_path / "c", artifacts=here.artifacts)
        other.data.mkdir()
        with closing(open_store(other)) as another, pytest.raises(identity.WrongDirectory, match="another prefix"):
            identity.settle(other, another)
        identity.adopt(other.model_copy(update={"database_url": url}), store)
        with away("exists"), pytest.raises(FilesAway, match="doctor"):
            identity.settle(here, store)


def test_doctor__says_whether_the_bucket_can_be_written_to(tmp_path: Path) -> None:
    settings = settings_in(tmp_path, artifacts="memory://doctor")
    [check] = check_bucket(settings)
    assert (check.status, check.detail) == (CheckStatus.OK, "memory://doctor is writable")
    with away("pipe_file"):
        [check] = check_bucket(settings)
    assert (check.status, "Could not connect" in check.detail) == (CheckStatus.ERROR, True)
    assert [*check_bucket(settings_in(tmp_path))] == []


def test_mounted_disk__is_a_bucket_too(tmp_path: Path) -> None:
    here, mounted = tmp_path / "file", ObjectBucket(f"file://{tmp_path}/mounted")
    here.write_bytes(b"...")
    assert mounted.identity() is None
    mounted.identify("whose")
    mounted.put(here, "runs/ab/file")
    mounted.get("runs/ab/file", tmp_path / "back")
    assert (tmp_path / "back").read_bytes() == b"".join(mounted.chunks("runs/ab/file")) == b"..."
    assert (mounted.identity(), mounted.names("runs"), mounted.size("runs/ab/none")) == (
        "whose",
        ["runs/ab/file"],
        None,
    )
    assert mounted.age("runs/ab/file") < DEADLINE
    mounted.remove("runs/ab/file")
    assert mounted.names("runs") == []


def test_bucket__that_no_library_opens_is_refused_with_a_cure() -> None:
    with pytest.raises(InvalidInput, match="pip install"):
        Artifacts.of(Settings(artifacts="gs://bucket"))
