"""The counts of a sweep that has ended are read once, and never old."""

from contextlib import closing

from service.records.jobs import Cause, Keep, SweepState
from service.store import Store
from tests.service.support.fakes import sweep_of
from tests.service.support.rows import claim_runs, finish_all, result, statements


def counting(store: Store, id: str) -> int:
    """How many statements count points when a sweep is shown."""
    with statements(store) as sent:
        store.sweep(id)
    return len([one for one in sent if "count(" in one.lower()])


def failed(store: Store) -> str:
    """A sweep of one run that had an accident, published; its id."""
    row = store.create_sweep(sweep_of(1))
    [claim] = claim_runs(store, 1)
    store.fail(claim, Cause.CRASH, failure="SIGSEGV", reason="died")
    finish_all(store)
    return row.id


def test_counts__of_a_sweep_that_has_ended_are_read_once(store: Store) -> None:
    row = store.create_sweep(sweep_of(2))
    assert (counting(store, row.id), counting(store, row.id)) == (1, 1)
    finish_all(store)
    assert (counting(store, row.id), counting(store, row.id)) == (1, 0)
    assert store.sweep(row.id) == store.sweeps().items[0]
    assert store.sweep(row.id).counts["succeeded"] == 2


def test_counts__are_read_again_when_another_sweep_revives_a_run(
    store: Store, database_url: str
) -> None:
    id = failed(store)
    with closing(Store.open(database_url)) as replica:
        assert (store.sweep(id).counts["failed"], replica.sweep(id).counts["failed"]) == (1, 1)
        store.create_sweep(sweep_of(1))
        assert (store.sweep(id).counts["queued"], replica.sweep(id).counts["queued"]) == (1, 1)
        finish_all(store)
        assert (store.sweep(id).counts["succeeded"], replica.sweep(id).counts["succeeded"]) == (
            1,
            1,
        )


def test_counts__are_read_again_when_a_sweep_takes_up_what_it_had_let_go(store: Store) -> None:
    mine = store.create_sweep(sweep_of(1))
    store.create_sweep(sweep_of(1))
    [claim] = claim_runs(store, 1)
    assert store.cancel_sweep(mine.id).state is SweepState.CANCELLED
    assert store.sweep(mine.id).counts["cancelled"] == 1
    store.retry_sweep(mine.id)
    assert store.sweep(mine.id).counts["running"] == 1
    store.finish(claim, result())
    assert store.sweep(mine.id).counts["succeeded"] == 1


def test_counts__of_a_film_that_is_made_are_those_of_now(store: Store) -> None:
    row = store.create_sweep(sweep_of(1), keep=Keep.NUMBERS)
    finish_all(store)
    assert store.sweep(row.id).counts["succeeded"] == 1
    store.create_sweep(sweep_of(1), keep=Keep.FILM)
    assert store.sweep(row.id).counts["queued"] == 1


def test_news__each_event_with_the_sweeps_that_have_its_run(store: Store) -> None:
    [a, b] = [store.create_sweep(sweep_of(count)).id for count in (1, 2)]
    begin = store.last_event()
    claim_runs(store, 2)
    told = {event.job_id: sweeps for event, sweeps in store.news(after=begin, limit=9)}
    assert sorted(told.values(), key=len) == [{b}, {a, b}]
    assert len(store.news(after=0, limit=3)) == 3
