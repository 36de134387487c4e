"""What goes from the data directory, what stays, and that rows never point to nothing."""

import os
import time
from collections.abc import Iterator
from itertools import pairwise
from pathlib import Path
from typing import Any

import pytest

from service.files.artifacts import Artifacts
from service.files.disk_space import Space
from service.queue.garbage_collection import REMOVED, GarbageCollector
from service.queue.orphans import PART_OF_ALL
from service.records.jobs import Cause, Keep, NotFound, State, StoreUnavailable
from tests.service.support.fakes import run_id, runs_of, sweep_of
from tests.service.support.harness import Harness, open_harness

DAY = 24 * 3600.0


@pytest.fixture
def harness(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Harness]:
    monkeypatch.setenv("NUMBA_NUM_THREADS", "1")
    with open_harness(tmp_path, retire_seconds=DAY) as opened:
        yield opened


def care_of(harness: Harness) -> GarbageCollector:
    """At the begin of a round."""
    return GarbageCollector(
        harness.settings,
        harness.store,
        Artifacts(harness.settings.data),
        Space(harness.settings.data, harness.settings.disk_reserve),
    )


def go_round(harness: Harness) -> None:
    """Care, once round the whole directory and a little further."""
    care = care_of(harness)
    for _ in range(30):
        care.step()


def make_old(path: Path, *, seconds: float = 2 * DAY) -> None:
    """Everything there was written long ago."""
    moment = time.time() - seconds
    for one in (*path.rglob("*"), path):
        os.utime(one, (moment, moment))


def attempts_of(harness: Harness, number: int = 0) -> list[str]:
    """Names of the attempts of a run that have a folder."""
    folder = Artifacts(harness.settings.data).run_folder(run_id(number))
    return sorted(entry.name for entry in folder.glob("a*"))


def all_is_intact(harness: Harness) -> bool:
    """Whether every row points to a whole file."""
    artifacts = Artifacts(harness.settings.data)
    return all(artifacts.is_intact(file) for _, file in harness.store.files())


def lost_and_finished(harness: Harness) -> tuple[Path, Path]:
    """A run whose first attempt was lost and whose second has a result: their folders."""
    harness.store.create_sweep(sweep_of(1))
    [lost] = harness.turn()
    harness.compute(lost)
    (Path(lost.directory) / "result.json").unlink()
    harness.end_badly(lost, Cause.LOST)
    [counted] = harness.turn()
    harness.end_well(counted)
    harness.turn()
    return Path(lost.directory), Path(counted.directory)


# --- attempts ------------------------------------------------------------------------------------


def test_lost_attempt__goes_when_it_is_old(harness: Harness) -> None:
    lost, counted = lost_and_finished(harness)
    go_round(harness)
    assert lost.is_dir()
    make_old(harness.settings.data / "runs")
    go_round(harness)
    assert not lost.exists()
    assert counted.is_dir()
    assert all_is_intact(harness)


def test_lost_attempt__goes_at_once_when_the_disk_is_full(
    harness: Harness, monkeypatch: pytest.MonkeyPatch
) -> None:
    lost, counted = lost_and_finished(harness)
    monkeypatch.setattr(Space, "is_short", lambda _self: True)
    go_round(harness)
    assert not lost.exists()
    assert counted.is_dir()
    assert all_is_intact(harness)


def test_lost_attempt__goes_though_no_row_can_be_written(
    harness: Harness, monkeypatch: pytest.MonkeyPatch
) -> None:
    def away(*_arguments: Any) -> Any:
        raise StoreUnavailable("database or disk is full")

    lost, _ = lost_and_finished(harness)
    make_old(harness.settings.data / "runs")
    for name in ("drop", "forget_runs"):
        monkeypatch.setattr(harness.store, name, away)
    with pytest.raises(StoreUnavailable):
        care_of(harness).step()
    assert not lost.exists()


def test_attempt_under_way__stays_however_old_it_is(harness: Harness) -> None:
    harness.store.create_sweep(sweep_of(1))
    [ticket] = harness.turn()
    Path(ticket.directory).mkdir(parents=True)
    (Path(ticket.directory) / ".state.npz.x.part").write_text("half")
    make_old(harness.settings.data / "runs")
    go_round(harness)
    assert [entry.name for entry in Path(ticket.directory).iterdir()] == [".state.npz.x.part"]


def test_attempt_that_failed__stays_with_its_log(harness: Harness) -> None:
    harness.store.create_sweep(sweep_of(1))
    [ticket] = harness.turn()
    harness.compute(ticket)
    harness.end_badly(ticket, Cause.ERROR)
    harness.turn()
    make_old(harness.settings.data / "runs")
    go_round(harness)
    assert (Path(ticket.directory) / "log.txt").is_file()


def test_file_of_a_row__stays_even_in_a_folder_that_does_not_count(
    harness: Harness, monkeypatch: pytest.MonkeyPatch
) -> None:
    lost, counted = lost_and_finished(harness)
    last = harness.store.known_attempts([run_id(0)])
    monkeypatch.setattr(
        harness.store,
        "known_attempts",
        lambda _ids: {id: type(one)(9, "0123abcd", one.state) for id, one in last.items()},
    )
    make_old(harness.settings.data / "runs")
    go_round(harness)
    assert counted.is_dir()
    assert not lost.exists()


def test_stranger__is_told_of_and_never_removed(harness: Harness) -> None:
    artifacts = Artifacts(harness.settings.data)
    folder = artifacts.run_folder(run_id(77)) / "a1-c0ffee00"
    folder.mkdir(parents=True)
    sweep = artifacts.sweep_folder(run_id(78)) / "a1-c0ffee00"
    sweep.mkdir(parents=True)
    (sweep.parent / "a2-c0ffee00").mkdir()
    make_old(harness.settings.data)
    harness.turn()
    go_round(harness)
    assert folder.is_dir()
    assert sweep.is_dir()


# --- checkpoints and half-written files ------------------------------------------------------------


def test_checkpoint__of_a_run_that_has_ended_goes(harness: Harness) -> None:
    _, counted = lost_and_finished(harness)
    left = counted.parent / "checkpoint.npz", counted.parent / "checkpoint.film.npz"
    for file in left:
        file.write_text("7")
    go_round(harness)
    assert not any(file.exists() for file in left)


def test_checkpoint__of_a_run_that_goes_on_stays(harness: Harness) -> None:
    harness.store.create_sweep(sweep_of(1))
    [ticket] = harness.turn()
    checkpoint = Path(ticket.checkpoint or "")
    checkpoint.parent.mkdir(parents=True, exist_ok=True)
    checkpoint.write_text("7")
    half = checkpoint.parent / f".{checkpoint.name}.abc.part"
    half.write_text("ha")
    make_old(half)
    go_round(harness)
    assert checkpoint.is_file()
    assert not half.exists()


def half_written(file: Path) -> Path:
    """Half of a file, as if its writer was at it."""
    half = file.with_name(f".{file.name}.abc.part")
    half.parent.mkdir(parents=True, exist_ok=True)
    half.write_text("ha")
    return half


def test_half_of_a_checkpoint__stays_while_its_run_is_under_way_and_the_disk_is_full(
    harness: Harness, monkeypatch: pytest.MonkeyPatch
) -> None:
    harness.store.create_sweep(sweep_of(1))
    [ticket] = harness.turn()
    half = half_written(Path(ticket.checkpoint or ""))
    make_old(half, seconds=DAY / 2)
    monkeypatch.setattr(Space, "is_short", lambda _self: True)
    go_round(harness)
    assert half.exists()


@pytest.mark.parametrize("name", ["checkpoint.npz", "a2/result-0123.json"])
def test_half_written__goes_after_a_while_when_the_disk_is_full(
    harness: Harness, monkeypatch: pytest.MonkeyPatch, name: str
) -> None:
    _, counted = lost_and_finished(harness)
    half = half_written(counted.parent / name.replace("a2", counted.name))
    monkeypatch.setattr(Space, "is_short", lambda _self: True)
    go_round(harness)
    assert half.exists()
    make_old(half, seconds=3600)
    go_round(harness)
    assert not half.exists()


def test_checkpoint__of_a_cancelled_run_stays_for_the_next_who_asks(harness: Harness) -> None:
    row = harness.store.create_sweep(sweep_of(1))
    [ticket] = harness.turn()
    checkpoint = Path(ticket.checkpoint or "")
    checkpoint.parent.mkdir(parents=True, exist_ok=True)
    checkpoint.write_text("7")
    harness.store.cancel_sweep(row.id)
    harness.end_badly(ticket, Cause.LOST)
    harness.turn()
    go_round(harness)
    assert checkpoint.is_file()
    make_old(checkpoint)
    go_round(harness)
    assert not checkpoint.exists()


# --- what sweeps keep ------------------------------------------------------------------------------


def test_keep__numbers_lets_the_final_state_go(harness: Harness) -> None:
    harness.store.create_sweep(sweep_of(1), keep=Keep.NUMBERS)
    [ticket] = harness.turn()
    harness.end_well(ticket)
    harness.turn()
    go_round(harness)
    assert not (Path(ticket.directory) / "state.npz").exists()
    assert {file.name for file in harness.store.run_files(run_id(0))} == {"result.json", "log.txt"}
    assert all_is_intact(harness)


def test_keep__what_one_of_two_sweeps_keeps_stays(harness: Harness) -> None:
    harness.store.create_sweep(sweep_of(1), keep=Keep.NUMBERS)
    harness.store.create_sweep(sweep_of(1, name="other"), keep=Keep.FINAL)
    [ticket] = harness.turn()
    harness.end_well(ticket)
    harness.turn()
    go_round(harness)
    assert (Path(ticket.directory) / "state.npz").is_file()


def test_checkpoint__of_a_run_that_failed_stays_for_a_retry(harness: Harness) -> None:
    harness.store.create_sweep(sweep_of(1))
    [ticket] = harness.turn()
    checkpoint = Path(ticket.checkpoint or "")
    checkpoint.parent.mkdir(parents=True, exist_ok=True)
    checkpoint.write_text("7")
    harness.end_badly(ticket, Cause.TIME_LIMIT)
    harness.turn()
    go_round(harness)
    assert checkpoint.is_file()
    make_old(checkpoint)
    go_round(harness)
    assert not checkpoint.exists()


def test_keep__a_kill_between_row_and_file_is_made_good(
    harness: Harness, monkeypatch: pytest.MonkeyPatch
) -> None:
    harness.store.create_sweep(sweep_of(1), keep=Keep.NUMBERS)
    [ticket] = harness.turn()
    harness.end_well(ticket)
    harness.engine.free = 0
    with monkeypatch.context() as patch:
        patch.setattr(GarbageCollector, "step", lambda _self: None)
        harness.turn()
    harness.store.forget_files(run_id(0), ["state.npz"])  # and then the process was killed
    state = Path(ticket.directory) / "state.npz"
    go_round(harness)
    assert state.is_file()
    make_old(state)
    go_round(harness)
    assert not state.exists()


# --- sweeps --------------------------------------------------------------------------------------


def published(harness: Harness, *, name: str = "asked") -> str:
    """A sweep of a run that fails, published; its id."""
    row = harness.store.create_sweep(sweep_of(runs_of("raise"), name=name))
    harness.end_badly(harness.turn()[0], Cause.ERROR)
    harness.end_well(harness.turn()[0])
    harness.turn()
    return row.id


def test_sweep_that_was_deleted__loses_its_files(harness: Harness) -> None:
    id = published(harness)
    folder = harness.settings.data / "sweeps" / id
    assert folder.is_dir()
    harness.store.delete_sweep(id)
    harness.turn()
    go_round(harness)
    assert not folder.exists()


def test_publication_that_was_replaced__goes_when_it_is_old(harness: Harness) -> None:
    id = published(harness)
    folder = harness.settings.data / "sweeps" / id
    [first] = folder.iterdir()
    harness.store.retry_sweep(id)
    harness.end_badly(harness.turn()[0], Cause.ERROR)
    [publication] = harness.turn()
    harness.end_well(publication)
    make_old(first)
    go_round(harness)
    harness.turn()
    make_old(folder)
    go_round(harness)
    assert [str(entry) for entry in folder.iterdir()] == [publication.directory]
    assert all_is_intact(harness)


# --- runs of nobody --------------------------------------------------------------------------------


def deleted(harness: Harness) -> Path:
    """The folder of a run whose only sweep is deleted."""
    row = harness.store.create_sweep(sweep_of(1))
    [ticket] = harness.turn()
    harness.end_well(ticket)
    harness.end_well(harness.turn()[0])
    harness.turn()
    harness.store.delete_sweep(row.id)
    return Path(ticket.directory).parent


def test_run_of_nobody__is_forgotten_after_a_long_time(
    harness: Harness, monkeypatch: pytest.MonkeyPatch
) -> None:
    folder = deleted(harness)
    go_round(harness)
    assert (folder.is_dir(), harness.run().state) == (True, State.SUCCEEDED)
    settings = harness.settings.model_copy(update={"forget_seconds": 1e-9})
    monkeypatch.setattr(harness, "settings", settings)
    go_round(harness)
    assert not folder.exists()
    with pytest.raises(NotFound):
        harness.run()


# --- how much at once ------------------------------------------------------------------------------


def test_step__removes_no_more_than_so_much(harness: Harness) -> None:
    harness.store.create_sweep(sweep_of(1))
    [ticket] = harness.turn()
    folder = Path(ticket.directory).parent
    for number in range(2 * REMOVED):
        (folder / f"a1-{number:08x}").mkdir(parents=True)
    make_old(folder)
    settings, artifacts = harness.settings, Artifacts(harness.settings.data)
    care = GarbageCollector(settings, harness.store, artifacts, Space(settings.data, 0))
    counts = [len(attempts_of(harness))]
    for _ in range(8):
        care.step()
        counts.append(len(attempts_of(harness)))
    gone = [before - after for before, after in pairwise(counts)]
    assert max(gone) == REMOVED
    assert sum(gone) == 2 * REMOVED


def test_step__looks_no_longer_than_a_moment(
    harness: Harness, monkeypatch: pytest.MonkeyPatch
) -> None:
    looked: list[int] = []
    known = harness.store.known_attempts
    harness.store.known_attempts = lambda ids: looked.append(len(list(ids))) or known(ids)  # type: ignore
    settings, artifacts = harness.settings, Artifacts(harness.settings.data)
    for number in range(PART_OF_ALL + 10):
        artifacts.run_folder(run_id(number)).mkdir(parents=True)
    monkeypatch.setattr("service.queue.garbage_collection.STEP_SECONDS", 0.0)
    care = GarbageCollector(settings, harness.store, artifacts, Space(settings.data, 0))
    care.step()
    assert looked == [PART_OF_ALL]
    care.step()
    assert looked == [PART_OF_ALL, 10]


def test_step__reads_the_files_of_its_runs_alone(
    harness: Harness, monkeypatch: pytest.MonkeyPatch
) -> None:
    lost_and_finished(harness)
    monkeypatch.setattr(harness.store, "files", None)  # pages of everything
    go_round(harness)
    assert all(file.name != "state.npz" for _, file in harness.store.discardable(9))


def test_step__asks_no_more_of_the_store_for_more_runs(harness: Harness) -> None:
    asked: list[int] = []
    known = harness.store.known_attempts
    harness.store.known_attempts = lambda ids: asked.append(len(list(ids))) or known(ids)  # type: ignore
    artifacts = Artifacts(harness.settings.data)
    for number in range(40):
        artifacts.run_folder(run_id(number)).mkdir(parents=True)
    go_round(harness)
    assert set(asked) == {40}
