"""What the store answers: pages of sweeps and points, events, the queue as a whole."""

import pytest

from service.records.jobs import Cause, JobTally, Kind, State, SweepState
from service.store import Store
from studies.values.errors import InvalidInput
from tests.service.support.fakes import run_id, runs_of, sweep_of
from tests.service.support.rows import claim_runs, finish_all, result


def test_sweeps__pages_are_complete_and_youngest_first(store: Store) -> None:
    ids = [store.create_sweep(sweep_of(1, name=f"s{number}")).id for number in range(5)]
    seen, cursor = [], None
    while True:
        page = store.sweeps(limit=2, cursor=cursor)
        seen += [row.id for row in page.items]
        cursor = page.next_cursor
        if cursor is None:
            break
    assert seen == ids[::-1]


def test_sweeps__can_be_asked_for_by_state(store: Store) -> None:
    done = store.create_sweep(sweep_of(1))
    finish_all(store)
    cancelled = store.create_sweep(sweep_of(runs_of("fine", first=10)))
    store.cancel_sweep(cancelled.id)
    queued = store.create_sweep(sweep_of(runs_of("fine", first=20)))
    expected = {
        SweepState.SUCCEEDED: done.id,
        SweepState.CANCELLED: cancelled.id,
        SweepState.QUEUED: queued.id,
    }
    for state in SweepState:
        found = [row.id for row in store.sweeps(state=state).items]
        assert found == ([expected[state]] if state in expected else [])


def test_points__pages_in_the_order_of_the_sweep_with_coordinates(store: Store) -> None:
    row = store.create_sweep(sweep_of(5))
    first = store.sweep_runs(row.id, limit=3)
    rest = store.sweep_runs(row.id, limit=3, cursor=first.next_cursor)
    points = [*first.items, *rest.items]
    assert [point.index for point in points] == [(0,), (1,), (2,), (3,), (4,)]
    assert points[2].coordinates == {"speed": 2000.0}
    assert rest.next_cursor is None


def test_points__can_be_asked_for_by_state(store: Store) -> None:
    row = store.create_sweep(sweep_of(3))
    _, bad, _ = claim_runs(store, 3)
    store.fail(bad, Cause.CRASH, failure="SIGSEGV", reason="died")
    [point] = store.sweep_runs(row.id, state=State.FAILED).items
    assert (point.run.id, point.run.reason) == (bad.id, "died")


@pytest.mark.parametrize("cursor", ["", "x", "-1", "1; drop table", "9" * 30, "٣"])
def test_cursor__only_one_that_a_page_gave(store: Store, cursor: str) -> None:
    row = store.create_sweep(sweep_of(1))
    with pytest.raises(InvalidInput, match="cursor"):
        store.sweeps(cursor=cursor)
    with pytest.raises(InvalidInput, match="cursor"):
        store.sweep_runs(row.id, cursor=cursor)


def test_events__tell_the_story_of_a_sweep_and_of_nothing_else(store: Store) -> None:
    store.create_sweep(sweep_of(1))
    finish_all(store)
    row = store.create_sweep(sweep_of(runs_of("fine", first=5)))
    [claim] = claim_runs(store, 1)
    store.requeue(claim, Cause.LOST, reason="worker lost")
    finish_all(store)
    events = store.events(row.id)
    assert [event.kind for event in events] == [
        *("accepted", "started", "requeued", "started", "succeeded", "started", "published")
    ]
    assert store.events(row.id, after=events[2].number) == events[3:]
    numbers = [event.number for event in events]
    assert numbers == sorted(set(numbers))


def test_known_runs__those_that_need_no_computation(store: Store) -> None:
    store.create_sweep(sweep_of(3))
    done, accident, _ = claim_runs(store, 3)
    store.finish(done, result())
    store.fail(accident, Cause.CRASH, failure="SIGSEGV", reason="died")
    assert len(store.known_runs(run_id(number) for number in range(2000))) == 2


def test_events__of_a_run_and_of_everything(store: Store) -> None:
    store.create_sweep(sweep_of(2))
    one, other = claim_runs(store, 2)
    store.finish(one, result())
    store.requeue(other, Cause.LOST, reason="worker lost")
    assert [event.kind for event in store.run_events(one.id)] == ["started", "succeeded"]
    [_, requeued] = store.run_events(other.id)
    assert requeued.body == {"attempt": 1, "cause": "lost", "reason": "worker lost"}
    everything = store.all_events()
    assert [event.kind for event in everything] == [
        *("accepted", "started", "started", "succeeded", "requeued")
    ]
    assert store.last_event() == everything[-1].number == requeued.number
    assert store.all_events(after=everything[2].number, limit=1) == everything[3:4]


def test_events__there_are_none_at_first(store: Store) -> None:
    assert store.last_event() == 0


def test_under_way__runs_with_the_sweeps_that_wait_for_them(store: Store) -> None:
    mine, theirs = store.create_sweep(sweep_of(2)), store.create_sweep(sweep_of(1))
    store.create_sweep(sweep_of(runs_of("fine", first=9)))
    shared, own = claim_runs(store, 2)
    waiting = {run.id: set(sweeps) for run, sweeps in store.under_way()}
    assert waiting[shared.id] == {mine.id, theirs.id}
    store.cancel_sweep(theirs.id)
    waiting = {run.id: set(sweeps) for run, sweeps in store.under_way()}
    assert waiting[shared.id] == {mine.id}
    assert own.id in waiting


def test_queue__tells_states_and_the_oldest_wait(store: Store) -> None:
    assert store.queue().oldest_queued is None
    row = store.create_sweep(sweep_of(3))
    claim_runs(store, 1)
    seen = store.queue()
    assert seen.states == {State.QUEUED: 2, State.RUNNING: 1, State.WAITING: 1}
    assert seen.oldest_queued == row.created
    assert (seen.paused, seen.hindrance) == (None, None)


def test_tally__jobs_by_kind_state_and_duration(store: Store) -> None:
    store.create_sweep(sweep_of(3))
    for claim in claim_runs(store, 2):
        store.finish(claim, result())
    done = JobTally(Kind.RUN, State.SUCCEEDED, 2, 2, 4.0)
    queued = JobTally(Kind.RUN, State.QUEUED, None, 1, 0.0)
    waiting = JobTally(Kind.PUBLISH, State.WAITING, None, 1, 0.0)
    assert set(store.tally((0.5, 1.0, 2.0))) == {done, queued, waiting}


def test_pace__of_all_results_or_of_one_scenario(store: Store) -> None:
    assert store.pace() is None
    store.create_sweep(sweep_of(1))
    finish_all(store)
    assert store.pace() == 2.0
    assert store.pace(store.run(run_id(0)).scenario) == 2.0
    assert store.pace("another") is None
