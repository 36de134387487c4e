"""What goes from the data directory, what stays, and that no row ever points to a missing file."""

import os
import time
from collections.abc import Iterator
from dataclasses import replace
from itertools import pairwise
from pathlib import Path

import pytest

from service.files.disk_space import Space
from service.queue.clock_watch import ClockWatch
from service.queue.garbage_collection import MOST_REMOVED, GarbageCollector
from service.records.jobs import Cause, Keep, NotFound, State, StoreUnavailable
from service.workers.attempt import Attempt
from service.workers.timings import Timings
from tests.service.support.fakes import DEADLINE, failing, run_id, runs_of
from tests.service.support.harness import Harness, open_harness

HOUR, DAY = 3600.0, 24 * 3600.0
FULL = 1 << 60  # bytes: a reserve that no disk has


@pytest.fixture
def harness(tmp_path: Path) -> Iterator[Harness]:
    with open_harness(tmp_path, retire_seconds=DAY) as opened:
        yield opened


def collector(harness: Harness, *, reserve: int = 0, **timings: float) -> GarbageCollector:
    """A collector at the begin of a round."""
    space = Space(harness.settings.data, reserve)
    clock = ClockWatch(harness.settings, harness.store)
    return GarbageCollector(harness.settings, harness.store, harness.artifacts, space, clock, Timings(**timings))


def collect(harness: Harness, *, reserve: int = 0) -> None:
    """Go three times round the directory, with the files of the first runs; then every row points to a whole file."""
    going = collector(harness, reserve=reserve, collection_step=DEADLINE)
    for _ in range(3):
        going.step()
    assert all(harness.artifacts.is_intact(file) for _, file in harness.store.retention.files())


def make_old(path: Path, *, seconds: float = 2 * DAY) -> None:
    """Let everything there be written long ago."""
    moment = time.time() - seconds
    for entry in (*path.rglob("*"), path):
        os.utime(entry, (moment, moment))


def lost_and_finished(harness: Harness) -> tuple[Path, Path]:
    """A run whose first attempt was lost and whose second has a result: their folders."""
    [lost] = harness.begin(1)
    harness.compute(lost)
    (Path(lost.directory) / "result.json").unlink()
    harness.end_badly(lost, Cause.LOST)
    [counted] = harness.tick()
    harness.end_well(counted)
    harness.tick()
    return Path(lost.directory), Path(counted.directory)


def checkpoint_of(attempt: Attempt) -> Path:
    file = Path(attempt.checkpoint or "")
    file.parent.mkdir(parents=True, exist_ok=True)
    file.write_text("7")
    return file


def temporary(file: Path) -> Path:
    half = file.with_name(f".{file.name}.abc.part")
    half.parent.mkdir(parents=True, exist_ok=True)
    half.write_text("ha")
    return half


def test_lost_attempt__goes_at_once_when_the_disk_is_full(harness: Harness) -> None:
    lost, counted = lost_and_finished(harness)
    no_row_is_written = failing(harness.store.retention, "drop", "forget_runs")
    with no_row_is_written, pytest.raises(StoreUnavailable):
        collector(harness, reserve=FULL).step()
    assert not lost.exists()
    assert counted.is_dir()


def test_attempt_under_way__stays_however_old_it_is(harness: Harness) -> None:
    [attempt] = harness.begin(1)
    half = temporary(Path(attempt.directory) / "state.npz")
    make_old(harness.settings.data / "runs")
    collect(harness, reserve=FULL)
    assert half.is_file()


def test_unknown_folders__stay(harness: Harness) -> None:
    run = harness.artifacts.run_folder(run_id(77)) / "a1-c0ffee00"
    sweep = harness.artifacts.sweep_folder(run_id(78)) / "a1-c0ffee00"
    for folder in (run, sweep, sweep.with_name("a2-c0ffee00")):
        folder.mkdir(parents=True)
    make_old(harness.settings.data)
    harness.tick()
    collect(harness, reserve=FULL)
    assert run.is_dir()
    assert sweep.is_dir()


def test_checkpoint__of_a_run_under_way_stays_without_old_temporary_files(harness: Harness) -> None:
    [attempt] = harness.begin(1)
    checkpoint = checkpoint_of(attempt)
    half = temporary(checkpoint)
    make_old(half, seconds=DAY / 2)
    collect(harness, reserve=FULL)
    assert half.exists()
    make_old(half)
    collect(harness)
    assert checkpoint.is_file()
    assert not half.exists()


@pytest.mark.parametrize("is_cancelled", [False, True])
def test_checkpoint__of_a_run_without_result_stays_for_a_retry(harness: Harness, is_cancelled: bool) -> None:
    id = harness.submit(1)
    [attempt] = harness.tick()
    checkpoint = checkpoint_of(attempt)
    if is_cancelled:
        harness.store.sweeps.cancel(id)
    harness.end_badly(attempt, Cause.LOST if is_cancelled else Cause.TIME_LIMIT)
    harness.tick()
    collect(harness)
    assert checkpoint.is_file()
    make_old(checkpoint)
    collect(harness)
    assert not checkpoint.exists()


@pytest.mark.parametrize("other", [None, Keep.FINAL])
def test_final_state__stays_as_long_as_a_sweep_retains_it(harness: Harness, other: Keep | None) -> None:
    harness.submit(1, keep=Keep.NUMBERS)
    if other is not None:
        harness.submit(runs_of("fine"), keep=other)
    [attempt] = harness.tick()
    harness.end_well(attempt)
    harness.tick()
    collect(harness)
    state = Path(attempt.directory) / "state.npz"
    names = {file.name for file in harness.store.runs.files(run_id(0))}
    assert state.is_file() is ("state.npz" in names) is (other is not None)
    assert names >= {"result.json", "log.txt"}


def publish(harness: Harness) -> Path:
    """Fail the run of a sweep and publish it; the folder of the publication."""
    harness.end_badly(harness.tick()[0], Cause.ERROR)
    return Path(harness.publish().directory)


def test_publication__that_was_replaced_goes_when_it_is_old_and_all_with_the_sweep(harness: Harness) -> None:
    id = harness.submit(runs_of("raise"))
    first = publish(harness)
    harness.store.sweeps.retry(id)
    second = publish(harness)
    make_old(second.parent)
    collect(harness)
    assert (first.exists(), second.is_dir()) == (False, True)
    harness.store.sweeps.delete(id)
    collect(harness)
    assert not second.parent.exists()


def test_run_without_sweep__is_forgotten_after_a_long_time(harness: Harness) -> None:
    id = harness.submit(1)
    [attempt] = harness.tick()
    harness.end_well(attempt)
    harness.end_well(harness.tick()[0])
    harness.tick()
    harness.store.sweeps.delete(id)
    folder = Path(attempt.directory).parent
    collect(harness)
    assert (folder.is_dir(), harness.run().state) == (True, State.SUCCEEDED)
    settings = harness.settings.model_copy(update={"forget_seconds": 1e-9})
    collect(replace(harness, settings=settings))
    assert not folder.exists()
    with pytest.raises(NotFound):
        harness.run()


def test_sweep__that_has_expired_is_deleted_unless_it_is_pinned(harness: Harness) -> None:
    kept, gone = (harness.submit(runs_of("fine", first=number)) for number in (1, 2))
    harness.compute_all()
    harness.store.sweeps.pin(kept, pinned=True)
    for days, left in ((1.0, {kept, gone}), (1e-9, {kept})):
        settings = harness.settings.model_copy(update={"retention_days": days})
        collector(replace(harness, settings=settings)).step()
        assert {sweep.id for sweep in harness.store.sweeps.page().items} == left


def test_step__removes_so_many_folders_at_most(harness: Harness) -> None:
    folder = Path(harness.begin(1)[0].directory).parent
    for number in range(2 * MOST_REMOVED):
        (folder / f"a1-{number:08x}").mkdir(parents=True)
    make_old(folder)
    going = collector(harness)
    counts = [len([*folder.iterdir()])]
    for _ in range(8):
        going.step()
        counts.append(len([*folder.iterdir()]))
    removed = [before - after for before, after in pairwise(counts)]
    assert max(removed) == MOST_REMOVED
    assert sum(removed) == 2 * MOST_REMOVED
