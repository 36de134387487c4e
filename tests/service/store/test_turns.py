"""Whose turn it is: fairness between sweeps, priorities of shared runs, a queue that is paused."""

from collections.abc import Iterator
from contextlib import closing

import pytest

from service.records.jobs import Cause, Claim, Conflict, Kind, State
from service.store import Store
from tests.service.support.fakes import run_id, runs_of, sweep_of
from tests.service.support.rows import TERM, claim_runs, finish_all, result
from tests.service.support.targets import FakeRun

ONE_RUN = 1  # shares are exact to this: who comes new begins beside the run that was claimed last


def order(store: Store, count: int) -> list[int]:
    """Numbers of the runs that are claimed next, one at a time."""
    return [int(claim_runs(store, 1)[0].id, 16) for _ in range(count)]


def of_the_old(taken: list[int]) -> int:
    """How many of these runs are of the sweep that was there first."""
    return len([number for number in taken if number < 100])


def sweep_from(first: int, count: int) -> list[FakeRun]:
    return runs_of(*["fine"] * count, first=first)


# --- fairness --------------------------------------------------------------------------------------


def test_turns__a_sweep_is_worked_through_in_its_own_order(store: Store) -> None:
    store.create_sweep(sweep_of(3))
    assert order(store, 3) == [0, 1, 2]


def test_turns__two_sweeps_get_equal_shares(store: Store) -> None:
    store.create_sweep(sweep_of(sweep_from(0, 6)))
    store.create_sweep(sweep_of(sweep_from(100, 6)))
    taken = order(store, 12)
    for end in range(2, 13, 2):
        assert of_the_old(taken[:end]) == end // 2


def test_turns__a_small_sweep_does_not_wait_for_a_long_one(store: Store) -> None:
    store.create_sweep(sweep_of(sweep_from(0, 200)))
    order(store, 50)
    store.create_sweep(sweep_of(sweep_from(1000, 2)))
    assert {1000, 1001} < set(order(store, 4))


def test_turns__a_late_sweep_takes_nothing_for_the_time_before_it_came(store: Store) -> None:
    store.create_sweep(sweep_of(sweep_from(0, 30)))
    order(store, 20)
    store.create_sweep(sweep_of(sweep_from(100, 30)))
    taken = order(store, 10)
    assert of_the_old(taken) == pytest.approx(5, abs=ONE_RUN)


@pytest.fixture
def dear(database_url: str) -> Iterator[Store]:
    """A store in which a run costs what it says."""
    with closing(
        Store.open(database_url, cost=lambda run: float(str(run.parameters["cost"])))
    ) as opened:
        yield opened


def test_turns__shares_are_of_cost_and_not_of_runs(dear: Store) -> None:
    dear.create_sweep(sweep_of(runs_of(*["fine"] * 10, first=0, cost=10)))
    dear.create_sweep(sweep_of(runs_of(*["fine"] * 100, first=100, cost=1)))
    taken = order(dear, 44)
    assert of_the_old(taken) == pytest.approx(4, abs=ONE_RUN)


def test_turns__what_is_done_already_holds_nothing_up(store: Store) -> None:
    store.create_sweep(sweep_of(50))
    finish_all(store)
    store.create_sweep(sweep_of(sweep_from(100, 3)))
    store.create_sweep(sweep_of(51))  # its last point alone is new
    assert run_number(50) in order(store, 2)


def run_number(number: int) -> int:
    return int(run_id(number), 16)


def test_turns__a_joined_run_comes_when_the_small_sweep_may_ask_for_it(store: Store) -> None:
    store.create_sweep(sweep_of(sweep_from(0, 100)))
    order(store, 5)
    store.create_sweep(sweep_of(sweep_from(90, 2)))
    assert {90, 91} < set(order(store, 4))


def test_turns__a_lost_run_comes_again_at_once(store: Store) -> None:
    store.create_sweep(sweep_of(10))
    [first, *_] = claim_runs(store, 4)
    store.requeue(first, Cause.LOST, reason="")
    assert order(store, 1) == [0]
    store.create_sweep(sweep_of(sweep_from(100, 5)))
    taken = order(store, 6)  # the place of the lost run gives the newcomer no advantage
    assert of_the_old(taken) == pytest.approx(3, abs=ONE_RUN)


def test_turns__retried_runs_queue_up_like_new_ones(store: Store) -> None:
    row = store.create_sweep(sweep_of(6))
    for claim in claim_runs(store, 6):
        store.fail(claim, Cause.CRASH, failure="SIGSEGV", reason="")
    finish_all(store)
    store.create_sweep(sweep_of(sweep_from(100, 30)))
    order(store, 10)
    store.retry_sweep(row.id)
    taken = order(store, 12)
    assert [number for number in taken if number < 100] == [0, 1, 2, 3, 4, 5]


# --- priorities ------------------------------------------------------------------------------------


def test_priority__the_smaller_is_sooner(store: Store) -> None:
    store.create_sweep(sweep_of(sweep_from(0, 2)), priority=1)
    store.create_sweep(sweep_of(sweep_from(10, 2)))
    store.create_sweep(sweep_of(sweep_from(20, 2)), priority=-1)
    assert order(store, 6) == [20, 21, 10, 11, 0, 1]


def test_priority__a_shared_run_has_that_of_the_most_urgent_sweep(store: Store) -> None:
    store.create_sweep(sweep_of(sweep_from(0, 3)), priority=5)
    urgent = store.create_sweep(sweep_of(sweep_from(2, 1)), priority=-5)
    assert priorities(store, 3) == [5, 5, -5]
    assert order(store, 1) == [2]
    store.cancel_sweep(urgent.id)
    assert priorities(store, 3) == [5, 5, 5]  # of the running one too


def priorities(store: Store, count: int) -> list[int]:
    return [store.run(run_id(number)).priority for number in range(count)]


def test_priority__can_be_changed(store: Store) -> None:
    mine = store.create_sweep(sweep_of(sweep_from(0, 3)))
    theirs = store.create_sweep(sweep_of(sweep_from(2, 3)))
    assert store.set_priority(mine.id, 10).priority == 10
    assert priorities(store, 5) == [10, 10, 0, 0, 0]
    store.set_priority(theirs.id, 20)
    assert priorities(store, 5) == [10, 10, 10, 20, 20]
    assert store.events(theirs.id)[-1].body == {"priority": 20}


def test_priority__of_a_sweep_that_has_ended_stays(store: Store) -> None:
    row = store.create_sweep(sweep_of(1))
    finish_all(store)
    with pytest.raises(Conflict, match="ended"):
        store.set_priority(row.id, 1)


def test_priority__a_joined_run_never_becomes_less_urgent(store: Store) -> None:
    store.create_sweep(sweep_of(2), priority=-5)
    store.create_sweep(sweep_of(3), priority=5)
    assert priorities(store, 3) == [-5, -5, 5]


def test_priority__of_sweeps_that_wait_no_longer_does_not_count(store: Store) -> None:
    first = store.create_sweep(sweep_of(1), priority=-5)
    [claim] = claim_runs(store, 1)
    store.fail(claim, Cause.CRASH, failure="SIGSEGV", reason="")
    finish_all(store)
    assert store.sweep(first.id).is_terminal
    store.create_sweep(sweep_of(1), priority=5)
    assert priorities(store, 1) == [5]


def test_priority__a_long_urgent_sweep_does_not_spoil_the_order_of_the_others(
    store: Store,
) -> None:
    store.create_sweep(sweep_of(sweep_from(0, 50)))
    store.create_sweep(sweep_of(sweep_from(100, 40)), priority=-1)
    order(store, 40)
    store.create_sweep(sweep_of(sweep_from(200, 50)))
    taken = order(store, 10)
    assert of_the_old(taken) == pytest.approx(5, abs=ONE_RUN)


def test_priority__a_sweep_that_is_moved_keeps_its_place_among_its_new_neighbours(
    store: Store,
) -> None:
    old = store.create_sweep(sweep_of(sweep_from(0, 50)), priority=3)
    store.create_sweep(sweep_of(sweep_from(100, 100)))
    order(store, 30)  # the lane of the others has come far, that of the old sweep stands
    store.set_priority(old.id, 0)
    taken = order(store, 10)
    assert of_the_old(taken) == pytest.approx(5, abs=ONE_RUN)


# --- pause -----------------------------------------------------------------------------------------


def test_pause__no_run_begins_and_what_runs_is_finished_and_published(store: Store) -> None:
    store.create_sweep(sweep_of(1))
    store.create_sweep(sweep_of(sweep_from(10, 2)))
    [claim] = claim_runs(store, 1)
    since = store.pause().paused
    assert since is not None
    assert store.pause().paused == since  # pausing twice changes nothing
    assert store.claim(9, TERM) == ()
    assert store.finish(claim, result())
    assert [one.kind for one in store.claim(9, TERM)] == [Kind.PUBLISH]
    assert store.queue().states[State.QUEUED] == 2


def test_resume__runs_begin_again(store: Store) -> None:
    heard: list[None] = []
    store.create_sweep(sweep_of(2))
    store.pause()
    store.on_order(lambda: heard.append(None))
    assert store.resume().paused is None
    assert heard
    assert store.resume().paused is None
    claims: list[Claim] = claim_runs(store, 2)
    assert len(claims) == 2
    assert [event.kind for event in store.all_events()][1:3] == ["paused", "resumed"]
