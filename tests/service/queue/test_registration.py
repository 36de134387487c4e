"""Endings become rows: results with all their files, another attempt by the budget of its cause, failures."""

from collections.abc import Callable
from pathlib import Path

import pytest

from service.queue.leader import MOST_REGISTRATIONS
from service.queue.registration import Registrar
from service.queue.retry import FREE_LOSSES
from service.queue.verification import VerifiedEnding
from service.records.jobs import Cause, Kind, Lease, State, StoreUnavailable
from service.workers.attempt import Attempt
from tests.service.support.attempts import computed
from tests.service.support.fakes import failing, run_id
from tests.service.support.harness import Harness
from tests.service.support.targets import FAKE


def checkpoint_of(harness: Harness) -> Path:
    """A checkpoint of the first run, and half of the next one."""
    file = harness.artifacts.checkpoint(run_id(0))
    file.parent.mkdir(parents=True, exist_ok=True)
    file.write_text("7")
    (file.parent / f".{file.name}.abc.part").write_text("half")
    return file


def test_result__its_row_has_files_and_numbers_but_no_history_and_no_checkpoint(harness: Harness) -> None:
    [attempt] = harness.begin(1)
    checkpoint = checkpoint_of(harness)
    harness.end_well(attempt)
    harness.tick()
    row, files = harness.run(), harness.store.runs.files(run_id(0))
    assert {file.name for file in files} == {"result.json", "state.npz", "log.txt"}
    assert all(harness.artifacts.is_intact(file) for file in files)
    assert {harness.artifacts.path(file).parent for file in files} == {Path(attempt.directory)}
    assert (row.state, row.seconds) == (State.SUCCEEDED, 1.5)
    assert row.summary is not None
    measured = row.summary["measurements"]["hole_diameter"]
    assert measured == {"value": measured["value"], "uncertainty": 1e-4, "flags": [], "version": 1}
    assert row.summary.keys() == {"measurements", "flags", "numbers", "stop"}
    assert [entry.name for entry in checkpoint.parent.iterdir()] == [Path(attempt.directory).name]


def test_result__the_engine_keeps_it_until_the_row_has_it(harness: Harness) -> None:
    [attempt] = harness.begin(1)
    harness.end_well(attempt)
    with failing(harness.store.leases, "finish"), pytest.raises(StoreUnavailable):
        harness.tick()
    assert harness.engine.forgotten == []
    harness.tick()
    assert harness.engine.forgotten == [attempt.key]
    assert harness.run().state is State.SUCCEEDED


@pytest.fixture
def tried(monkeypatch: pytest.MonkeyPatch) -> list[Lease]:
    """Leases of the first run that could not be registered; the list is empty as long as nothing was tried."""
    register, leases = Registrar.register, list[Lease]()

    def fail(registrar: Registrar, lease: Lease, verified: VerifiedEnding) -> None:
        if lease.id == run_id(0):
            leases.append(lease)
            raise RuntimeError("an unexpected error")
        register(registrar, lease, verified)

    monkeypatch.setattr(Registrar, "register", fail)
    return leases


def test_ending_that_cannot_be_registered__holds_nobody_up_and_fails_in_the_end(
    harness: Harness, tried: list[Lease]
) -> None:
    attempts = harness.begin(2)
    for attempt in attempts:
        harness.end_well(attempt)
    harness.tick()
    assert [harness.run(number).state for number in (0, 1)] == [State.RUNNING, State.SUCCEEDED]
    for _ in range(MOST_REGISTRATIONS):
        harness.tick()
    assert len(tried) == MOST_REGISTRATIONS
    row = harness.run()
    assert (row.state, row.cause, row.failure) == (State.FAILED, Cause.ERROR, "RuntimeError")
    assert "an unexpected error" in str(row.reason)
    assert set(harness.engine.forgotten) == {attempt.key for attempt in attempts}


def test_crash__progress_beyond_the_checkpoint_starts_the_count_anew(harness: Harness) -> None:
    harness.submit(1)
    for step in (None, None, 100, 100, 200, 300):
        [attempt] = harness.tick()
        harness.end_badly(attempt, Cause.CRASH, checkpoint=step)
    [attempt] = harness.tick()
    assert (attempt.kind, harness.run().attempt) == (Kind.RUN, 7)
    for step in (300, 250):  # a checkpoint that was refused is no progress either
        harness.end_badly(attempt, Cause.CRASH, checkpoint=step)
        [attempt] = harness.tick()
    assert harness.run().state is State.FAILED


def lose(harness: Harness, times: int, step: Callable[[int], int | None]) -> list[Attempt]:
    """Lose a run so often; the attempts that begin then."""
    harness.submit(1)
    for number in range(times):
        [attempt] = harness.tick()
        harness.end_badly(attempt, Cause.LOST, checkpoint=step(number))
    return harness.tick()


def test_lost__again_and_again_delays_the_run_but_no_other(harness: Harness) -> None:
    checkpoint = checkpoint_of(harness)
    assert lose(harness, 1 + FREE_LOSSES, lambda _: None) == []
    assert (harness.run().state, harness.run().crashes) == (State.QUEUED, 0)
    assert checkpoint.read_text() == "7"
    assert [computed(attempt)["materials"][FAKE]["id"] for attempt in harness.begin(2)] == [run_id(1)]
