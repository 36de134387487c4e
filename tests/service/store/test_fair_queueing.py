"""Fairness between sweeps, priorities of shared runs, quotas of owners, a paused queue."""

from dataclasses import replace

import pytest

from service.records.jobs import Cause, Conflict, Keep, Kind, Quota, QuotaExceeded, State, Submission
from service.store import Store
from tests.claims.marked import Compared
from tests.claims.rows import equal
from tests.service.support.fakes import run_id, runs_of, sweep_of
from tests.service.support.rows import TERM, finish_all, lease_runs, result

ONE_RUN = 1  # shares are exact to this: a new sweep begins beside the run that was leased last


def submit(store: Store, first: int, count: int, *, priority: int = 0, owner: str = "") -> str:
    """A sweep of so many runs, numbered from ``first``."""
    runs = runs_of(*["fine"] * count, first=first)
    return store.sweeps.create(Submission(sweep_of(runs), priority=priority, owner=owner)).id


def leased(store: Store, count: int) -> list[int]:
    """Numbers of the runs that are leased next, one at a time."""
    return [int(lease_runs(store, 1)[0].id, 16) for _ in range(count)]


def of_the_first(numbers: list[int]) -> int:
    """How many of these runs are of the first sweep."""
    return len([number for number in numbers if number < 100])


def priorities(store: Store, count: int) -> list[int]:
    return [store.runs.get(run_id(number)).priority for number in range(count)]


def test_later_sweep__neither_waits_for_a_long_one_nor_catches_up(store: Store) -> None:
    submit(store, 0, 80)
    leased(store, 20)
    submit(store, 100, 30)
    assert of_the_first(leased(store, 10)) == pytest.approx(5, abs=ONE_RUN)
    submit(store, 70, 2)  # of the first sweep's own runs
    assert {70, 71} < set(leased(store, 6))


def test_shares__are_of_cost(store: Store) -> None:
    store.sweeps.create(Submission(sweep_of(runs_of(*["fine"] * 10, first=0, cost=10))))
    store.sweeps.create(Submission(sweep_of(runs_of(*["fine"] * 100, first=100, cost=1))))
    assert of_the_first(leased(store, 44)) == pytest.approx(4, abs=ONE_RUN)


def test_retried_runs__queue_up_like_new_ones(store: Store) -> None:
    sweep = submit(store, 0, 6)
    for lease in lease_runs(store, 6):
        store.leases.fail(lease, Cause.CRASH, failure="SIGSEGV", reason="")
    finish_all(store)
    submit(store, 100, 30)
    leased(store, 10)
    store.sweeps.retry(sweep)
    assert of_the_first(leased(store, 12)) == 6


@pytest.mark.claim("doors", "two-owners")
def test_owner__with_few_runs_waits_for_no_more_of_another_whatever_the_number_of_sweeps(
    store: Store, compared: Compared
) -> None:
    """Beside 10 sweeps of 1 000 runs, a sweep of another owner that comes later gets every second run: 10 take 20."""
    for number in range(10):
        submit(store, 1000 * number, 1000, owner="many")
    leased(store, 50)
    submit(store, 20_000, 10, owner="few")
    order = leased(store, 20)
    compared(equal("runs of the second owner among 20", expected=10, got=sum(run >= 20_000 for run in order)))
    sweeps = {run // 1000 for run in order if run < 20_000}
    compared(equal("sweeps of the first owner among them", expected=10, got=len(sweeps)))


def test_owner__that_returns_neither_catches_up_nor_waits(store: Store) -> None:
    submit(store, 0, 100, owner="a")
    submit(store, 100, 5, owner="b")
    leased(store, 60)
    submit(store, 200, 100, owner="b")
    assert of_the_first(leased(store, 20)) == pytest.approx(10, abs=ONE_RUN)


def test_owner__that_returns_begins_beside_the_least_served_of_the_others(store: Store) -> None:
    """One run of ``dear`` costs as much as fifty of ``cheap``, who is behind until then."""
    store.sweeps.create(Submission(sweep_of(runs_of(*["fine"] * 2, first=1000, cost=50)), owner="dear"))
    submit(store, 0, 100, owner="cheap")
    submit(store, 200, 1, owner="returns")
    leased(store, 6)
    submit(store, 300, 100, owner="returns")
    order = leased(store, 20)
    assert sum(300 <= run < 400 for run in order) == pytest.approx(10, abs=ONE_RUN)
    assert of_the_first(order) == pytest.approx(10, abs=ONE_RUN)


def test_shared_run__is_of_the_owner_for_whom_it_comes_sooner_and_goes_back(store: Store) -> None:
    submit(store, 0, 80, owner="a")
    joined = submit(store, 70, 5, owner="b")
    assert {70, 71} < set(leased(store, 5))
    store.sweeps.cancel(joined)
    assert {72, 73, 74} < set(leased(store, 75))
    assert store.leases.take(1, TERM) == ()


def test_shared_run__has_the_priority_of_the_most_urgent_sweep(store: Store) -> None:
    patient = submit(store, 0, 3, priority=5)
    urgent = submit(store, 2, 2, priority=-5)
    assert priorities(store, 4) == [5, 5, -5, -5]
    [lease] = lease_runs(store, 1)
    assert lease.id == run_id(2)
    assert store.sweeps.set_priority(patient, 10).priority == 10
    assert store.events.of_sweep(patient)[-1].body == {"priority": 10}
    assert priorities(store, 4) == [10, 10, -5, -5]
    store.sweeps.cancel(urgent)
    assert priorities(store, 3) == [10, 10, 10]  # of the running one too
    assert store.leases.finish(lease, result())
    finish_all(store)
    with pytest.raises(Conflict, match="ended"):
        store.sweeps.set_priority(patient, 1)


def test_moved_sweep__begins_at_the_virtual_time_of_its_new_class(store: Store) -> None:
    first = submit(store, 0, 50, priority=3)
    submit(store, 100, 100)
    leased(store, 30)
    store.sweeps.set_priority(first, 0)
    assert of_the_first(leased(store, 10)) == pytest.approx(5, abs=ONE_RUN)


def test_quota__of_files_is_charged_for_runs_of_sweeps_of_the_owner(store: Store) -> None:
    deleted = submit(store, 0, 1, owner="anna")
    finish_all(store)
    another = Submission(sweep_of(runs_of("fine", first=9)), owner="anna", quota=Quota(9, 9, 1))
    with pytest.raises(QuotaExceeded, match="of files"):
        store.sweeps.create(another)
    submit(store, 0, 1, owner="bob")
    store.sweeps.delete(deleted)
    assert store.sweeps.create(another).new == 1


def test_quota__of_runs_counts_those_that_a_sweep_brings_into_the_queue(store: Store) -> None:
    submit(store, 0, 3)
    finish_all(store)
    asks = Submission(sweep_of(4), owner="anna", quota=Quota(9, 1, 1))
    with pytest.raises(QuotaExceeded, match="0 runs under way and asks for 4"):
        store.sweeps.create(replace(asks, keep=Keep.FILM))
    assert store.sweeps.create(asks).new == 1


def test_pause__lets_runs_under_way_end_and_sweeps_be_published(store: Store) -> None:
    calls: list[None] = []
    store.on_command(lambda: calls.append(None))
    submit(store, 0, 1)
    submit(store, 10, 2)
    [lease] = lease_runs(store, 1)
    since = store.queue.pause().paused
    assert since is not None
    assert store.queue.pause().paused == since  # pausing twice changes nothing
    assert store.leases.take(9, TERM) == ()
    assert store.leases.finish(lease, result())
    assert [publication.kind for publication in store.leases.take(9, TERM)] == [Kind.PUBLISH]
    assert store.queue.status().states[State.QUEUED] == 2
    assert store.queue.resume().paused is None
    assert len(lease_runs(store, 2)) == 2
    kinds = [event.kind for event in store.events.all()]
    assert (kinds.count("paused"), kinds.count("resumed")) == (1, 1)
    assert len(calls) == 5  # the dispatcher is woken by every command
