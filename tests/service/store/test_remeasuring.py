"""Another result of a run in the rows, and the sweeps that use it."""

import pytest

from service.records.jobs import RESULT, Kind, Stored, SweepState
from service.store import Store
from tests.service.support.fakes import run_id, stored, sweep_of
from tests.service.support.rows import TERM, finish_all, result

NEW = Stored(RESULT, "runs/result-1.json", 3, "11" * 32)
SUMMARY = {"measurements": {"hole_diameter": {"value": 2.0}}}


def computed(store: Store, runs: int, *, name: str = "asked") -> str:
    """A sweep whose runs were computed, and which was published."""
    id = store.create_sweep(sweep_of(runs, name=name)).id
    finish_all(store)
    return id


def replaced(store: Store, number: int, *, was: str = stored().sha256) -> tuple[str, ...]:
    return store.replace_result(run_id(number), was, NEW, SUMMARY)


def test_result__is_replaced_and_its_sweeps_are_published_again(store: Store) -> None:
    both, one = computed(store, 2), computed(store, 1, name="one")
    assert replaced(store, 1) == (both,)
    run = store.run(run_id(1))
    assert (run.path, run.size, run.sha256) == (NEW.path, NEW.size, NEW.sha256)
    assert (run.summary, store.run_file(run_id(1), RESULT)) == (SUMMARY, NEW)
    assert store.run_file(run_id(0), RESULT) == stored()
    assert store.sweep(both).state is SweepState.PUBLISHING
    assert store.sweep(one).state is SweepState.SUCCEEDED
    [claim] = store.claim(10, TERM)
    assert claim.sweep_id == both
    assert [event.kind for event in store.events(both)].count("outdated") == 1


def test_result__that_is_another_by_now_stays(store: Store) -> None:
    id = computed(store, 1)
    assert replaced(store, 0, was="99" * 32) == ()
    assert store.run(run_id(0)).path == stored().path
    assert store.run_file(run_id(0), RESULT) == stored()
    assert store.sweep(id).state is SweepState.SUCCEEDED


def test_publication__that_was_given_the_earlier_result_no_longer_counts(store: Store) -> None:
    id = computed(store, 1)
    store.retry_sweep(id)
    [stale] = store.claim(10, TERM)
    assert replaced(store, 0) == (id,)
    assert not store.publish(stale, [stored("cube.nc", "cube.nc")], seconds=1.0)
    [again] = store.claim(10, TERM)
    assert again.sweep_id == id


def test_publication__that_waits_for_other_runs_goes_on_waiting(store: Store) -> None:
    computed(store, 1)
    more = store.create_sweep(sweep_of(2, name="more")).id
    assert more not in replaced(store, 0)
    assert [claim.kind for claim in store.claim(10, TERM)].count(Kind.RUN) == 1
    assert store.sweep(more).state is SweepState.RUNNING


@pytest.mark.parametrize("number", [0, 1], ids=["computed", "given up"])
def test_cancelled_sweep__is_published_again_for_what_it_has_alone(
    store: Store, number: int
) -> None:
    cancelled = store.create_sweep(sweep_of(2)).id
    [first] = store.claim(1, TERM)
    assert store.finish(first, result())
    store.cancel_sweep(cancelled)
    whole = computed(store, 2, name="whole")
    marked = {cancelled, whole} if number == 0 else {whole}
    assert set(replaced(store, number)) == marked
