"""Files that rot on the disk: all of them are found, made again, and never served."""

import os
import random
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path

import numpy as np
import pytest
from fastapi.testclient import TestClient

from service.api.app import build_app
from service.queue import data_identity as identity
from service.records.jobs import Keep, Stored, StoreUnavailable, SweepState
from service.scrubbing.scrubber import FILES_AT_ONCE, Scrubber
from service.store.publications import LOST, MOST_AT_ONCE
from solver.checkpoints import Carried, CheckpointRefused, read_checkpoint, write_checkpoint
from tests.claims.marked import Compared
from tests.claims.rows import equal
from tests.service.support.api import ADDRESS, FakeDispatcher
from tests.service.support.fakes import DEADLINE, failing, runs_of
from tests.service.support.harness import Harness, open_harness

SEED = 20261126
SWEEPS, RUNS = 4, 4  # each sweep with so many runs of its own
KINDS = ("result.json", "state.npz", "film.npz", "cube.nc", "report.html")
EACH = 4  # files of each kind that rot


@pytest.fixture
def harness(tmp_path: Path) -> Iterator[Harness]:
    """A store with published sweeps whose runs keep films."""
    with open_harness(tmp_path) as opened:
        opened.engine.free = RUNS
        for number in range(SWEEPS):
            opened.submit(runs_of(*["fine"] * RUNS, first=RUNS * number), keep=Keep.FILM)
        opened.compute_all()
        yield opened


def passed(harness: Harness, scrubbing: Scrubber) -> list[float]:
    """Number of files, and of damaged ones, of a pass."""
    scrubbing.step()
    return list(harness.store.retention.scrub().whole[1:])


def rot(file: Path, generator: random.Random) -> None:
    """Flip a bit of a file, and leave its size and date as they are."""
    content, status = bytearray(file.read_bytes()), file.stat()
    content[generator.randrange(len(content))] ^= 1 << generator.randrange(8)
    file.write_bytes(content)
    os.utime(file, ns=(status.st_atime_ns, status.st_mtime_ns))


def registered(harness: Harness) -> list[tuple[str, Stored]]:
    return list(harness.store.retention.files())


@pytest.mark.claim("doors", "rot")
def test_rot__is_all_found_in_one_pass_made_again_and_never_served(harness: Harness, compared: Compared) -> None:
    """A pass finds all of 20 flipped bits in results, states, films, cubes and reports; none is served, all are mended.

    The first five are made again at once, and the others when people allow more; checkpoints that rot are refused.
    """
    generator = random.Random(SEED)
    http = TestClient(build_app(harness.settings, harness.store, FakeDispatcher()), base_url=ADDRESS)
    sweeps = [sweep.id for sweep in harness.store.sweeps.page().items]
    jobs = {file.path: job for job, file in registered(harness)}
    address = {
        file.path: f"/v1/sweeps/{sweep}/{file.name}"
        for sweep in sweeps
        for file in harness.store.publications.files(sweep)
    }
    files = [file for _, file in registered(harness)]
    rotten = [each for name in KINDS for each in generator.sample([file for file in files if file.name == name], EACH)]
    where = {file: address.get(file.path, f"/v1/runs/{jobs[file.path]}/files/{file.name}") for file in rotten}
    assert all(http.get(place).status_code == 200 for place in where.values())  # the digests are known
    for file in rotten:
        rot(harness.artifacts.path(file), generator)
    bytes_of = {file: harness.artifacts.path(file).read_bytes() for file in rotten}

    def served() -> int:
        return sum(http.get(place).content == bytes_of[file] for file, place in where.items())

    scrubbing = harness.scrubber(interval=DEADLINE)
    compared(equal("files, and damaged ones", expected=[len(files), len(rotten)], got=passed(harness, scrubbing)))
    compared(equal("served after the pass", expected=0, got=served()))
    lost = [event for event in harness.store.events.all() if event.kind == LOST]
    compared(equal("made again at once", expected=MOST_AT_ONCE, got=len(lost)))
    harness.compute_all()
    harness.store.queue.allow_forgetting(len(rotten))
    for _ in rotten:
        scrubbing.step()
    harness.compute_all()
    damaged = [file for _, file in registered(harness) if not harness.artifacts.is_intact(file)]
    compared(equal("damaged files, once people allow more", expected=[], got=damaged))
    compared(equal("served in the end", expected=0, got=served()))
    states = {sweep.state for sweep in harness.store.sweeps.page().items}
    compared(equal("states of the sweeps", expected={SweepState.SUCCEEDED}, got=states))
    compared(equal("the next pass", expected=[len(files), 0], got=passed(harness, harness.scrubber())))
    compared(equal("checkpoints that are read", expected=0, got=checkpoints_read(harness.settings.data, generator)))


def checkpoints_read(folder: Path, generator: random.Random) -> int:
    """How many of some rotten checkpoints a run would go on from."""
    file, read = folder / "checkpoint.npz", 0
    for _ in range(EACH):
        write_checkpoint(file, {"problem": "a"}, Carried({"step": 7}, {"position": np.arange(100.0)}))
        rot(file, generator)
        with suppress(CheckpointRefused):
            read_checkpoint(file, {"problem": "a"})
            read += 1
    return read


def test_step__reads_no_more_than_is_due(harness: Harness) -> None:
    slow = harness.scrubber(rate=1)  # bytes a second: opening a file counts for an hour of it
    for _ in range(100):
        slow.step()
    assert harness.store.retention.scrub().files == 0


def test_pass__that_was_interrupted_goes_on_where_it_was(harness: Harness) -> None:
    files = registered(harness)
    job, file = files[len(files) // 2]
    rot(harness.artifacts.path(file), random.Random(SEED))
    with failing(harness.store.publications, "mend"), pytest.raises(StoreUnavailable):
        harness.scrubber().step()
    noted = harness.store.retention.scrub()
    assert (noted.files, noted.damaged) == (len(files) // 2, 0)
    assert (noted.job_id, noted.name) < (job, file.name)
    assert passed(harness, harness.scrubber()) == [len(files), 1]


def test_pass__begins_when_the_last_one_is_old_and_takes_further_files(harness: Harness) -> None:
    files = len(registered(harness))
    assert passed(harness, harness.scrubber()) == [files, 0]
    harness.submit(runs_of(*["fine"] * 8, first=100))
    harness.compute_all()
    assert files < FILES_AT_ONCE < len(registered(harness))
    assert passed(harness, harness.scrubber(interval=DEADLINE)) == [files, 0]
    assert passed(harness, harness.scrubber()) == [len(registered(harness)), 0]


def test_files__of_a_disk_that_is_away_stay_registered(harness: Harness) -> None:
    files = registered(harness)
    identity.settle(harness.settings, harness.store)
    away = harness.settings.data.rename(harness.settings.data.with_name("away"))
    harness.settings.data.mkdir()
    for database in away.glob("whipple.db*"):  # which is on another disk
        database.rename(harness.settings.data / database.name)
    with pytest.raises(identity.WrongDirectory):
        harness.scrubber().step()
    assert registered(harness) == files
