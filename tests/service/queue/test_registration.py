"""Ends become rows: results with all their files, another try by the budget of its cause, failures."""

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from service.files.artifacts import Artifacts
from service.queue import backoff as rests
from service.queue import leader as reign
from service.queue import verification as findings
from service.queue.registration import Registrar
from service.queue.verification import PASSING, Found
from service.records.attempt import Ending
from service.records.jobs import Cause, Claim, Kind, State, StoreUnavailable, SweepState
from tests.service.support.fakes import run_id, runs_of, sweep_of
from tests.service.support.harness import Harness, open_harness


@pytest.fixture
def harness(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Harness]:
    monkeypatch.setenv("NUMBA_NUM_THREADS", "1")
    with open_harness(tmp_path) as opened:
        yield opened


def checkpoint_of(harness: Harness, number: int = 0) -> Path:
    """A checkpoint as a worker leaves it, and half of the next one."""
    file = Artifacts(harness.settings.data).checkpoint(run_id(number))
    file.parent.mkdir(parents=True, exist_ok=True)
    file.write_text("7")
    (file.parent / f".{file.name}.abc.part").write_text("half")
    return file


# --- registering ---------------------------------------------------------------------------------


def test_whole_path__from_sweep_to_files(harness: Harness) -> None:
    row = harness.store.create_sweep(sweep_of(runs_of("fine", "verdict")))
    for ticket in harness.turn():
        harness.end_well(ticket)
    [publication] = harness.turn()
    harness.end_well(publication)
    harness.turn()
    assert harness.store.sweep(row.id).state is SweepState.SUCCEEDED
    artifacts = Artifacts(harness.settings.data)
    files = harness.store.artifacts(row.id)
    assert {file.name for file in files} == {"cube.nc", "report.html", "report.json", "log.txt"}
    assert all(artifacts.is_intact(file) for file in files)


def test_result__every_file_of_the_attempt_is_registered(harness: Harness) -> None:
    harness.store.create_sweep(sweep_of(1))
    [ticket] = harness.turn()
    harness.end_well(ticket)
    harness.turn()
    files = harness.store.run_files(run_id(0))
    assert {file.name for file in files} == {"result.json", "state.npz", "log.txt"}
    artifacts = Artifacts(harness.settings.data)
    assert all(artifacts.is_intact(file) for file in files)
    assert {artifacts.path(file).parent for file in files} == {Path(ticket.directory)}


def test_result__the_row_has_the_numbers_but_no_history(harness: Harness) -> None:
    harness.store.create_sweep(sweep_of(1))
    harness.end_well(harness.turn()[0])
    harness.turn()
    run = harness.run()
    assert run.state is State.SUCCEEDED
    assert run.seconds == 1.5
    assert run.summary == {
        "measurements": {
            "hole_diameter": {"value": 0.0148, "uncertainty": 1e-4, "flags": [], "version": 1}
        },
        "flags": ["under_resolved"],
        "numbers": {"threads": 1.0},
        "stop": "settled",
    }


def test_result__the_engine_may_forget_it_when_the_row_has_it(
    harness: Harness, monkeypatch: pytest.MonkeyPatch
) -> None:
    def away(*_arguments: Any, **_words: Any) -> bool:
        raise StoreUnavailable("locked")

    harness.store.create_sweep(sweep_of(1))
    [ticket] = harness.turn()
    harness.end_well(ticket)
    with monkeypatch.context() as patch:
        patch.setattr(harness.store, "finish", away)
        with pytest.raises(StoreUnavailable):
            harness.turn()
    assert harness.engine.forgotten == []
    harness.turn()
    assert harness.engine.forgotten == [ticket.key]
    assert harness.run().state is State.SUCCEEDED


def test_result__the_checkpoint_goes_with_its_half_written_successor(harness: Harness) -> None:
    harness.store.create_sweep(sweep_of(1))
    [ticket] = harness.turn()
    checkpoint = checkpoint_of(harness)
    harness.end_well(ticket)
    harness.turn()
    assert [entry.name for entry in checkpoint.parent.iterdir()] == [Path(ticket.directory).name]


def test_publication__is_told_what_there_is_and_why_not(harness: Harness) -> None:
    row = harness.store.create_sweep(sweep_of(runs_of("fine", "raise")))
    good, bad = harness.turn()
    harness.end_well(good)
    harness.end_badly(bad, Cause.ERROR)
    [publication] = harness.turn()
    one, other = publication.spec["outcomes"]
    assert Path(one["path"]).is_file()
    assert (other["path"], other["state"]) == (None, "failed")
    assert other["reason"].startswith("because of error")
    assert publication.spec["document"] == harness.store.sweep_document(row.id)


def test_publication_that_fails_again__leaves_the_earlier_files(harness: Harness) -> None:
    row = harness.store.create_sweep(sweep_of(runs_of("raise")))
    for _ in range(2):
        harness.end_badly(harness.turn()[0], Cause.ERROR)
        [publication] = harness.turn()
        if harness.store.artifacts(row.id):
            harness.end_badly(publication, Cause.ERROR)
        else:
            harness.end_well(publication)
        harness.turn()
        harness.store.retry_sweep(row.id)
    assert {file.name for file in harness.store.artifacts(row.id)} >= {"cube.nc", "report.html"}


def test_failure__names_the_log_and_registers_it(harness: Harness) -> None:
    harness.store.create_sweep(sweep_of(1))
    [ticket] = harness.turn()
    folder = Path(ticket.directory)
    folder.mkdir(parents=True)
    (folder / "log.txt").write_text("Traceback")
    harness.end_badly(ticket, Cause.ERROR)
    harness.turn()
    place = folder.relative_to(harness.settings.data)
    assert harness.run().reason == f"because of error (log: {place}/log.txt)"
    assert harness.store.run_file(run_id(0), "log.txt").size == len("Traceback")


def test_failure__leaves_the_checkpoint_for_a_retry(harness: Harness) -> None:
    row = harness.store.create_sweep(sweep_of(1))
    [ticket] = harness.turn()
    checkpoint = checkpoint_of(harness)
    harness.store.checkpointed([(claim, 7) for claim in harness.store.claimed()])
    harness.end_badly(ticket, Cause.TIME_LIMIT, checkpoint=7)
    harness.end_well(harness.turn()[0])  # the publication
    harness.turn()
    assert checkpoint.is_file()
    assert harness.run().checkpoint == 7
    harness.store.retry_sweep(row.id)
    assert harness.turn()[0].checkpoint == str(checkpoint)


@pytest.mark.parametrize("damage", ["{}", "", None])
def test_damaged_result__is_computed_again(
    harness: Harness, monkeypatch: pytest.MonkeyPatch, damage: str | None
) -> None:
    monkeypatch.setattr(findings, "AGAIN_SECONDS", 0.0)
    monkeypatch.setattr(findings, "DOUBT_SECONDS", 0.0)
    harness.store.create_sweep(sweep_of(1))
    [ticket] = harness.turn()
    ending = harness.compute(ticket)
    file = Path(ending.files[0].path)
    file.unlink() if damage is None else file.write_text(damage)
    harness.end(ticket, ending)
    assert harness.turn() == []  # the disk may not show it yet
    [again] = harness.turn()
    assert again.directory != ticket.directory
    assert harness.run().crashes == 1


def test_result_without_answer__is_computed_again(harness: Harness) -> None:
    harness.store.create_sweep(sweep_of(1))
    [ticket] = harness.turn()
    harness.end(ticket, Ending(None, "", "", harness.compute(ticket).files[1:], 1.0))
    assert len(harness.turn()) == 1


@pytest.mark.parametrize("number", sorted(PASSING))
def test_result__that_cannot_be_registered_for_now_costs_the_run_nothing(
    harness: Harness, monkeypatch: pytest.MonkeyPatch, number: int
) -> None:
    def refuse(*_arguments: Any) -> None:
        raise OSError(number, "for now")

    harness.store.create_sweep(sweep_of(1))
    [ticket] = harness.turn()
    harness.end_well(ticket)
    with monkeypatch.context() as patch:
        patch.setattr(Artifacts, "bring_to_disk", refuse)
        patch.setattr(findings, "AGAIN_SECONDS", 0.0)
        patch.setattr(findings, "DOUBT_SECONDS", 0.0)
        for _ in range(3):
            assert harness.turn() == []
    harness.turn()
    run = harness.run()
    assert (run.state, run.attempt, run.crashes) == (State.SUCCEEDED, 1, 0)


def stumbling(patch: pytest.MonkeyPatch, number: int) -> list[Claim]:
    """Let no end of a run be settled; the claims for which it was tried."""
    settle, tried = Registrar.settle, list[Claim]()

    def stumble(registrar: Registrar, claim: Claim, found: Found) -> None:
        if claim.id == run_id(number):
            tried.append(claim)
            raise RuntimeError("nobody foresaw this")
        settle(registrar, claim, found)

    patch.setattr(Registrar, "settle", stumble)
    return tried


def test_result__one_that_cannot_be_settled_does_not_hold_up_the_others(
    harness: Harness, monkeypatch: pytest.MonkeyPatch
) -> None:
    harness.store.create_sweep(sweep_of(2))
    for ticket in harness.turn():
        harness.end_well(ticket)
    monkeypatch.setattr(reign, "STUMBLED_SECONDS", 0.0)
    with monkeypatch.context() as patch:
        stumbling(patch, 0)
        harness.turn()
    assert [harness.run(number).state for number in (0, 1)] == [State.RUNNING, State.SUCCEEDED]
    harness.turn()
    assert harness.run().state is State.SUCCEEDED


def test_result__one_that_cannot_be_settled_is_not_tried_at_each_turn(
    harness: Harness, monkeypatch: pytest.MonkeyPatch
) -> None:
    harness.store.create_sweep(sweep_of(1))
    [ticket] = harness.turn()
    harness.end_well(ticket)
    monkeypatch.setattr(reign, "STUMBLED_SECONDS", 3600.0)
    tried = stumbling(monkeypatch, 0)
    for _ in range(3):
        harness.turn()
    assert len(tried) == 1


def test_result__one_that_can_never_be_settled_fails(
    harness: Harness, monkeypatch: pytest.MonkeyPatch
) -> None:
    harness.store.create_sweep(sweep_of(1))
    [ticket] = harness.turn()
    harness.end_well(ticket)
    monkeypatch.setattr(reign, "STUMBLED_SECONDS", 0.0)
    tried = stumbling(monkeypatch, 0)
    for _ in range(reign.STUMBLES):
        harness.turn()
    assert len(tried) == reign.STUMBLES
    run = harness.run()
    assert (run.state, run.cause, run.failure) == (State.FAILED, Cause.ERROR, "RuntimeError")
    assert "nobody foresaw this" in str(run.reason)
    assert harness.engine.forgotten == [ticket.key]


# --- trying again --------------------------------------------------------------------------------


def test_crash__three_attempts_then_failed(harness: Harness) -> None:
    harness.store.create_sweep(sweep_of(1))
    for _ in range(3):
        [ticket] = harness.turn()
        harness.end_badly(ticket, Cause.CRASH)
    [publication] = harness.turn()
    assert publication.kind is Kind.PUBLISH
    run = harness.run()
    assert (run.state, run.cause, run.attempt, run.crashes) == (State.FAILED, Cause.CRASH, 3, 3)


def test_crash__progress_beyond_the_checkpoint_starts_the_count_anew(harness: Harness) -> None:
    harness.store.create_sweep(sweep_of(1))
    for step in (None, None, 100, 100, 200, 300):
        [ticket] = harness.turn()
        harness.end_badly(ticket, Cause.CRASH, checkpoint=step)
    [ticket] = harness.turn()
    assert (ticket.kind, harness.run().attempt) == (Kind.RUN, 7)
    for step in (300, 250):  # a checkpoint that was refused is no progress either
        harness.end_badly(ticket, Cause.CRASH, checkpoint=step)
        [ticket] = harness.turn()
    assert harness.run().state is State.FAILED


def test_lost__costs_a_run_nothing(harness: Harness, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(rests, "FIRST_SECONDS", 0.0)
    harness.store.create_sweep(sweep_of(1))
    for _ in range(10):
        [ticket] = harness.turn()
        harness.end_badly(ticket, Cause.LOST)
    harness.turn()
    run = harness.run()
    assert (run.state, run.attempt, run.crashes) == (State.RUNNING, 11, 0)


def test_lost__again_and_again_lets_it_rest_and_others_go_on(
    harness: Harness, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(rests, "FIRST_SECONDS", 3600.0)
    harness.store.create_sweep(sweep_of(1))
    for _ in range(1 + rests.FREE):
        [ticket] = harness.turn()
        harness.end_badly(ticket, Cause.LOST)
    assert harness.turn() == []
    assert (harness.run().state, harness.run().crashes) == (State.QUEUED, 0)
    harness.store.create_sweep(sweep_of(2))
    assert [ticket.spec["id"] for ticket in harness.turn()] == [run_id(1)]


def test_cancel__is_no_loss_however_often(
    harness: Harness, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(rests, "FIRST_SECONDS", 3600.0)
    harness.engine.free = 100
    for _ in range(1 + rests.FREE):
        row = harness.store.create_sweep(sweep_of(1))
        [ticket] = [one for one in harness.turn() if one.kind is Kind.RUN]
        harness.store.cancel_sweep(row.id)
        harness.end_badly(ticket, Cause.LOST)
        harness.turn()
        assert harness.run().state is State.CANCELLED
    harness.store.create_sweep(sweep_of(1))
    assert [one.kind for one in harness.turn()] == [Kind.RUN]


def test_lost__after_progress_it_goes_on_at_once(
    harness: Harness, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(rests, "FIRST_SECONDS", 3600.0)
    harness.store.create_sweep(sweep_of(1))
    for step in range(2 * rests.FREE):
        [ticket] = harness.turn()
        harness.end_badly(ticket, Cause.LOST, checkpoint=step)
    assert len(harness.turn()) == 1


def test_lost__the_checkpoint_stays(harness: Harness) -> None:
    harness.store.create_sweep(sweep_of(1))
    [ticket] = harness.turn()
    checkpoint = checkpoint_of(harness)
    harness.end_badly(ticket, Cause.LOST, checkpoint=7)
    harness.turn()
    assert checkpoint.read_text() == "7"


@pytest.mark.parametrize("cause", [Cause.TIME_LIMIT, Cause.MEMORY_LIMIT, Cause.ERROR])
def test_limits_and_error__one_attempt(harness: Harness, cause: Cause) -> None:
    harness.store.create_sweep(sweep_of(1))
    [ticket] = harness.turn()
    harness.end_badly(ticket, cause)
    harness.turn()
    assert harness.run().cause is cause


def test_late_result__of_an_attempt_that_was_given_up_is_ignored(harness: Harness) -> None:
    harness.store.create_sweep(sweep_of(1))
    [old] = harness.turn()
    harness.end_badly(old, Cause.LOST)
    [new] = harness.turn()
    harness.end(old, harness.compute(old))
    harness.turn()
    assert harness.run().state is State.RUNNING
    harness.end_well(new)
    harness.turn()
    path = harness.run().path
    assert path is not None
    assert (harness.settings.data / path).parent == Path(new.directory)
