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
from tests.service.support.stepped_dispatcher import Bench, open_bench


@pytest.fixture
def bench(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Bench]:
    monkeypatch.setenv("NUMBA_NUM_THREADS", "1")
    with open_bench(tmp_path) as opened:
        yield opened


def checkpoint_of(bench: Bench, number: int = 0) -> Path:
    """A checkpoint as a worker leaves it, and half of the next one."""
    file = Artifacts(bench.settings.data).checkpoint(run_id(number))
    file.parent.mkdir(parents=True, exist_ok=True)
    file.write_text("7")
    (file.parent / f".{file.name}.abc.part").write_text("half")
    return file


# --- registering ---------------------------------------------------------------------------------


def test_whole_path__from_sweep_to_files(bench: Bench) -> None:
    row = bench.store.create_sweep(sweep_of(runs_of("fine", "verdict")))
    for ticket in bench.turn():
        bench.end_well(ticket)
    [publication] = bench.turn()
    bench.end_well(publication)
    bench.turn()
    assert bench.store.sweep(row.id).state is SweepState.SUCCEEDED
    artifacts = Artifacts(bench.settings.data)
    files = bench.store.artifacts(row.id)
    assert {file.name for file in files} == {"cube.nc", "report.html", "report.json", "log.txt"}
    assert all(artifacts.is_intact(file) for file in files)


def test_result__every_file_of_the_attempt_is_registered(bench: Bench) -> None:
    bench.store.create_sweep(sweep_of(1))
    [ticket] = bench.turn()
    bench.end_well(ticket)
    bench.turn()
    files = bench.store.run_files(run_id(0))
    assert {file.name for file in files} == {"result.json", "state.npz", "log.txt"}
    artifacts = Artifacts(bench.settings.data)
    assert all(artifacts.is_intact(file) for file in files)
    assert {artifacts.path(file).parent for file in files} == {Path(ticket.directory)}


def test_result__the_row_has_the_numbers_but_no_history(bench: Bench) -> None:
    bench.store.create_sweep(sweep_of(1))
    bench.end_well(bench.turn()[0])
    bench.turn()
    run = bench.run()
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
    bench: Bench, monkeypatch: pytest.MonkeyPatch
) -> None:
    def away(*_arguments: Any, **_words: Any) -> bool:
        raise StoreUnavailable("locked")

    bench.store.create_sweep(sweep_of(1))
    [ticket] = bench.turn()
    bench.end_well(ticket)
    with monkeypatch.context() as patch:
        patch.setattr(bench.store, "finish", away)
        with pytest.raises(StoreUnavailable):
            bench.turn()
    assert bench.engine.forgotten == []
    bench.turn()
    assert bench.engine.forgotten == [ticket.key]
    assert bench.run().state is State.SUCCEEDED


def test_result__the_checkpoint_goes_with_its_half_written_successor(bench: Bench) -> None:
    bench.store.create_sweep(sweep_of(1))
    [ticket] = bench.turn()
    checkpoint = checkpoint_of(bench)
    bench.end_well(ticket)
    bench.turn()
    assert [entry.name for entry in checkpoint.parent.iterdir()] == [Path(ticket.directory).name]


def test_publication__is_told_what_there_is_and_why_not(bench: Bench) -> None:
    row = bench.store.create_sweep(sweep_of(runs_of("fine", "raise")))
    good, bad = bench.turn()
    bench.end_well(good)
    bench.end_badly(bad, Cause.ERROR)
    [publication] = bench.turn()
    one, other = publication.spec["outcomes"]
    assert Path(one["path"]).is_file()
    assert (other["path"], other["state"]) == (None, "failed")
    assert other["reason"].startswith("because of error")
    assert publication.spec["document"] == bench.store.sweep_document(row.id)


def test_publication_that_fails_again__leaves_the_earlier_files(bench: Bench) -> None:
    row = bench.store.create_sweep(sweep_of(runs_of("raise")))
    for _ in range(2):
        bench.end_badly(bench.turn()[0], Cause.ERROR)
        [publication] = bench.turn()
        if bench.store.artifacts(row.id):
            bench.end_badly(publication, Cause.ERROR)
        else:
            bench.end_well(publication)
        bench.turn()
        bench.store.retry_sweep(row.id)
    assert {file.name for file in bench.store.artifacts(row.id)} >= {"cube.nc", "report.html"}


def test_failure__names_the_log_and_registers_it(bench: Bench) -> None:
    bench.store.create_sweep(sweep_of(1))
    [ticket] = bench.turn()
    folder = Path(ticket.directory)
    folder.mkdir(parents=True)
    (folder / "log.txt").write_text("Traceback")
    bench.end_badly(ticket, Cause.ERROR)
    bench.turn()
    place = folder.relative_to(bench.settings.data)
    assert bench.run().reason == f"because of error (log: {place}/log.txt)"
    assert bench.store.run_file(run_id(0), "log.txt").size == len("Traceback")


def test_failure__leaves_the_checkpoint_for_a_retry(bench: Bench) -> None:
    row = bench.store.create_sweep(sweep_of(1))
    [ticket] = bench.turn()
    checkpoint = checkpoint_of(bench)
    bench.store.checkpointed([(claim, 7) for claim in bench.store.claimed()])
    bench.end_badly(ticket, Cause.TIME_LIMIT, checkpoint=7)
    bench.end_well(bench.turn()[0])  # the publication
    bench.turn()
    assert checkpoint.is_file()
    assert bench.run().checkpoint == 7
    bench.store.retry_sweep(row.id)
    assert bench.turn()[0].checkpoint == str(checkpoint)


@pytest.mark.parametrize("damage", ["{}", "", None])
def test_damaged_result__is_computed_again(
    bench: Bench, monkeypatch: pytest.MonkeyPatch, damage: str | None
) -> None:
    monkeypatch.setattr(findings, "AGAIN_SECONDS", 0.0)
    monkeypatch.setattr(findings, "DOUBT_SECONDS", 0.0)
    bench.store.create_sweep(sweep_of(1))
    [ticket] = bench.turn()
    ending = bench.compute(ticket)
    file = Path(ending.files[0].path)
    file.unlink() if damage is None else file.write_text(damage)
    bench.end(ticket, ending)
    assert bench.turn() == []  # the disk may not show it yet
    [again] = bench.turn()
    assert again.directory != ticket.directory
    assert bench.run().crashes == 1


def test_result_without_answer__is_computed_again(bench: Bench) -> None:
    bench.store.create_sweep(sweep_of(1))
    [ticket] = bench.turn()
    bench.end(ticket, Ending(None, "", "", bench.compute(ticket).files[1:], 1.0))
    assert len(bench.turn()) == 1


@pytest.mark.parametrize("number", sorted(PASSING))
def test_result__that_cannot_be_registered_for_now_costs_the_run_nothing(
    bench: Bench, monkeypatch: pytest.MonkeyPatch, number: int
) -> None:
    def refuse(*_arguments: Any) -> None:
        raise OSError(number, "for now")

    bench.store.create_sweep(sweep_of(1))
    [ticket] = bench.turn()
    bench.end_well(ticket)
    with monkeypatch.context() as patch:
        patch.setattr(Artifacts, "bring_to_disk", refuse)
        patch.setattr(findings, "AGAIN_SECONDS", 0.0)
        patch.setattr(findings, "DOUBT_SECONDS", 0.0)
        for _ in range(3):
            assert bench.turn() == []
    bench.turn()
    run = bench.run()
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
    bench: Bench, monkeypatch: pytest.MonkeyPatch
) -> None:
    bench.store.create_sweep(sweep_of(2))
    for ticket in bench.turn():
        bench.end_well(ticket)
    monkeypatch.setattr(reign, "STUMBLED_SECONDS", 0.0)
    with monkeypatch.context() as patch:
        stumbling(patch, 0)
        bench.turn()
    assert [bench.run(number).state for number in (0, 1)] == [State.RUNNING, State.SUCCEEDED]
    bench.turn()
    assert bench.run().state is State.SUCCEEDED


def test_result__one_that_cannot_be_settled_is_not_tried_at_each_turn(
    bench: Bench, monkeypatch: pytest.MonkeyPatch
) -> None:
    bench.store.create_sweep(sweep_of(1))
    [ticket] = bench.turn()
    bench.end_well(ticket)
    monkeypatch.setattr(reign, "STUMBLED_SECONDS", 3600.0)
    tried = stumbling(monkeypatch, 0)
    for _ in range(3):
        bench.turn()
    assert len(tried) == 1


def test_result__one_that_can_never_be_settled_fails(
    bench: Bench, monkeypatch: pytest.MonkeyPatch
) -> None:
    bench.store.create_sweep(sweep_of(1))
    [ticket] = bench.turn()
    bench.end_well(ticket)
    monkeypatch.setattr(reign, "STUMBLED_SECONDS", 0.0)
    tried = stumbling(monkeypatch, 0)
    for _ in range(reign.STUMBLES):
        bench.turn()
    assert len(tried) == reign.STUMBLES
    run = bench.run()
    assert (run.state, run.cause, run.failure) == (State.FAILED, Cause.ERROR, "RuntimeError")
    assert "nobody foresaw this" in str(run.reason)
    assert bench.engine.forgotten == [ticket.key]


# --- trying again --------------------------------------------------------------------------------


def test_crash__three_attempts_then_failed(bench: Bench) -> None:
    bench.store.create_sweep(sweep_of(1))
    for _ in range(3):
        [ticket] = bench.turn()
        bench.end_badly(ticket, Cause.CRASH)
    [publication] = bench.turn()
    assert publication.kind is Kind.PUBLISH
    run = bench.run()
    assert (run.state, run.cause, run.attempt, run.crashes) == (State.FAILED, Cause.CRASH, 3, 3)


def test_crash__progress_beyond_the_checkpoint_starts_the_count_anew(bench: Bench) -> None:
    bench.store.create_sweep(sweep_of(1))
    for step in (None, None, 100, 100, 200, 300):
        [ticket] = bench.turn()
        bench.end_badly(ticket, Cause.CRASH, checkpoint=step)
    [ticket] = bench.turn()
    assert (ticket.kind, bench.run().attempt) == (Kind.RUN, 7)
    for step in (300, 250):  # a checkpoint that was refused is no progress either
        bench.end_badly(ticket, Cause.CRASH, checkpoint=step)
        [ticket] = bench.turn()
    assert bench.run().state is State.FAILED


def test_lost__costs_a_run_nothing(bench: Bench, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(rests, "FIRST_SECONDS", 0.0)
    bench.store.create_sweep(sweep_of(1))
    for _ in range(10):
        [ticket] = bench.turn()
        bench.end_badly(ticket, Cause.LOST)
    bench.turn()
    run = bench.run()
    assert (run.state, run.attempt, run.crashes) == (State.RUNNING, 11, 0)


def test_lost__again_and_again_lets_it_rest_and_others_go_on(
    bench: Bench, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(rests, "FIRST_SECONDS", 3600.0)
    bench.store.create_sweep(sweep_of(1))
    for _ in range(1 + rests.FREE):
        [ticket] = bench.turn()
        bench.end_badly(ticket, Cause.LOST)
    assert bench.turn() == []
    assert (bench.run().state, bench.run().crashes) == (State.QUEUED, 0)
    bench.store.create_sweep(sweep_of(2))
    assert [ticket.spec["id"] for ticket in bench.turn()] == [run_id(1)]


def test_cancel__is_no_loss_however_often(bench: Bench, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(rests, "FIRST_SECONDS", 3600.0)
    bench.engine.free = 100
    for _ in range(1 + rests.FREE):
        row = bench.store.create_sweep(sweep_of(1))
        [ticket] = [one for one in bench.turn() if one.kind is Kind.RUN]
        bench.store.cancel_sweep(row.id)
        bench.end_badly(ticket, Cause.LOST)
        bench.turn()
        assert bench.run().state is State.CANCELLED
    bench.store.create_sweep(sweep_of(1))
    assert [one.kind for one in bench.turn()] == [Kind.RUN]


def test_lost__after_progress_it_goes_on_at_once(
    bench: Bench, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(rests, "FIRST_SECONDS", 3600.0)
    bench.store.create_sweep(sweep_of(1))
    for step in range(2 * rests.FREE):
        [ticket] = bench.turn()
        bench.end_badly(ticket, Cause.LOST, checkpoint=step)
    assert len(bench.turn()) == 1


def test_lost__the_checkpoint_stays(bench: Bench) -> None:
    bench.store.create_sweep(sweep_of(1))
    [ticket] = bench.turn()
    checkpoint = checkpoint_of(bench)
    bench.end_badly(ticket, Cause.LOST, checkpoint=7)
    bench.turn()
    assert checkpoint.read_text() == "7"


@pytest.mark.parametrize("cause", [Cause.TIME_LIMIT, Cause.MEMORY_LIMIT, Cause.ERROR])
def test_limits_and_error__one_attempt(bench: Bench, cause: Cause) -> None:
    bench.store.create_sweep(sweep_of(1))
    [ticket] = bench.turn()
    bench.end_badly(ticket, cause)
    bench.turn()
    assert bench.run().cause is cause


def test_late_result__of_an_attempt_that_was_given_up_is_ignored(bench: Bench) -> None:
    bench.store.create_sweep(sweep_of(1))
    [old] = bench.turn()
    bench.end_badly(old, Cause.LOST)
    [new] = bench.turn()
    bench.end(old, bench.compute(old))
    bench.turn()
    assert bench.run().state is State.RUNNING
    bench.end_well(new)
    bench.turn()
    path = bench.run().path
    assert path is not None
    assert (bench.settings.data / path).parent == Path(new.directory)
