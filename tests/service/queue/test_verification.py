"""What attempts left is looked at: whether it is a result, in words that rows take, beside the turns."""

import errno
import json
import os
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest

from service.files.artifacts import Artifacts, describe
from service.queue import leader as reign
from service.queue import verification as findings
from service.records.attempt import Ending
from service.records.jobs import Cause, Claim, State, Stored
from tests.service.support.fakes import DEADLINE, run_id, runs_of, sweep_of
from tests.service.support.harness import Harness, open_harness


@pytest.fixture
def harness(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Harness]:
    monkeypatch.setenv("NUMBA_NUM_THREADS", "1")
    with open_harness(tmp_path) as opened:
        yield opened


NO_RESULTS: tuple[object, ...] = (
    {"state": "succeeded"},
    [],
    {"state": "succeeded", "measurements": []},
    None,
)


@pytest.mark.parametrize("answer", NO_RESULTS)
def test_result_that_is_none__is_no_result(harness: Harness, answer: object) -> None:
    harness.store.create_sweep(sweep_of(1))
    for _ in range(3):
        [ticket] = harness.turn()
        harness.compute(ticket)
        file = Path(ticket.directory) / "result.json"
        file.write_text(json.dumps(answer))
        harness.end(ticket, Ending(None, "", "", (describe(file),), 1.0))
    harness.turn()
    run = harness.run()
    assert (run.state, run.cause) == (State.FAILED, Cause.CRASH)
    assert "cannot be registered" in str(run.reason)


def test_reason__that_no_database_takes_is_made_legible(
    tmp_path: Path, database_url: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("NUMBA_NUM_THREADS", "1")
    with open_harness(tmp_path, database_url=database_url) as harness:
        harness.store.create_sweep(sweep_of(2))
        crashed, failed = harness.turn()
        words = "cannot read 'caf\udce9.toml'\0" + 5000 * "!"
        harness.end_badly(crashed, Cause.CRASH, reason=words)
        harness.end_badly(failed, Cause.ERROR, reason=words, failure="\0")
        harness.turn()
        assert [harness.run(number).state for number in (0, 1)] == [State.RUNNING, State.FAILED]
        assert str(harness.run(1).reason).startswith("cannot read 'caf\ufffd.toml'\ufffd!")


def test_verdict__that_no_database_takes_is_made_legible(
    tmp_path: Path, database_url: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("NUMBA_NUM_THREADS", "1")
    with open_harness(tmp_path, database_url=database_url) as harness:
        harness.store.create_sweep(sweep_of(runs_of("verdict")))
        [ticket] = harness.turn()
        harness.compute(ticket)
        file = Path(ticket.directory) / "result.json"
        answer = json.loads(file.read_text())
        file.write_text(json.dumps(answer | {"reason": "at \ud83d\0"}))
        harness.end(ticket, Ending(None, "", "", (describe(file),), 1.0))
        harness.turn()
        assert (harness.run().cause, harness.run().reason) == (Cause.VERDICT, "at \ufffd\ufffd")


# --- a disk that is ill, or late -----------------------------------------------------------------


@contextmanager
def ill(patch: pytest.MonkeyPatch, number: int, *, run: int = 0) -> Iterator[list[Stored]]:
    """Let the files of a run be unreadable until the end of the block; those that were looked at."""
    is_intact, tried = Artifacts.is_intact, list[Stored]()

    def fail(artifacts: Artifacts, file: Stored) -> bool:
        if run_id(run) not in file.path:
            return is_intact(artifacts, file)
        tried.append(file)
        raise OSError(number, os.strerror(number))

    with patch.context() as until_the_end:
        until_the_end.setattr(Artifacts, "is_intact", fail)
        yield tried


@pytest.fixture
def at_once(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(findings, "AGAIN_SECONDS", 0.0)


@pytest.mark.parametrize("cause", [None, Cause.LOST])
@pytest.mark.parametrize(
    "number", [errno.EIO, errno.ESTALE, errno.ENOTCONN, errno.ENOENT, errno.ENOSPC]
)
def test_disk_that_is_ill__is_looked_at_again_and_costs_the_run_nothing(
    harness: Harness,
    at_once: None,
    monkeypatch: pytest.MonkeyPatch,
    number: int,
    cause: Cause | None,
) -> None:
    harness.store.create_sweep(sweep_of(1))
    [ticket] = harness.turn()
    ending = harness.compute(ticket)
    harness.end(ticket, ending if cause is None else Ending(cause, "", "", (), 1.0))
    with ill(monkeypatch, number):
        harness.turn()
        harness.turn()
    harness.turn()
    run = harness.run()
    assert (run.state, run.attempt, run.crashes) == (State.SUCCEEDED, 1, 0)


def test_disk_that_is_ill__counts_when_it_does_not_pass(
    harness: Harness, at_once: None, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(findings, "DOUBT_SECONDS", 0.0)
    harness.store.create_sweep(sweep_of(1))
    [ticket] = harness.turn()
    harness.end_well(ticket)
    with ill(monkeypatch, errno.EIO):
        harness.turn()
        harness.turn()
    assert (harness.run().attempt, harness.run().crashes) == (2, 1)


def test_disk_that_is_ill__is_not_looked_at_in_each_turn(
    harness: Harness, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(findings, "AGAIN_SECONDS", 3600.0)
    harness.store.create_sweep(sweep_of(1))
    [ticket] = harness.turn()
    harness.end_well(ticket)
    with ill(monkeypatch, errno.ENOSPC) as tried:
        for _ in range(3):
            harness.turn()
    assert len(tried) == 1


def test_disk_that_is_ill__for_one_does_not_hold_up_the_others(
    harness: Harness, monkeypatch: pytest.MonkeyPatch
) -> None:
    harness.store.create_sweep(sweep_of(3))
    for ticket in harness.turn():
        harness.end_well(ticket)
    with ill(monkeypatch, errno.ENOSPC):
        assert len(harness.turn()) == 1
    assert [harness.run(number).state for number in (0, 1)] == [State.RUNNING, State.SUCCEEDED]


def test_disk_that_is_late__is_looked_at_again(harness: Harness, at_once: None) -> None:
    harness.store.create_sweep(sweep_of(1))
    [ticket] = harness.turn()
    harness.end_well(ticket)
    state = Path(ticket.directory) / "state.npz"
    whole = state.read_bytes()
    state.write_bytes(whole[:3])
    harness.turn()
    assert (harness.run().state, harness.run().attempt) == (State.RUNNING, 1)
    state.write_bytes(whole)
    harness.turn()
    assert (harness.run().state, harness.run().attempt) == (State.SUCCEEDED, 1)


def after_it_was_described(patch: pytest.MonkeyPatch, name: str) -> None:
    """Let somebody write to a file of an attempt that is found complete on the disk."""
    complete_files = Artifacts.complete_files

    def write(artifacts: Artifacts, claim: Claim) -> tuple[Stored, ...]:
        files = complete_files(artifacts, claim)
        with (artifacts.attempt_directory(claim) / name).open("a") as file:
            file.write("more")
        return files

    patch.setattr(Artifacts, "complete_files", write)


def test_lost_and_complete__a_log_that_grows_is_no_damage(
    harness: Harness, monkeypatch: pytest.MonkeyPatch
) -> None:
    after_it_was_described(monkeypatch, "log.txt")
    harness.store.create_sweep(sweep_of(1))
    [ticket] = harness.turn()
    harness.compute(ticket)
    harness.end_badly(ticket, Cause.LOST)
    harness.turn()
    assert (harness.run().state, harness.run().attempt) == (State.SUCCEEDED, 1)
    files = harness.store.run_files(run_id(0))
    assert {file.name for file in files} == {"result.json", "state.npz"}
    assert all(Artifacts(harness.settings.data).is_intact(file) for file in files)


def test_lost_and_damaged__stays_lost(
    harness: Harness, at_once: None, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(findings, "DOUBT_SECONDS", 0.0)
    after_it_was_described(monkeypatch, "state.npz")
    harness.store.create_sweep(sweep_of(1))
    [ticket] = harness.turn()
    harness.compute(ticket)
    harness.end_badly(ticket, Cause.LOST)
    harness.turn()
    harness.turn()
    assert (harness.run().attempt, harness.run().crashes) == (2, 0)


# --- beside the turns ----------------------------------------------------------------------------


@contextmanager
def slow(patch: pytest.MonkeyPatch, number: int) -> Iterator[None]:
    """Let the digests of a run take until the end of the block."""
    may_go_on, is_intact = threading.Event(), Artifacts.is_intact

    def wait_for_it(artifacts: Artifacts, file: Stored) -> bool:
        if run_id(number) in file.path:
            assert may_go_on.wait(DEADLINE)
        return is_intact(artifacts, file)

    patch.setattr(Artifacts, "is_intact", wait_for_it)
    try:
        yield
    finally:
        may_go_on.set()


def test_large_result__does_not_hold_up_the_turns(
    harness: Harness, monkeypatch: pytest.MonkeyPatch
) -> None:
    harness.store.create_sweep(sweep_of(3))
    large, small = harness.turn()
    with slow(monkeypatch, 0):
        harness.end_well(large)
        monkeypatch.setattr(reign, "WAIT_SECONDS", 0.0)
        assert len(harness.turn()) == 1  # its slot is free
        monkeypatch.setattr(reign, "WAIT_SECONDS", DEADLINE)
        harness.end_well(small)
        harness.turn()
        assert [harness.run(number).state for number in (0, 1)] == [State.RUNNING, State.SUCCEEDED]
        assert harness.run().attempt == 1
    assert harness.inbox is not None
    assert harness.inbox.get(timeout=DEADLINE) is None  # a turn is asked for
    harness.turn()
    assert harness.run().state is State.SUCCEEDED


def test_log_of_a_failure__is_brought_to_the_disk(
    harness: Harness, monkeypatch: pytest.MonkeyPatch
) -> None:
    harness.store.create_sweep(sweep_of(1))
    [ticket] = harness.turn()
    harness.compute(ticket)
    harness.end_badly(ticket, Cause.ERROR)
    reached: list[Path] = []
    monkeypatch.setattr("service.files.artifacts.to_disk", reached.append)
    harness.turn()
    assert Path(ticket.directory) / "log.txt" in reached
