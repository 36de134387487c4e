"""The leader's turns: slots are filled, what nobody wants is stopped, progress is written."""

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from service.queue.garbage_collection import GarbageCollector
from service.queue.leader import NO_WORKER, REFUSED
from service.records.attempt import Ticket, Told
from service.records.jobs import Cause, Keep, Kind, State, StoreUnavailable
from tests.service.support.fakes import run_id, runs_of, sweep_of
from tests.service.support.stepped_dispatcher import Bench, open_bench
from tests.service.support.targets import Run

GIBIBYTE = 1 << 30


@pytest.fixture
def bench(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Bench]:
    monkeypatch.setenv("NUMBA_NUM_THREADS", "1")
    with open_bench(tmp_path, memory_limit=GIBIBYTE) as opened:
        yield opened


# --- filling -------------------------------------------------------------------------------------


def test_fill__never_more_than_the_free_slots(bench: Bench) -> None:
    bench.store.create_sweep(sweep_of(5))
    assert len(bench.turn()) == 2
    assert bench.turn() == []
    bench.end_well(bench.engine.submitted[0])
    assert len(bench.turn()) == 1


def test_fill__no_worker_no_work(bench: Bench) -> None:
    bench.engine.free = 0
    bench.store.create_sweep(sweep_of(1))
    assert bench.turn() == []
    assert bench.store.queue().states[State.QUEUED] == 1
    assert bench.dispatcher.workers() == 0


def test_fill__fewer_slots_than_attempts_under_way_are_no_trouble(bench: Bench) -> None:
    bench.store.create_sweep(sweep_of(3))
    bench.turn()
    bench.engine.free = 1
    assert bench.turn() == []
    bench.end_well(bench.engine.submitted[0])
    assert bench.turn() == []


def test_fill__an_engine_that_refuses_costs_the_run_nothing(
    bench: Bench, monkeypatch: pytest.MonkeyPatch
) -> None:
    def refuse(_ticket: Ticket) -> None:
        raise OSError("scheduler away")

    bench.store.create_sweep(sweep_of(1))
    with monkeypatch.context() as patch:
        patch.setattr(bench.engine, "submit", refuse)
        bench.turn()
    assert bench.turn() == []
    assert bench.dispatcher.trouble() == REFUSED
    monkeypatch.setattr("service.queue.leader.REFUSED_SECONDS", 0.0)
    assert len(bench.turn()) == 1
    assert bench.run().crashes == 0


def test_fill__nothing_while_people_have_paused_the_queue(bench: Bench) -> None:
    bench.store.create_sweep(sweep_of(1))
    bench.store.pause()
    assert bench.turn() == []
    bench.store.resume()
    assert len(bench.turn()) == 1


def test_ticket__has_a_folder_of_its_own_and_the_limits(bench: Bench) -> None:
    bench.store.create_sweep(sweep_of(1), keep=Keep.FILM)
    [ticket] = bench.turn()
    folder = Path(ticket.directory)
    assert folder.is_relative_to(bench.settings.data)
    assert folder.name.startswith("a1-")
    assert ticket.seconds_limit == bench.settings.run_seconds_limit
    assert (ticket.memory_limit, ticket.keep) == (GIBIBYTE, Keep.FILM)
    assert ticket.checkpoint == str(folder.parent / "checkpoint.npz")
    assert ticket.spec == Run(run_id(0)).as_json()


def test_ticket__a_run_alone_has_the_threads_of_all_workers(bench: Bench) -> None:
    bench.engine.free = 4
    bench.store.create_sweep(sweep_of(1))
    assert [ticket.threads for ticket in bench.turn()] == [4]
    bench.store.create_sweep(sweep_of(runs_of("fine", first=1)))
    assert [ticket.threads for ticket in bench.turn()] == [2]


@pytest.mark.parametrize(("runs", "threads"), [(2, 2), (3, 1), (4, 1), (9, 1)])
def test_ticket__runs_that_begin_together_share_the_workers(
    bench: Bench, runs: int, threads: int
) -> None:
    bench.engine.free = 4
    bench.store.create_sweep(sweep_of(runs))
    assert {ticket.threads for ticket in bench.turn()} == {threads}


def test_ticket__a_publication_has_no_checkpoint(bench: Bench) -> None:
    bench.store.create_sweep(sweep_of(1))
    bench.end_well(bench.turn()[0])
    [publication] = bench.turn()
    assert (publication.kind, publication.checkpoint) == (Kind.PUBLISH, None)


# --- stopping and progress -----------------------------------------------------------------------


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
    assert bench.run().state is State.CANCELLED
    assert len(bench.engine.stopped) == 2


def test_store_that_cannot_be_written__keeps_nobody_from_stopping_and_making_room(
    bench: Bench, monkeypatch: pytest.MonkeyPatch
) -> None:
    def away(*_arguments: Any, **_words: Any) -> State | None:
        raise StoreUnavailable("database or disk is full")

    rounds: list[GarbageCollector] = []
    bench.store.create_sweep(sweep_of(2))
    ended, other = bench.turn()
    monkeypatch.setattr(bench.store, "requeue", away)
    monkeypatch.setattr(GarbageCollector, "step", lambda care: rounds.append(care))
    bench.store.cancel_sweep(bench.store.sweeps(limit=1).items[0].id)
    bench.end_badly(ended, Cause.LOST)
    bench.engine.free = 0
    with pytest.raises(StoreUnavailable):
        bench.turn()
    assert len(rounds) == 1
    assert bench.engine.stopped == [other.key]
    assert bench.dispatcher.trouble() == NO_WORKER


def test_progress__one_write_in_a_while_for_all_runs(
    bench: Bench, monkeypatch: pytest.MonkeyPatch
) -> None:
    written: list[int] = []
    progress = bench.store.progress

    def note(news: Any) -> None:
        written.append(len(news))
        progress(news)

    monkeypatch.setattr(bench.store, "progress", note)
    monkeypatch.setattr(
        "service.queue.leader.PROGRESS_SECONDS", 3600.0
    )  # of which the test takes less
    bench.store.create_sweep(sweep_of(2))
    tickets = bench.turn()
    for step in range(50):
        for ticket in tickets:
            words = {"fraction": step / 50, "seconds": 0.1 * step, "step": step}
            bench.say(Told(ticket.key, words))
        bench.turn()
    assert written == [2]


def test_progress__names_the_last_checkpoint(bench: Bench) -> None:
    bench.store.create_sweep(sweep_of(1))
    [ticket] = bench.turn()
    bench.say(Told(ticket.key, {"fraction": 0.5, "seconds": 3.0, "checkpoint": 40}))
    bench.turn()
    run = bench.run()
    assert (run.fraction, run.checkpoint) == (0.5, 40)
