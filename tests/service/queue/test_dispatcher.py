"""The dispatcher's thread: who leads, what goes on after trouble, and how it leaves."""

import time
from collections.abc import Iterator
from contextlib import closing
from pathlib import Path
from queue import SimpleQueue
from typing import Any

import pytest

from service.queue.dispatcher import OTHER_LEADER, Dispatcher
from service.queue.leader import NO_WORKER
from service.records.attempt import Ended, Inbox, Ticket
from service.records.jobs import Cause, State, StoreUnavailable
from service.store import Leadership, Store
from tests.service.support.fakes import StandStill, open_store, settings_in, sweep_of, wait_until
from tests.service.support.stepped_dispatcher import Bench, open_bench


@pytest.fixture(autouse=True)
def _one_thread(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("NUMBA_NUM_THREADS", "1")


@pytest.fixture
def bench(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Bench]:
    monkeypatch.setattr("service.queue.dispatcher.TRY_SECONDS", 0.0)
    with open_bench(tmp_path) as opened:
        yield opened


class Rivals:
    """Takes the right to lead away, and gives it to others."""

    def __init__(self, monkeypatch: pytest.MonkeyPatch, store: Store):
        self.lead = True  # whether asking for it succeeds
        self.away = False  # whether the database answers at all
        self.lost = False  # whether who has it has lost it
        monkeypatch.setattr(store, "lead", self._lead)

    def _lead(self, _owner: str) -> Leadership | None:
        if self.away:
            raise StoreUnavailable("the database is away")
        return _Right(self) if self.lead else None


class _Right(Leadership):
    def __init__(self, rivals: Rivals):
        super().__init__()
        self._rivals = rivals
        rivals.lost = False

    def holds(self) -> bool:
        return not self._rivals.lost


@pytest.fixture
def rivals(bench: Bench, monkeypatch: pytest.MonkeyPatch) -> Rivals:
    return Rivals(monkeypatch, bench.store)


# --- who leads -----------------------------------------------------------------------------------


def test_stand_by__without_an_engine_and_alive(bench: Bench, rivals: Rivals) -> None:
    rivals.lead = False
    bench.store.create_sweep(sweep_of(1))
    assert bench.turn() == []
    assert bench.inbox is None  # no engine was opened
    assert (bench.dispatcher.leads(), bench.dispatcher.workers()) == (False, None)
    rivals.lead = True
    assert len(bench.turn()) == 1
    assert (bench.dispatcher.leads(), bench.dispatcher.workers()) == (True, 2)


def test_lead_lost_to_another__lets_go_of_what_is_under_way(bench: Bench, rivals: Rivals) -> None:
    bench.store.create_sweep(sweep_of(1))
    [ticket] = bench.turn()
    rivals.lost, rivals.lead = True, False
    bench.turn()
    assert bench.engine.closed == [None]
    assert bench.engine.stopped == []
    bench.end_well(ticket)
    bench.turn()
    assert bench.run().state is State.RUNNING  # for the other one to say


def test_lead_lost_and_found__goes_on_with_its_own_attempts(bench: Bench, rivals: Rivals) -> None:
    bench.store.create_sweep(sweep_of(2))
    one, other = bench.turn()
    rivals.lost, rivals.away = True, True
    with pytest.raises(StoreUnavailable):
        bench.turn()
    bench.end_well(one)  # meanwhile
    with pytest.raises(StoreUnavailable):
        bench.turn()
    rivals.away = False
    bench.turn()
    assert bench.engine.closed == []
    assert (bench.run(0).state, bench.run(0).attempt) == (State.SUCCEEDED, 1)
    bench.end_well(other)
    bench.turn()
    assert (bench.run(1).state, bench.run(1).attempt) == (State.SUCCEEDED, 1)


def test_lead_lost_and_found__after_another_one_led_stops_what_no_longer_counts(
    bench: Bench, rivals: Rivals
) -> None:
    bench.store.create_sweep(sweep_of(1))
    [ticket] = bench.turn()
    rivals.lost, rivals.away = True, True
    with pytest.raises(StoreUnavailable):
        bench.turn()
    between = open_store(bench.settings)
    with closing(between):
        epoch = between.begin_epoch("another")
        [claim] = between.claimed()
        assert between.requeue(claim, Cause.LOST, reason="its leader was gone")
        assert between.claim(1, epoch)
    rivals.away = False
    bench.turn()
    assert bench.engine.stopped == [ticket.key]


@pytest.fixture
def usurped(bench: Bench) -> Ticket:
    """An attempt that was under way when somebody who should not began a younger epoch."""
    bench.store.create_sweep(sweep_of(2))
    ticket, other = bench.turn()
    bench.end_badly(other, Cause.LOST)
    with closing(open_store(bench.settings)) as elsewhere:
        elsewhere.begin_epoch("another")
    return ticket


def test_younger_epoch__ends_the_reign_and_who_has_the_right_begins_another(
    bench: Bench, usurped: Ticket, caplog: pytest.LogCaptureFixture
) -> None:
    epoch = bench.store.queue().epoch
    assert bench.turn() == []
    [again] = bench.turn()
    assert again.key != usurped.key
    assert bench.store.queue().epoch == epoch + 1
    assert [record.getMessage() for record in caplog.records].count(OTHER_LEADER) == 1
    assert bench.turn() == []
    assert bench.store.queue().epoch == epoch + 1


def test_younger_epoch__what_is_under_way_goes_on(bench: Bench, usurped: Ticket) -> None:
    bench.turn()
    bench.turn()
    assert (bench.engine.stopped, bench.engine.closed) == ([], [])
    bench.end_well(usurped)
    bench.turn()
    assert (bench.run().state, bench.run().attempt) == (State.SUCCEEDED, 1)


def test_younger_epoch__what_hinders_the_earlier_one_is_not_said(bench: Bench) -> None:
    bench.turn()
    with closing(open_store(bench.settings)) as elsewhere:
        elsewhere.begin_epoch("another")
    bench.engine.free = 0
    bench.turn()
    assert bench.dispatcher.trouble() == NO_WORKER
    assert bench.store.queue().hindrance is None


def test_lead_lost_and_found__what_another_leader_said_is_said_no_longer(
    bench: Bench, rivals: Rivals
) -> None:
    bench.turn()
    rivals.lost, rivals.away = True, True
    with pytest.raises(StoreUnavailable):
        bench.turn()
    bench.store.hinder("the other one has no worker")
    rivals.away = False
    bench.turn()
    assert bench.store.queue().hindrance is None


def test_lead_lost_while_the_engine_starts__begins_no_epoch(
    bench: Bench, rivals: Rivals, monkeypatch: pytest.MonkeyPatch
) -> None:
    def lose() -> StandStill:
        rivals.lost, rivals.lead = True, False
        return bench.engine

    monkeypatch.setattr(bench.dispatcher, "_open_engine", lambda _inbox: lose())
    bench.turn()
    bench.turn()
    assert bench.store.queue().epoch == 0
    assert not bench.dispatcher.leads()


def test_leader__of_postgresql_is_one_and_the_next_takes_over(
    tmp_path: Path, postgresql_url: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("service.queue.dispatcher.TRY_SECONDS", 0.1)
    settings = settings_in(tmp_path, database_url=postgresql_url, poll_seconds=0.05)
    with closing(open_store(settings)) as one, closing(open_store(settings)) as other:
        first, second = (
            Dispatcher(settings, store, open_engine=lambda _inbox: StandStill())
            for store in (one, other)
        )
        first.start()
        second.start()
        assert (first.leads(), second.leads()) == (True, False)
        assert first.is_alive()
        assert second.is_alive()
        first.close()
        wait_until(second.leads)
        second.close()


def test_leader__of_postgresql_whose_connection_is_cut_leads_again(
    tmp_path: Path, postgresql_url: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("service.queue.dispatcher.TRY_SECONDS", 0.0)
    settings = settings_in(tmp_path, database_url=postgresql_url, disk_reserve=0)
    with closing(open_store(settings)) as store:
        bench = Bench(settings, store)
        store.create_sweep(sweep_of(1))
        [ticket] = bench.turn()
        epoch = store.queue().epoch
        leadership = bench.dispatcher._leadership
        assert leadership is not None
        leadership.close()
        bench.turn()
        assert store.queue().epoch == epoch + 1
        assert bench.engine.closed == []
        assert bench.run().attempt == 1
        assert [claim.key for claim in store.claimed()] == [ticket.key]


# --- trouble -------------------------------------------------------------------------------------


def test_start__an_engine_that_does_not_start_is_told_at_once(bench: Bench) -> None:
    def refuse(_inbox: Inbox) -> StandStill:
        raise OSError("no certificate")

    dispatcher = Dispatcher(bench.settings, bench.store, open_engine=refuse)
    with pytest.raises(OSError, match="no certificate"):
        dispatcher.start()
    assert not dispatcher.is_alive()


def test_engine_that_does_not_start__after_a_change_of_leader_is_tried_again(
    bench: Bench,
) -> None:
    opened: list[float] = []

    def refuse_once(_inbox: Inbox) -> StandStill:
        opened.append(time.monotonic())
        if len(opened) == 1:
            raise OSError("no certificate")
        return bench.engine

    dispatcher = Dispatcher(bench.settings, bench.store, open_engine=refuse_once)
    with pytest.raises(OSError, match="no certificate"):
        dispatcher.turn()
    dispatcher.turn()
    assert dispatcher.leads()


def test_thread__goes_on_after_trouble(bench: Bench, monkeypatch: pytest.MonkeyPatch) -> None:
    turns: SimpleQueue[float] = SimpleQueue()

    def trouble() -> None:
        turns.put(time.monotonic())
        raise RuntimeError("nobody foresaw this")

    bench.dispatcher.start()
    monkeypatch.setattr(bench.dispatcher, "turn", trouble)
    for _ in range(3):
        bench.dispatcher.wake()
        assert turns.get(timeout=60.0)
    assert bench.dispatcher.is_alive()
    bench.dispatcher.close()
    assert not bench.dispatcher.is_alive()


def test_alive__not_when_no_turn_has_succeeded_for_long(
    bench: Bench, monkeypatch: pytest.MonkeyPatch
) -> None:
    bench.dispatcher.start()
    monkeypatch.setattr("service.queue.dispatcher.STUCK_SECONDS", 0.0)
    assert not bench.dispatcher.is_alive()
    bench.dispatcher.close()


def test_store_away_at_the_start__is_waited_for(
    bench: Bench, monkeypatch: pytest.MonkeyPatch
) -> None:
    def away() -> Any:
        raise StoreUnavailable("locked")

    bench.store.create_sweep(sweep_of(1))
    with monkeypatch.context() as patch:
        patch.setattr(bench.store, "claimed", away)
        bench.dispatcher.start()
        assert bench.engine.submitted == []
    wait_until(lambda: bench.engine.submitted)
    bench.dispatcher.close()


# --- leaving -------------------------------------------------------------------------------------


def test_close__what_was_under_way_is_queued_and_what_had_ended_is_kept(bench: Bench) -> None:
    bench.store.create_sweep(sweep_of(2))
    done, _ = bench.turn()
    bench.end_well(done)
    bench.dispatcher.start()
    bench.dispatcher.close()
    assert bench.engine.closed == [bench.settings.leave_seconds]
    assert bench.run(0).state is State.SUCCEEDED
    assert bench.run(1).state is State.QUEUED
    assert bench.store.claimed() == ()


def test_close__what_ends_while_the_engine_closes_counts(
    bench: Bench, monkeypatch: pytest.MonkeyPatch
) -> None:
    def close(_seconds: float | None) -> None:
        bench.end_well(done)
        bench.end_badly(left, Cause.LOST, failure="Left", checkpoint=40)

    bench.store.create_sweep(sweep_of(2))
    done, left = bench.turn()
    monkeypatch.setattr(bench.engine, "close", close)
    bench.dispatcher.start()
    bench.dispatcher.close()
    assert bench.run(0).state is State.SUCCEEDED
    run = bench.run(1)
    assert (run.state, run.attempt, run.crashes) == (State.QUEUED, 1, 0)
    assert sorted(bench.engine.forgotten) == sorted([done.key, left.key])


def test_leave__claims_nothing_more(bench: Bench) -> None:
    bench.engine.free = 0
    bench.store.create_sweep(sweep_of(2))
    bench.dispatcher.start()
    bench.dispatcher.leave()
    bench.engine.free = 2
    bench.dispatcher.close()
    assert bench.engine.submitted == []
    assert bench.run().attempt == 0


def test_close__a_store_that_is_away_does_not_hold_it_up(
    bench: Bench, monkeypatch: pytest.MonkeyPatch
) -> None:
    def away(*_arguments: Any, **_words: Any) -> bool:
        raise StoreUnavailable("locked")

    bench.store.create_sweep(sweep_of(1))
    bench.turn()
    bench.dispatcher.start()
    monkeypatch.setattr(bench.store, "requeue", away)
    bench.dispatcher.close()
    assert bench.run().state is State.RUNNING  # the next life finds it
    assert bench.engine.closed


def test_order__wakes_the_thread(tmp_path: Path) -> None:
    settings = settings_in(tmp_path, poll_seconds=3600.0, disk_reserve=0)
    with closing(open_store(settings)) as store:
        bench = Bench(settings, store)
        bench.dispatcher.start()
        store.create_sweep(sweep_of(1))
        [ticket] = wait_until(lambda: bench.engine.submitted)
        assert bench.inbox is not None
        bench.inbox.put(Ended(ticket.key, bench.compute(ticket)))
        wait_until(lambda: bench.run().state is State.SUCCEEDED)
        bench.dispatcher.close()
