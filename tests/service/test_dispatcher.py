"""The dispatcher between a real store and an engine that does what a test says."""

import json
import time
from collections.abc import Iterator
from contextlib import closing
from dataclasses import dataclass, field
from pathlib import Path
from queue import SimpleQueue
from typing import Any

import pytest

from service.artifacts import Artifacts, describe
from service.dispatcher import Dispatcher
from service.execution import Ended, Message, Told
from service.jobs import Cause, Kind, State, StoreUnavailable, SweepState
from service.settings import Settings
from service.store import Store
from service.worker import FILES, Ending, Ticket
from tests.service.doubles import (
    StandStill,
    open_store,
    run_id,
    runs_of,
    settings_in,
    sweep_of,
)
from tests.service.targets import Run, execute, publish


@dataclass
class Bench:
    """A dispatcher whose turns a test takes by hand."""

    settings: Settings
    store: Store
    engine: StandStill = field(default_factory=StandStill)
    inbox: "SimpleQueue[Message | None]" = field(default_factory=SimpleQueue)

    def __post_init__(self) -> None:
        self.dispatcher = self.successor(self.engine)

    def successor(self, engine: StandStill) -> Dispatcher:
        """Another dispatcher on the same store."""
        return Dispatcher(self.settings, self.store, engine=engine, inbox=self.inbox)

    def turn(self) -> list[Ticket]:
        """One turn; what the engine was given in it."""
        before = len(self.engine.submitted)
        self.dispatcher.turn()
        return self.engine.submitted[before:]

    def compute(self, ticket: Ticket) -> Ending:
        """What a worker does with a ticket, here."""
        directory = Path(ticket.directory)
        directory.mkdir(parents=True)
        if ticket.kind is Kind.RUN:
            execute(Run.from_json(ticket.spec), directory)
        else:
            answers = {one["run_id"]: one for one in ticket.spec["outcomes"]}
            publish(ticket.spec["document"], answers, directory)
        files = tuple(describe(directory / name) for name in FILES[ticket.kind])
        return Ending(None, "", "", files, 1.5)

    def end(self, ticket: Ticket, ending: Ending) -> None:
        """The engine says how an attempt ended."""
        self.inbox.put(Ended(ticket.key, ending))

    def end_badly(self, ticket: Ticket, cause: Cause) -> None:
        """An attempt ended without a result."""
        self.end(ticket, Ending(cause, cause.value, f"because of {cause}", (), 1.0))


@pytest.fixture
def bench(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Bench]:
    monkeypatch.setenv("NUMBA_NUM_THREADS", "1")
    settings = settings_in(tmp_path, reconcile_seconds=1e-9)
    with closing(open_store(settings)) as store:
        yield Bench(settings, store)


# --- filling -------------------------------------------------------------------------------------


def test_fill__never_more_than_the_free_slots(bench: Bench) -> None:
    bench.store.create_sweep(sweep_of(5))
    assert len(bench.turn()) == 2
    assert bench.turn() == []
    bench.end(bench.engine.submitted[0], bench.compute(bench.engine.submitted[0]))
    assert len(bench.turn()) == 1


def test_fill__no_worker_no_work(bench: Bench) -> None:
    bench.engine.free = 0
    bench.store.create_sweep(sweep_of(1))
    assert bench.turn() == []
    assert bench.store.states()[State.QUEUED] == 1


def test_fill__an_engine_that_refuses_costs_the_run_nothing(
    bench: Bench, monkeypatch: pytest.MonkeyPatch
) -> None:
    def refuse(_ticket: Ticket) -> None:
        raise OSError("scheduler away")

    bench.store.create_sweep(sweep_of(1))
    with monkeypatch.context() as patch:
        patch.setattr(bench.engine, "submit", refuse)
        bench.turn()
    assert len(bench.turn()) == 1
    assert bench.store.run(run_id(0)).crashes == 0


def test_ticket__has_a_folder_of_its_own_and_the_limits(bench: Bench) -> None:
    bench.store.create_sweep(sweep_of(1))
    [ticket] = bench.turn()
    folder = Path(ticket.directory)
    assert folder.is_relative_to(bench.settings.data)
    assert folder.name.startswith("a1-")
    assert ticket.seconds_limit == bench.settings.run_seconds_limit
    assert ticket.spec == Run(run_id(0)).as_json()


# --- registering ---------------------------------------------------------------------------------


def test_whole_path__from_sweep_to_files(bench: Bench) -> None:
    row = bench.store.create_sweep(sweep_of(runs_of("fine", "verdict")))
    for ticket in bench.turn():
        bench.end(ticket, bench.compute(ticket))
    [publication] = bench.turn()
    assert publication.kind is Kind.PUBLISH
    bench.end(publication, bench.compute(publication))
    bench.turn()
    seen = bench.store.sweep(row.id)
    assert seen.state is SweepState.SUCCEEDED
    artifacts = Artifacts(bench.settings.data)
    files = bench.store.artifacts(row.id)
    assert [file.name for file in files] == ["cube.nc", "report.html", "report.json"]
    assert all(artifacts.is_intact(file) for file in files)


def test_result__the_row_has_the_numbers_but_no_history(bench: Bench) -> None:
    bench.store.create_sweep(sweep_of(1))
    [ticket] = bench.turn()
    bench.end(ticket, bench.compute(ticket))
    bench.turn()
    run = bench.store.run(run_id(0))
    assert run.state is State.SUCCEEDED
    assert run.seconds == 1.5
    assert run.summary == {
        "measurements": {"hole_diameter": {"value": 0.0148, "uncertainty": 1e-4, "flags": []}},
        "flags": ["under_resolved"],
        "numbers": {"threads": 1.0},
        "stop": "settled",
    }


def test_publication__is_told_what_there_is_and_why_not(bench: Bench) -> None:
    row = bench.store.create_sweep(sweep_of(runs_of("fine", "raise")))
    good, bad = bench.turn()
    bench.end(good, bench.compute(good))
    bench.end_badly(bad, Cause.ERROR)
    [publication] = bench.turn()
    one, other = publication.spec["outcomes"]
    assert Path(one["path"]).is_file()
    assert (other["path"], other["state"]) == (None, "failed")
    assert other["reason"].startswith("because of error")
    assert publication.spec["document"] == bench.store.sweep_document(row.id)


def test_failure__names_the_log(bench: Bench) -> None:
    bench.store.create_sweep(sweep_of(1))
    [ticket] = bench.turn()
    bench.end_badly(ticket, Cause.ERROR)
    bench.turn()
    folder = Path(ticket.directory).relative_to(bench.settings.data)
    assert bench.store.run(run_id(0)).reason == f"because of error (log: {folder}/log.txt)"


@pytest.mark.parametrize("damage", ["{}", "", None])
def test_damaged_result__is_computed_again(bench: Bench, damage: str | None) -> None:
    bench.store.create_sweep(sweep_of(1))
    [ticket] = bench.turn()
    ending = bench.compute(ticket)
    file = Path(ending.files[0].path)
    file.unlink() if damage is None else file.write_text(damage)
    bench.end(ticket, ending)
    [again] = bench.turn()
    assert again.directory != ticket.directory
    assert bench.store.run(run_id(0)).crashes == 1


def test_result_that_is_none__is_no_result(bench: Bench) -> None:
    bench.store.create_sweep(sweep_of(1))
    for _ in range(3):
        [ticket] = bench.turn()
        bench.compute(ticket)
        file = Path(ticket.directory) / "result.json"
        file.write_text(json.dumps({"state": "succeeded"}))
        bench.end(ticket, Ending(None, "", "", (describe(file),), 1.0))
    bench.turn()
    run = bench.store.run(run_id(0))
    assert (run.state, run.cause) == (State.FAILED, Cause.CRASH)
    assert "cannot be registered" in str(run.reason)


# --- trying again --------------------------------------------------------------------------------


def test_crash__three_attempts_then_failed(bench: Bench) -> None:
    bench.store.create_sweep(sweep_of(1))
    for _ in range(3):
        [ticket] = bench.turn()
        bench.end_badly(ticket, Cause.CRASH)
    [publication] = bench.turn()
    assert publication.kind is Kind.PUBLISH
    run = bench.store.run(run_id(0))
    assert (run.state, run.cause, run.attempt, run.crashes) == (State.FAILED, Cause.CRASH, 3, 3)


def test_lost__costs_a_run_nothing(bench: Bench) -> None:
    bench.store.create_sweep(sweep_of(1))
    for _ in range(10):
        [ticket] = bench.turn()
        bench.end_badly(ticket, Cause.LOST)
    bench.turn()
    run = bench.store.run(run_id(0))
    assert (run.state, run.attempt, run.crashes) == (State.RUNNING, 11, 0)


@pytest.mark.parametrize("cause", [Cause.TIME_LIMIT, Cause.ERROR])
def test_limit_and_error__one_attempt(bench: Bench, cause: Cause) -> None:
    bench.store.create_sweep(sweep_of(1))
    [ticket] = bench.turn()
    bench.end_badly(ticket, cause)
    bench.turn()
    assert bench.store.run(run_id(0)).cause is cause


def test_late_result__of_an_attempt_that_was_given_up_is_ignored(bench: Bench) -> None:
    bench.store.create_sweep(sweep_of(1))
    [old] = bench.turn()
    late = bench.compute(old)
    bench.end_badly(old, Cause.LOST)
    [new] = bench.turn()
    bench.end(old, late)
    bench.turn()
    assert bench.store.run(run_id(0)).state is State.RUNNING
    bench.end(new, bench.compute(new))
    bench.turn()
    path = bench.store.run(run_id(0)).path
    assert path is not None
    assert (bench.settings.data / path).parent == Path(new.directory)


# --- rows and engine compared ---------------------------------------------------------------------


def test_new_life__what_ran_is_queued_again_at_once(bench: Bench) -> None:
    bench.store.create_sweep(sweep_of(2))
    bench.turn()
    engine = StandStill()
    bench.successor(engine).turn()
    assert [ticket.key.split("-")[1:] for ticket in engine.submitted] == [["2", "2"]] * 2


def test_new_life__a_complete_result_is_not_computed_twice(bench: Bench) -> None:
    bench.store.create_sweep(sweep_of(2))
    done, _ = bench.turn()
    bench.compute(done)
    engine = StandStill()
    bench.successor(engine).turn()
    run = bench.store.run(run_id(0))
    assert (run.state, run.attempt, run.seconds) == (State.SUCCEEDED, 1, 0.5)
    assert len(engine.submitted) == 1


def test_new_life__a_publication_is_made_again(bench: Bench) -> None:
    row = bench.store.create_sweep(sweep_of(1))
    [ticket] = bench.turn()
    bench.end(ticket, bench.compute(ticket))
    [publication] = bench.turn()
    bench.compute(publication)
    engine = StandStill()
    successor = bench.successor(engine)
    successor.turn()
    [again] = engine.submitted
    assert again.directory != publication.directory
    bench.end(again, bench.compute(again))
    successor.turn()
    assert bench.store.sweep(row.id).state is SweepState.SUCCEEDED


def test_new_life__a_run_that_was_being_cancelled_ends_cancelled(bench: Bench) -> None:
    row = bench.store.create_sweep(sweep_of(1))
    bench.turn()
    bench.store.cancel_sweep(row.id)
    engine = StandStill()
    bench.successor(engine).turn()
    assert bench.store.run(run_id(0)).state is State.CANCELLED
    assert engine.submitted == []


def test_reconcile__leaves_alone_what_is_under_way(bench: Bench) -> None:
    bench.store.create_sweep(sweep_of(2))
    bench.turn()
    for _ in range(3):
        bench.turn()
    assert bench.store.run(run_id(0)).attempt == 1


def test_reconcile__a_deleted_sweep_loses_its_files(bench: Bench) -> None:
    row = bench.store.create_sweep(sweep_of(1))
    for _ in range(2):
        [ticket] = bench.turn()
        bench.end(ticket, bench.compute(ticket))
    bench.turn()
    folder = bench.settings.data / "sweeps" / row.id
    assert folder.is_dir()
    bench.store.delete_sweep(row.id)
    bench.turn()
    assert not folder.exists()


def test_cancel__is_asked_for_until_the_attempt_has_ended(bench: Bench) -> None:
    row = bench.store.create_sweep(sweep_of(1))
    [ticket] = bench.turn()
    bench.store.cancel_sweep(row.id)
    bench.turn()
    bench.turn()
    assert bench.engine.stopped == [ticket.key, ticket.key]
    bench.end_badly(ticket, Cause.LOST)
    bench.turn()
    bench.turn()
    assert bench.store.run(run_id(0)).state is State.CANCELLED
    assert len(bench.engine.stopped) == 2


# --- progress, trouble, the end -------------------------------------------------------------------


def test_progress__one_write_a_second_and_the_last_word_of_each_run(
    bench: Bench, monkeypatch: pytest.MonkeyPatch
) -> None:
    written: list[int] = []
    progress = bench.store.progress

    def note(news: Any) -> None:
        written.append(len(news))
        progress(news)

    monkeypatch.setattr(bench.store, "progress", note)
    bench.store.create_sweep(sweep_of(2))
    tickets = bench.turn()
    for step in range(50):
        for ticket in tickets:
            words = {"fraction": step / 50, "seconds": 0.1 * step, "step": step}
            bench.inbox.put(Told(ticket.key, words))
        bench.turn()
    assert written == [2]


def test_store_away__nothing_is_forgotten(bench: Bench, monkeypatch: pytest.MonkeyPatch) -> None:
    def away(*_arguments: Any, **_words: Any) -> bool:
        raise StoreUnavailable("locked")

    bench.store.create_sweep(sweep_of(1))
    [ticket] = bench.turn()
    bench.end(ticket, bench.compute(ticket))
    with monkeypatch.context() as patch:
        patch.setattr(bench.store, "finish", away)
        with pytest.raises(StoreUnavailable):
            bench.turn()
    bench.turn()
    assert bench.store.run(run_id(0)).state is State.SUCCEEDED


def test_thread__goes_on_after_trouble(bench: Bench, monkeypatch: pytest.MonkeyPatch) -> None:
    turns: list[float] = []

    def trouble() -> None:
        turns.append(time.monotonic())
        raise RuntimeError("nobody foresaw this")

    monkeypatch.setattr(bench.dispatcher, "turn", trouble)
    bench.dispatcher.start()
    for _ in range(3):
        bench.dispatcher.wake()
    assert bench.dispatcher.is_alive()
    bench.dispatcher.close()
    assert not bench.dispatcher.is_alive()
    assert len(turns) >= 1


def test_close__what_was_under_way_is_queued_and_what_had_ended_is_kept(bench: Bench) -> None:
    bench.store.create_sweep(sweep_of(2))
    done, _ = bench.turn()
    bench.end(done, bench.compute(done))
    bench.dispatcher.start()
    bench.dispatcher.close()
    assert bench.engine.closed
    assert bench.store.run(run_id(0)).state is State.SUCCEEDED
    assert bench.store.run(run_id(1)).state is State.QUEUED
    assert bench.store.claimed() == ()


def test_alive__not_when_no_turn_has_succeeded_for_long(
    bench: Bench, monkeypatch: pytest.MonkeyPatch
) -> None:
    def trouble() -> None:
        raise RuntimeError("nobody foresaw this")

    monkeypatch.setattr("service.dispatcher.STUCK_SECONDS", 0.0)
    monkeypatch.setattr(bench.dispatcher, "turn", trouble)
    bench.dispatcher.start()
    assert not bench.dispatcher.is_alive()
    bench.dispatcher.close()
