"""The leader's turns: slots are filled, what nobody wants is stopped, progress is written."""

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from service.queue.garbage_collection import GarbageCollector
from service.queue.leader import NO_WORKER, REFUSED
from service.records.attempt import Attempt, ProgressMessage
from service.records.jobs import Cause, Keep, Kind, State, StoreUnavailable
from tests.service.support.fakes import run_id, runs_of, sweep_of
from tests.service.support.harness import Harness, open_harness
from tests.service.support.targets import Run

GIBIBYTE = 1 << 30


@pytest.fixture
def harness(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Harness]:
    monkeypatch.setenv("NUMBA_NUM_THREADS", "1")
    with open_harness(tmp_path, memory_limit=GIBIBYTE) as opened:
        yield opened


# --- filling -------------------------------------------------------------------------------------


def test_fill__never_more_than_the_free_slots(harness: Harness) -> None:
    harness.store.create_sweep(sweep_of(5))
    assert len(harness.turn()) == 2
    assert harness.turn() == []
    harness.end_well(harness.engine.submitted[0])
    assert len(harness.turn()) == 1


def test_fill__no_worker_no_work(harness: Harness) -> None:
    harness.engine.free = 0
    harness.store.create_sweep(sweep_of(1))
    assert harness.turn() == []
    assert harness.store.queue().states[State.QUEUED] == 1
    assert harness.dispatcher.workers() == 0


def test_fill__fewer_slots_than_attempts_under_way_are_no_trouble(harness: Harness) -> None:
    harness.store.create_sweep(sweep_of(3))
    harness.turn()
    harness.engine.free = 1
    assert harness.turn() == []
    harness.end_well(harness.engine.submitted[0])
    assert harness.turn() == []


def test_fill__an_engine_that_refuses_costs_the_run_nothing(
    harness: Harness, monkeypatch: pytest.MonkeyPatch
) -> None:
    def refuse(_ticket: Attempt) -> None:
        raise OSError("scheduler away")

    harness.store.create_sweep(sweep_of(1))
    with monkeypatch.context() as patch:
        patch.setattr(harness.engine, "submit", refuse)
        harness.turn()
    assert harness.turn() == []
    assert harness.dispatcher.trouble() == REFUSED
    monkeypatch.setattr("service.queue.leader.REFUSED_SECONDS", 0.0)
    assert len(harness.turn()) == 1
    assert harness.run().crashes == 0


def test_fill__nothing_while_people_have_paused_the_queue(harness: Harness) -> None:
    harness.store.create_sweep(sweep_of(1))
    harness.store.pause()
    assert harness.turn() == []
    harness.store.resume()
    assert len(harness.turn()) == 1


def test_ticket__has_a_folder_of_its_own_and_the_limits(harness: Harness) -> None:
    harness.store.create_sweep(sweep_of(1), keep=Keep.FILM)
    [ticket] = harness.turn()
    folder = Path(ticket.directory)
    assert folder.is_relative_to(harness.settings.data)
    assert folder.name.startswith("a1-")
    assert ticket.seconds_limit == harness.settings.run_seconds_limit
    assert (ticket.memory_limit, ticket.keep) == (GIBIBYTE, Keep.FILM)
    assert ticket.checkpoint == str(folder.parent / "checkpoint.npz")
    assert ticket.spec == Run(run_id(0)).as_json()


def test_ticket__a_run_alone_has_the_threads_of_all_workers(harness: Harness) -> None:
    harness.engine.free = 4
    harness.store.create_sweep(sweep_of(1))
    assert [ticket.threads for ticket in harness.turn()] == [4]
    harness.store.create_sweep(sweep_of(runs_of("fine", first=1)))
    assert [ticket.threads for ticket in harness.turn()] == [2]


@pytest.mark.parametrize(("runs", "threads"), [(2, 2), (3, 1), (4, 1), (9, 1)])
def test_ticket__runs_that_begin_together_share_the_workers(
    harness: Harness, runs: int, threads: int
) -> None:
    harness.engine.free = 4
    harness.store.create_sweep(sweep_of(runs))
    assert {ticket.threads for ticket in harness.turn()} == {threads}


def test_ticket__a_publication_has_no_checkpoint(harness: Harness) -> None:
    harness.store.create_sweep(sweep_of(1))
    harness.end_well(harness.turn()[0])
    [publication] = harness.turn()
    assert (publication.kind, publication.checkpoint) == (Kind.PUBLISH, None)


# --- stopping and progress -----------------------------------------------------------------------


def test_cancel__is_asked_for_until_the_attempt_has_ended(harness: Harness) -> None:
    row = harness.store.create_sweep(sweep_of(1))
    [ticket] = harness.turn()
    harness.store.cancel_sweep(row.id)
    harness.turn()
    harness.turn()
    assert harness.engine.stopped == [ticket.key, ticket.key]
    harness.end_badly(ticket, Cause.LOST)
    harness.turn()
    harness.turn()
    assert harness.run().state is State.CANCELLED
    assert len(harness.engine.stopped) == 2


def test_store_that_cannot_be_written__keeps_nobody_from_stopping_and_making_room(
    harness: Harness, monkeypatch: pytest.MonkeyPatch
) -> None:
    def away(*_arguments: Any, **_words: Any) -> State | None:
        raise StoreUnavailable("database or disk is full")

    rounds: list[GarbageCollector] = []
    harness.store.create_sweep(sweep_of(2))
    ended, other = harness.turn()
    monkeypatch.setattr(harness.store, "requeue", away)
    monkeypatch.setattr(GarbageCollector, "step", lambda care: rounds.append(care))
    harness.store.cancel_sweep(harness.store.sweeps(limit=1).items[0].id)
    harness.end_badly(ended, Cause.LOST)
    harness.engine.free = 0
    with pytest.raises(StoreUnavailable):
        harness.turn()
    assert len(rounds) == 1
    assert harness.engine.stopped == [other.key]
    assert harness.dispatcher.trouble() == NO_WORKER


def test_progress__one_write_in_a_while_for_all_runs(
    harness: Harness, monkeypatch: pytest.MonkeyPatch
) -> None:
    written: list[int] = []
    progress = harness.store.progress

    def note(news: Any) -> None:
        written.append(len(news))
        progress(news)

    monkeypatch.setattr(harness.store, "progress", note)
    monkeypatch.setattr(
        "service.queue.leader.PROGRESS_SECONDS", 3600.0
    )  # of which the test takes less
    harness.store.create_sweep(sweep_of(2))
    tickets = harness.turn()
    for step in range(50):
        for ticket in tickets:
            words = {"fraction": step / 50, "seconds": 0.1 * step, "step": step}
            harness.say(ProgressMessage(ticket.key, words))
        harness.turn()
    assert written == [2]


def test_progress__names_the_last_checkpoint(harness: Harness) -> None:
    harness.store.create_sweep(sweep_of(1))
    [ticket] = harness.turn()
    harness.say(ProgressMessage(ticket.key, {"fraction": 0.5, "seconds": 3.0, "checkpoint": 40}))
    harness.turn()
    run = harness.run()
    assert (run.fraction, run.checkpoint) == (0.5, 40)
