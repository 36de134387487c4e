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
    done = store.sweeps.create(Submission(sweep_of(1))).id
    finish_all(store)
    cancelled = store.sweeps.create(Submission(sweep_of(runs_of("fine", first=10)))).id
    store.sweeps.cancel(cancelled)
    queued = store.sweeps.create(Submission(sweep_of(runs_of("fine", first=20)))).id
    first = store.sweeps.page(limit=2)
    rest = store.sweeps.page(limit=2, cursor=first.next_cursor)
    ids = [status.id for page in (first, rest) for status in page.items]
    assert (ids, rest.next_cursor) == ([queued, cancelled, done], None)
    expected = {SweepState.SUCCEEDED: [done], SweepState.CANCELLED: [cancelled], SweepState.QUEUED: [queued]}
    for state in SweepState:
        of_state = [status.id for status in store.sweeps.page(state=state).items]
        assert of_state == expected.get(state, [])


def test_points__are_paged_in_the_order_of_the_sweep(store: Store) -> None:
    sweep = store.sweeps.create(Submission(sweep_of(5))).id
    first = store.sweeps.points(sweep, limit=3)
    rest = store.sweeps.points(sweep, limit=3, cursor=first.next_cursor)
    points = [*first.items, *rest.items]
    assert [point.index for point in points] == [(0,), (1,), (2,), (3,), (4,)]
    assert points[2].coordinates == {"speed": 2000.0}
    assert rest.next_cursor is None
    [lease] = lease_runs(store, 1)
    store.leases.fail(lease, Cause.CRASH, failure="SIGSEGV", reason="died")
    [point] = store.sweeps.points(sweep, state=State.FAILED).items
    assert (point.run.id, point.run.reason) == (lease.id, "died")


@pytest.mark.parametrize("cursor", ["", "x", "-1", "1; drop table", "9" * 30, "٣"])
def test_cursor__that_no_page_gave_is_refused(store: Store, cursor: str) -> None:
    sweep = store.sweeps.create(Submission(sweep_of(1))).id
    with pytest.raises(InvalidInput, match="cursor"):
        store.sweeps.page(cursor=cursor)
    with pytest.raises(InvalidInput, match="cursor"):
        store.sweeps.points(sweep, cursor=cursor)


# --- tallies ---------------------------------------------------------------------------------------


def counting(store: Store, id: str) -> int:
    """Number of statements that count points when a sweep is shown."""
    with statements(store) as sent:
        store.sweeps.get(id)
    return len([text for text in sent if "count(" in text.lower()])


def test_tally__counts_runs_that_lost_an_answer(store: Store) -> None:
    sweep = store.sweeps.create(Submission(sweep_of(2))).id
    first, second = lease_runs(store, 2)
    store.leases.finish(first, result())
    store.leases.finish(second, replace(result(), reason="lost_particles: no final_length"))
    status = store.sweeps.get(sweep)
    assert (status.counts["succeeded"], status.lost_answers) == (2, 1)
    assert status.tally == "2 succeeded (1 of them lost an answer)"


def test_tally__of_an_ended_sweep_is_read_once(store: Store) -> None:
    sweep = store.sweeps.create(Submission(sweep_of(2))).id
    assert (counting(store, sweep), counting(store, sweep)) == (1, 1)
    finish_all(store)
    assert (counting(store, sweep), counting(store, sweep)) == (1, 0)
    assert store.sweeps.get(sweep) == store.sweeps.page().items[0]
    assert store.sweeps.get(sweep).counts["succeeded"] == 2


def test_tally__is_read_again_when_another_sweep_queues_a_run(store: Store, database_url: str) -> None:
    sweep = store.sweeps.create(Submission(sweep_of(1), keep=Keep.NUMBERS)).id
    finish_all(store)
    with closing(Store.open(database_url)) as replica:
        services = (store, replica)
        assert [service.sweeps.get(sweep).counts["succeeded"] for service in services] == [1, 1]
        store.sweeps.create(Submission(sweep_of(1), keep=Keep.FILM))
        assert [service.sweeps.get(sweep).counts["queued"] for service in services] == [1, 1]
        finish_all(store)
        assert [service.sweeps.get(sweep).counts["succeeded"] for service in services] == [1, 1]


# --- events ----------------------------------------------------------------------------------------


def test_events__of_a_sweep_of_a_run_and_of_everything(store: Store) -> None:
    assert store.events.last() == 0
    store.sweeps.create(Submission(sweep_of(1)))
    finish_all(store)
    sweep = store.sweeps.create(Submission(sweep_of(2))).id
    [lease] = lease_runs(store, 1)
    store.leases.requeue(lease, Cause.LOST, reason="worker lost")
    finish_all(store)
    events = store.events.of_sweep(sweep)
    assert [event.kind for event in events] == [
        *("accepted", "started", "requeued", "started", "succeeded", "started", "published")
    ]
    assert store.events.of_sweep(sweep, after=events[2].number) == events[3:]
    of_run = store.events.of_run(lease.id)
    assert [event.kind for event in of_run] == ["started", "requeued", "started", "succeeded"]
    assert of_run[1].body == {"attempt": 1, "cause": "lost", "reason": "worker lost"}
    everything = store.events.all()
    assert [event.number for event in everything] == sorted({one.number for one in everything})
    assert store.events.last() == everything[-1].number


# --- runs and the queue ----------------------------------------------------------------------------


def test_runs_under_way__have_the_sweeps_that_wait_for_them(store: Store) -> None:
    mine = store.sweeps.create(Submission(sweep_of(2))).id
    theirs = store.sweeps.create(Submission(sweep_of(1))).id
    shared, own = lease_runs(store, 2)
    waiting = {run.id: set(sweeps) for run, sweeps in store.runs.under_way()}
    assert waiting == {shared.id: {mine, theirs}, own.id: {mine}}
    store.sweeps.cancel(theirs)
    waiting = {run.id: set(sweeps) for run, sweeps in store.runs.under_way()}
    assert waiting == {shared.id: {mine}, own.id: {mine}}


def test_job_tally__is_by_kind_state_and_duration(store: Store) -> None:
    store.sweeps.create(Submission(sweep_of(3)))
    for lease in lease_runs(store, 2):
        store.leases.finish(lease, result())
    done = JobTally(Kind.RUN, State.SUCCEEDED, 2, 2, 4.0)
    queued = JobTally(Kind.RUN, State.QUEUED, None, 1, 0.0)
    waiting = JobTally(Kind.PUBLISH, State.WAITING, None, 1, 0.0)
    assert set(store.queue.tally((0.5, 1.0, 2.0))) == {done, queued, waiting}


def test_measured_rate__is_that_of_all_results_or_of_one_scenario(store: Store) -> None:
    assert store.runs.measured_rate() is None
    store.sweeps.create(Submission(sweep_of(1)))
    finish_all(store)
    scenario = store.runs.get(run_id(0)).scenario
    rates = [store.runs.measured_rate(of) for of in (None, scenario, "another")]
    assert rates == [2.0, 2.0, None]
