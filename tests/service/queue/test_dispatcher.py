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
from service.records.attempt import Attempt, Ended, Inbox
from service.records.jobs import Cause, State, StoreUnavailable
from service.store import Leadership, Store
from tests.service.support.fakes import (
    RecordingEngine,
    open_store,
    settings_in,
    sweep_of,
    wait_until,
)
from tests.service.support.harness import Harness, open_harness


@pytest.fixture(autouse=True)
def _one_thread(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("NUMBA_NUM_THREADS", "1")


@pytest.fixture
def harness(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Harness]:
    monkeypatch.setattr("service.queue.dispatcher.TRY_SECONDS", 0.0)
    with open_harness(tmp_path) as opened:
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
def rivals(harness: Harness, monkeypatch: pytest.MonkeyPatch) -> Rivals:
    return Rivals(monkeypatch, harness.store)


# --- who leads -----------------------------------------------------------------------------------


def test_stand_by__without_an_engine_and_alive(harness: Harness, rivals: Rivals) -> None:
    rivals.lead = False
    harness.store.create_sweep(sweep_of(1))
    assert harness.turn() == []
    assert harness.inbox is None  # no engine was opened
    assert (harness.dispatcher.leads(), harness.dispatcher.workers()) == (False, None)
    rivals.lead = True
    assert len(harness.turn()) == 1
    assert (harness.dispatcher.leads(), harness.dispatcher.workers()) == (True, 2)


def test_lead_lost_to_another__lets_go_of_what_is_under_way(
    harness: Harness, rivals: Rivals
) -> None:
    harness.store.create_sweep(sweep_of(1))
    [ticket] = harness.turn()
    rivals.lost, rivals.lead = True, False
    harness.turn()
    assert harness.engine.closed == [None]
    assert harness.engine.stopped == []
    harness.end_well(ticket)
    harness.turn()
    assert harness.run().state is State.RUNNING  # for the other one to say


def test_lead_lost_and_found__goes_on_with_its_own_attempts(
    harness: Harness, rivals: Rivals
) -> None:
    harness.store.create_sweep(sweep_of(2))
    one, other = harness.turn()
    rivals.lost, rivals.away = True, True
    with pytest.raises(StoreUnavailable):
        harness.turn()
    harness.end_well(one)  # meanwhile
    with pytest.raises(StoreUnavailable):
        harness.turn()
    rivals.away = False
    harness.turn()
    assert harness.engine.closed == []
    assert (harness.run(0).state, harness.run(0).attempt) == (State.SUCCEEDED, 1)
    harness.end_well(other)
    harness.turn()
    assert (harness.run(1).state, harness.run(1).attempt) == (State.SUCCEEDED, 1)


def test_lead_lost_and_found__after_another_one_led_stops_what_no_longer_counts(
    harness: Harness, rivals: Rivals
) -> None:
    harness.store.create_sweep(sweep_of(1))
    [ticket] = harness.turn()
    rivals.lost, rivals.away = True, True
    with pytest.raises(StoreUnavailable):
        harness.turn()
    between = open_store(harness.settings)
    with closing(between):
        epoch = between.begin_epoch("another")
        [claim] = between.claimed()
        assert between.requeue(claim, Cause.LOST, reason="its leader was gone")
        assert between.claim(1, epoch)
    rivals.away = False
    harness.turn()
    assert harness.engine.stopped == [ticket.key]


@pytest.fixture
def usurped(harness: Harness) -> Attempt:
    """An attempt that was under way when somebody who should not began a younger epoch."""
    harness.store.create_sweep(sweep_of(2))
    ticket, other = harness.turn()
    harness.end_badly(other, Cause.LOST)
    with closing(open_store(harness.settings)) as elsewhere:
        elsewhere.begin_epoch("another")
    return ticket


def test_younger_epoch__ends_the_reign_and_who_has_the_right_begins_another(
    harness: Harness, usurped: Attempt, caplog: pytest.LogCaptureFixture
) -> None:
    epoch = harness.store.queue().epoch
    assert harness.turn() == []
    [again] = harness.turn()
    assert again.key != usurped.key
    assert harness.store.queue().epoch == epoch + 1
    assert [record.getMessage() for record in caplog.records].count(OTHER_LEADER) == 1
    assert harness.turn() == []
    assert harness.store.queue().epoch == epoch + 1


def test_younger_epoch__what_is_under_way_goes_on(harness: Harness, usurped: Attempt) -> None:
    harness.turn()
    harness.turn()
    assert (harness.engine.stopped, harness.engine.closed) == ([], [])
    harness.end_well(usurped)
    harness.turn()
    assert (harness.run().state, harness.run().attempt) == (State.SUCCEEDED, 1)


def test_younger_epoch__what_hinders_the_earlier_one_is_not_said(harness: Harness) -> None:
    harness.turn()
    with closing(open_store(harness.settings)) as elsewhere:
        elsewhere.begin_epoch("another")
    harness.engine.free = 0
    harness.turn()
    assert harness.dispatcher.trouble() == NO_WORKER
    assert harness.store.queue().hindrance is None


def test_lead_lost_and_found__what_another_leader_said_is_said_no_longer(
    harness: Harness, rivals: Rivals
) -> None:
    harness.turn()
    rivals.lost, rivals.away = True, True
    with pytest.raises(StoreUnavailable):
        harness.turn()
    harness.store.hinder("the other one has no worker")
    rivals.away = False
    harness.turn()
    assert harness.store.queue().hindrance is None


def test_lead_lost_while_the_engine_starts__begins_no_epoch(
    harness: Harness, rivals: Rivals, monkeypatch: pytest.MonkeyPatch
) -> None:
    def lose() -> RecordingEngine:
        rivals.lost, rivals.lead = True, False
        return harness.engine

    monkeypatch.setattr(harness.dispatcher, "_open_engine", lambda _inbox: lose())
    harness.turn()
    harness.turn()
    assert harness.store.queue().epoch == 0
    assert not harness.dispatcher.leads()


def test_leader__of_postgresql_is_one_and_the_next_takes_over(
    tmp_path: Path, postgresql_url: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("service.queue.dispatcher.TRY_SECONDS", 0.1)
    settings = settings_in(tmp_path, database_url=postgresql_url, poll_seconds=0.05)
    with closing(open_store(settings)) as one, closing(open_store(settings)) as other:
        first, second = (
            Dispatcher(settings, store, open_engine=lambda _inbox: RecordingEngine())
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
        harness = Harness(settings, store)
        store.create_sweep(sweep_of(1))
        [ticket] = harness.turn()
        epoch = store.queue().epoch
        leadership = harness.dispatcher._leadership
        assert leadership is not None
        leadership.close()
        harness.turn()
        assert store.queue().epoch == epoch + 1
        assert harness.engine.closed == []
        assert harness.run().attempt == 1
        assert [claim.key for claim in store.claimed()] == [ticket.key]


# --- trouble -------------------------------------------------------------------------------------


def test_start__an_engine_that_does_not_start_is_told_at_once(harness: Harness) -> None:
    def refuse(_inbox: Inbox) -> RecordingEngine:
        raise OSError("no certificate")

    dispatcher = Dispatcher(harness.settings, harness.store, open_engine=refuse)
    with pytest.raises(OSError, match="no certificate"):
        dispatcher.start()
    assert not dispatcher.is_alive()


def test_engine_that_does_not_start__after_a_change_of_leader_is_tried_again(
    harness: Harness,
) -> None:
    opened: list[float] = []

    def refuse_once(_inbox: Inbox) -> RecordingEngine:
        opened.append(time.monotonic())
        if len(opened) == 1:
            raise OSError("no certificate")
        return harness.engine

    dispatcher = Dispatcher(harness.settings, harness.store, open_engine=refuse_once)
    with pytest.raises(OSError, match="no certificate"):
        dispatcher.turn()
    dispatcher.turn()
    assert dispatcher.leads()


def test_thread__goes_on_after_trouble(harness: Harness, monkeypatch: pytest.MonkeyPatch) -> None:
    turns: SimpleQueue[float] = SimpleQueue()

    def trouble() -> None:
        turns.put(time.monotonic())
        raise RuntimeError("nobody foresaw this")

    harness.dispatcher.start()
    monkeypatch.setattr(harness.dispatcher, "turn", trouble)
    for _ in range(3):
        harness.dispatcher.wake()
        assert turns.get(timeout=60.0)
    assert harness.dispatcher.is_alive()
    harness.dispatcher.close()
    assert not harness.dispatcher.is_alive()


def test_alive__not_when_no_turn_has_succeeded_for_long(
    harness: Harness, monkeypatch: pytest.MonkeyPatch
) -> None:
    harness.dispatcher.start()
    monkeypatch.setattr("service.queue.dispatcher.STUCK_SECONDS", 0.0)
    assert not harness.dispatcher.is_alive()
    harness.dispatcher.close()


def test_store_away_at_the_start__is_waited_for(
    harness: Harness, monkeypatch: pytest.MonkeyPatch
) -> None:
    def away() -> Any:
        raise StoreUnavailable("locked")

    harness.store.create_sweep(sweep_of(1))
    with monkeypatch.context() as patch:
        patch.setattr(harness.store, "claimed", away)
        harness.dispatcher.start()
        assert harness.engine.submitted == []
    wait_until(lambda: harness.engine.submitted)
    harness.dispatcher.close()


# --- leaving -------------------------------------------------------------------------------------


def test_close__what_was_under_way_is_queued_and_what_had_ended_is_kept(harness: Harness) -> None:
    harness.store.create_sweep(sweep_of(2))
    done, _ = harness.turn()
    harness.end_well(done)
    harness.dispatcher.start()
    harness.dispatcher.close()
    assert harness.engine.closed == [harness.settings.leave_seconds]
    assert harness.run(0).state is State.SUCCEEDED
    assert harness.run(1).state is State.QUEUED
    assert harness.store.claimed() == ()


def test_close__what_ends_while_the_engine_closes_counts(
    harness: Harness, monkeypatch: pytest.MonkeyPatch
) -> None:
    def close(_seconds: float | None) -> None:
        harness.end_well(done)
        harness.end_badly(left, Cause.LOST, failure="Left", checkpoint=40)

    harness.store.create_sweep(sweep_of(2))
    done, left = harness.turn()
    monkeypatch.setattr(harness.engine, "close", close)
    harness.dispatcher.start()
    harness.dispatcher.close()
    assert harness.run(0).state is State.SUCCEEDED
    run = harness.run(1)
    assert (run.state, run.attempt, run.crashes) == (State.QUEUED, 1, 0)
    assert sorted(harness.engine.forgotten) == sorted([done.key, left.key])


def test_leave__claims_nothing_more(harness: Harness) -> None:
    harness.engine.free = 0
    harness.store.create_sweep(sweep_of(2))
    harness.dispatcher.start()
    harness.dispatcher.leave()
    harness.engine.free = 2
    harness.dispatcher.close()
    assert harness.engine.submitted == []
    assert harness.run().attempt == 0


def test_close__a_store_that_is_away_does_not_hold_it_up(
    harness: Harness, monkeypatch: pytest.MonkeyPatch
) -> None:
    def away(*_arguments: Any, **_words: Any) -> bool:
        raise StoreUnavailable("locked")

    harness.store.create_sweep(sweep_of(1))
    harness.turn()
    harness.dispatcher.start()
    monkeypatch.setattr(harness.store, "requeue", away)
    harness.dispatcher.close()
    assert harness.run().state is State.RUNNING  # the next life finds it
    assert harness.engine.closed


def test_order__wakes_the_thread(tmp_path: Path) -> None:
    settings = settings_in(tmp_path, poll_seconds=3600.0, disk_reserve=0)
    with closing(open_store(settings)) as store:
        harness = Harness(settings, store)
        harness.dispatcher.start()
        store.create_sweep(sweep_of(1))
        [ticket] = wait_until(lambda: harness.engine.submitted)
        assert harness.inbox is not None
        harness.inbox.put(Ended(ticket.key, harness.compute(ticket)))
        wait_until(lambda: harness.run().state is State.SUCCEEDED)
        harness.dispatcher.close()
