"""Queries: pages of sweeps and points, tallies, events, the queue as a whole."""

from contextlib import closing
from dataclasses import replace

import pytest

from service.records.jobs import Cause, JobTally, Keep, Kind, State, Submission, SweepState
from service.store import Store
from studies.values.errors import InvalidInput
from tests.service.support.fakes import run_id, runs_of, sweep_of
from tests.service.support.rows import finish_all, lease_runs, result, statements


def test_sweeps__are_paged_youngest_first_and_filtered_by_state(store: Store) -> None:
    done = store.create_sweep(Submission(sweep_of(1))).id
    finish_all(store)
    cancelled = store.create_sweep(Submission(sweep_of(runs_of("fine", first=10)))).id
    store.cancel_sweep(cancelled)
    queued = store.create_sweep(Submission(sweep_of(runs_of("fine", first=20)))).id
    first = store.sweeps(limit=2)
    rest = store.sweeps(limit=2, cursor=first.next_cursor)
    ids = [status.id for page in (first, rest) for status in page.items]
    assert (ids, rest.next_cursor) == ([queued, cancelled, done], None)
    expected = {SweepState.SUCCEEDED: [done], SweepState.CANCELLED: [cancelled], SweepState.QUEUED: [queued]}
    for state in SweepState:
        of_state = [status.id for status in store.sweeps(state=state).items]
        assert of_state == expected.get(state, [])


def test_points__are_paged_in_the_order_of_the_sweep(store: Store) -> None:
    sweep = store.create_sweep(Submission(sweep_of(5))).id
    first = store.sweep_runs(sweep, limit=3)
    rest = store.sweep_runs(sweep, limit=3, cursor=first.next_cursor)
    points = [*first.items, *rest.items]
    assert [point.index for point in points] == [(0,), (1,), (2,), (3,), (4,)]
    assert points[2].coordinates == {"speed": 2000.0}
    assert rest.next_cursor is None
    [lease] = lease_runs(store, 1)
    store.fail(lease, Cause.CRASH, failure="SIGSEGV", reason="died")
    [point] = store.sweep_runs(sweep, state=State.FAILED).items
    assert (point.run.id, point.run.reason) == (lease.id, "died")


@pytest.mark.parametrize("cursor", ["", "x", "-1", "1; drop table", "9" * 30, "٣"])
def test_cursor__that_no_page_gave_is_refused(store: Store, cursor: str) -> None:
    sweep = store.create_sweep(Submission(sweep_of(1))).id
    with pytest.raises(InvalidInput, match="cursor"):
        store.sweeps(cursor=cursor)
    with pytest.raises(InvalidInput, match="cursor"):
        store.sweep_runs(sweep, cursor=cursor)


# --- tallies ---------------------------------------------------------------------------------------


def counting(store: Store, id: str) -> int:
    """Number of statements that count points when a sweep is shown."""
    with statements(store) as sent:
        store.sweep(id)
    return len([text for text in sent if "count(" in text.lower()])


def test_tally__counts_runs_that_lost_an_answer(store: Store) -> None:
    sweep = store.create_sweep(Submission(sweep_of(2))).id
    first, second = lease_runs(store, 2)
    store.finish(first, result())
    store.finish(second, replace(result(), reason="lost_particles: no final_length"))
    status = store.sweep(sweep)
    assert (status.counts["succeeded"], status.lost_answers) == (2, 1)
    assert status.tally == "2 succeeded (1 of them lost an answer)"


def test_tally__of_an_ended_sweep_is_read_once(store: Store) -> None:
    sweep = store.create_sweep(Submission(sweep_of(2))).id
    assert (counting(store, sweep), counting(store, sweep)) == (1, 1)
    finish_all(store)
    assert (counting(store, sweep), counting(store, sweep)) == (1, 0)
    assert store.sweep(sweep) == store.sweeps().items[0]
    assert store.sweep(sweep).counts["succeeded"] == 2


def test_tally__is_read_again_when_another_sweep_queues_a_run(store: Store, database_url: str) -> None:
    sweep = store.create_sweep(Submission(sweep_of(1), keep=Keep.NUMBERS)).id
    finish_all(store)
    with closing(Store.open(database_url)) as replica:
        services = (store, replica)
        assert [service.sweep(sweep).counts["succeeded"] for service in services] == [1, 1]
        store.create_sweep(Submission(sweep_of(1), keep=Keep.FILM))
        assert [service.sweep(sweep).counts["queued"] for service in services] == [1, 1]
        finish_all(store)
        assert [service.sweep(sweep).counts["succeeded"] for service in services] == [1, 1]


def test_tally__is_read_again_after_a_retry(store: Store) -> None:
    mine, _ = (store.create_sweep(Submission(sweep_of(1))).id for _ in range(2))
    lease_runs(store, 1)
    assert store.cancel_sweep(mine).state is SweepState.CANCELLED
    assert store.sweep(mine).counts["cancelled"] == 1
    store.retry_sweep(mine)
    assert store.sweep(mine).counts["running"] == 1


# --- events ----------------------------------------------------------------------------------------


def test_events__of_a_sweep_of_a_run_and_of_everything(store: Store) -> None:
    assert store.last_event() == 0
    store.create_sweep(Submission(sweep_of(1)))
    finish_all(store)
    sweep = store.create_sweep(Submission(sweep_of(2))).id
    [lease] = lease_runs(store, 1)
    store.requeue(lease, Cause.LOST, reason="worker lost")
    finish_all(store)
    events = store.events(sweep)
    assert [event.kind for event in events] == [
        *("accepted", "started", "requeued", "started", "succeeded", "started", "published")
    ]
    assert store.events(sweep, after=events[2].number) == events[3:]
    of_run = store.run_events(lease.id)
    assert [event.kind for event in of_run] == ["started", "requeued", "started", "succeeded"]
    assert of_run[1].body == {"attempt": 1, "cause": "lost", "reason": "worker lost"}
    everything = store.all_events()
    assert [event.number for event in everything] == sorted({one.number for one in everything})
    assert store.last_event() == everything[-1].number


# --- runs and the queue ----------------------------------------------------------------------------


def test_known_runs__need_no_computation(store: Store) -> None:
    store.create_sweep(Submission(sweep_of(3)))
    done, accident, _ = lease_runs(store, 3)
    store.finish(done, result())
    store.fail(accident, Cause.CRASH, failure="SIGSEGV", reason="died")
    assert len(store.known_runs(run_id(number) for number in range(2000))) == 2


def test_runs_under_way__have_the_sweeps_that_wait_for_them(store: Store) -> None:
    mine = store.create_sweep(Submission(sweep_of(2))).id
    theirs = store.create_sweep(Submission(sweep_of(1))).id
    shared, own = lease_runs(store, 2)
    waiting = {run.id: set(sweeps) for run, sweeps in store.under_way()}
    assert waiting == {shared.id: {mine, theirs}, own.id: {mine}}
    store.cancel_sweep(theirs)
    waiting = {run.id: set(sweeps) for run, sweeps in store.under_way()}
    assert waiting == {shared.id: {mine}, own.id: {mine}}


def test_queue__has_jobs_by_state_and_the_oldest_wait(store: Store) -> None:
    assert store.queue().oldest_queued is None
    status = store.create_sweep(Submission(sweep_of(3)))
    lease_runs(store, 1)
    queue = store.queue()
    assert queue.states == {State.QUEUED: 2, State.RUNNING: 1, State.WAITING: 1}
    assert queue.oldest_queued == status.created
    assert (queue.paused, queue.blocked_reason) == (None, None)


def test_job_tally__is_by_kind_state_and_duration(store: Store) -> None:
    store.create_sweep(Submission(sweep_of(3)))
    for lease in lease_runs(store, 2):
        store.finish(lease, result())
    done = JobTally(Kind.RUN, State.SUCCEEDED, 2, 2, 4.0)
    queued = JobTally(Kind.RUN, State.QUEUED, None, 1, 0.0)
    waiting = JobTally(Kind.PUBLISH, State.WAITING, None, 1, 0.0)
    assert set(store.tally((0.5, 1.0, 2.0))) == {done, queued, waiting}


def test_measured_rate__is_that_of_all_results_or_of_one_scenario(store: Store) -> None:
    assert store.measured_rate() is None
    store.create_sweep(Submission(sweep_of(1)))
    finish_all(store)
    scenario = store.run(run_id(0)).scenario
    rates = [store.measured_rate(of) for of in (None, scenario, "another")]
    assert rates == [2.0, 2.0, None]
