"""The dispatcher's thread: which service leads, what goes on after errors, and how it leaves."""

import shutil
from collections.abc import Iterator
from contextlib import closing
from pathlib import Path

import pytest

from service.queue.dispatcher import Dispatcher
from service.records.jobs import Cause, State, StoreUnavailable
from service.workers.attempt import Inbox
from tests.service.support.fakes import RecordingEngine, failing, open_store, wait_until
from tests.service.support.harness import AT_ONCE, Harness, open_harness


def lose_lead(harness: Harness) -> None:
    """Let the lead be lost while the database is away, at a tick that fails."""
    harness.terms.has_lost_lead = True
    with failing(harness.terms, "lead"), pytest.raises(StoreUnavailable):
        harness.tick()


def test_stand_by__has_no_engine_until_it_leads(harness: Harness) -> None:
    harness.terms.grants_lead = False
    assert harness.begin(1) == []
    assert harness.inbox is None  # no engine was opened
    assert (harness.dispatcher.leads(), harness.dispatcher.workers()) == (False, None)
    harness.terms.grants_lead = True
    assert len(harness.tick()) == 1
    assert (harness.dispatcher.leads(), harness.dispatcher.workers()) == (True, 2)


def test_lead_lost_to_another__leaves_what_is_under_way_to_it(harness: Harness) -> None:
    [attempt] = harness.begin(1)
    harness.terms.has_lost_lead, harness.terms.grants_lead = True, False
    harness.tick()
    assert (harness.engine.closed, harness.engine.stopped) == ([None], [])
    harness.end_well(attempt)
    harness.tick()
    assert harness.run().state is State.RUNNING  # for the other leader to register


def test_lead_lost_and_won_again__its_own_attempts_go_on(harness: Harness) -> None:
    first, second = harness.begin(2)
    lose_lead(harness)
    harness.end_well(first)
    harness.tick()
    harness.end_well(second)
    harness.tick()
    assert harness.engine.closed == []
    rows = [harness.run(number) for number in (0, 1)]
    assert {(row.state, row.attempt) for row in rows} == {(State.SUCCEEDED, 1)}


@pytest.mark.parametrize("is_replaced", [False, True])
def test_database__that_is_not_the_open_one_ends_the_lead_and_is_one_line_until_it_is_back(
    harness: Harness, tmp_path: Path, caplog: pytest.LogCaptureFixture, is_replaced: bool
) -> None:
    [attempt] = harness.begin(1)
    database, away = tmp_path / "whipple.db", tmp_path / "away"
    database.rename(away)
    if is_replaced:
        shutil.copy(away, database)
    for _ in range(3):
        assert harness.tick() == []
    assert not harness.dispatcher.leads()
    assert "whipple.db, which the service has open" in str(harness.dispatcher.blocked_reason())
    assert [record.levelname for record in caplog.records if "whipple.db" in record.message] == ["ERROR"]
    away.replace(database)
    harness.end_well(attempt)
    harness.tick()
    assert (harness.dispatcher.leads(), harness.is_first_success()) == (True, True)


def test_lead__is_not_said_while_the_database_refuses_the_ticks(harness: Harness) -> None:
    harness.begin(1)
    with failing(harness.store.leases, "held"), pytest.raises(StoreUnavailable):
        harness.tick()
    assert (harness.dispatcher.leads(), harness.dispatcher.is_refused()) == (False, True)
    assert harness.dispatcher.blocked_reason() is not None
    harness.tick()
    assert (harness.dispatcher.leads(), harness.dispatcher.is_refused()) == (True, False)
    assert harness.dispatcher.blocked_reason() is None


def test_lead_won_again__after_another_leader_stops_what_no_longer_counts(harness: Harness) -> None:
    [attempt] = harness.begin(1)
    lose_lead(harness)
    with closing(open_store(harness.settings)) as between:
        term = between.terms.begin("another")
        [lease] = between.leases.held()
        assert between.leases.requeue(lease, Cause.LOST, reason="its leader was gone")
        [lost] = between.leases.take(1, term)
        between.queue.set_blocked_reason("the other one has no worker")
    harness.tick()
    assert harness.engine.stopped == [lost.key, attempt.key]  # of the first a worker may know, of the other it does
    assert harness.store.queue.status().blocked_reason is None


def test_engine_that_does_not_start__is_reported_at_once_and_tried_again(harness: Harness) -> None:
    engines: Iterator[RecordingEngine | None] = iter([None, RecordingEngine()])

    def open_engine(_inbox: Inbox) -> RecordingEngine:
        engine = next(engines)
        if engine is None:
            raise OSError("no certificate")
        return engine

    dispatcher = Dispatcher(harness.settings, harness.store, open_engine=open_engine, timings=AT_ONCE)
    with pytest.raises(OSError, match="no certificate"):
        dispatcher.start()
    assert not dispatcher.is_alive()
    dispatcher.tick()
    assert dispatcher.leads()


def test_thread__goes_on_after_errors(harness: Harness, caplog: pytest.LogCaptureFixture) -> None:
    with failing(harness.store.leases, "held"):
        harness.dispatcher.start()  # though the store is away
        for _ in range(2):
            caplog.clear()
            harness.dispatcher.wake()
            wait_until(lambda: "the database is away" in caplog.messages)
        assert harness.dispatcher.is_alive()
    harness.submit(1)
    harness.dispatcher.wake()
    wait_until(lambda: harness.engine.submitted)
    harness.dispatcher.close()
    assert not harness.dispatcher.is_alive()


def test_close__queues_what_was_under_way_and_registers_what_ended(harness: Harness) -> None:
    harness.engine.free = 3
    ended, left, stopped = harness.begin(3)

    def end_two() -> None:
        harness.end_well(ended)
        harness.end_badly(left, Cause.LOST, failure="Left", checkpoint=40)

    harness.engine.while_closing = end_two
    harness.dispatcher.start()
    harness.dispatcher.close()
    assert harness.engine.closed == [harness.settings.leave_seconds]
    rows = [harness.run(number) for number in range(3)]
    assert [row.state for row in rows] == [State.SUCCEEDED, State.QUEUED, State.QUEUED]
    assert (rows[1].attempt, rows[1].crashes) == (1, 0)
    assert set(harness.engine.forgotten) == {ended.key, left.key, stopped.key}
    assert harness.store.leases.held() == ()


def test_submission__wakes_the_thread(tmp_path: Path) -> None:
    with open_harness(tmp_path, poll_seconds=3600.0) as harness:
        harness.dispatcher.start()
        harness.submit(1)
        [attempt] = wait_until(lambda: harness.engine.submitted)
        harness.end_well(attempt)
        wait_until(lambda: harness.run().state is State.SUCCEEDED)
        harness.dispatcher.close()
