"""Results that were read again, in the rows: all at once, fenced, and other sweeps follow."""

from dataclasses import replace

import pytest

from service.jobs import (
    ANSWER,
    STATE,
    Cause,
    Claim,
    Conflict,
    Keep,
    Kind,
    State,
    Stored,
    SweepState,
)
from service.rereads import Reread, Rereads
from service.store import Store
from tests.service.by_hand import EPOCH, finish_all, result, statements
from tests.service.doubles import run_id, runs_of, stored, sweep_of

NEW = Stored(ANSWER, "runs/result-1.json", 3, "11" * 32)
CUBE = [stored("cube.nc", "cube.nc")]


def computed(store: Store, *, runs: int = 2, name: str = "asked") -> str:
    """A sweep whose runs were computed with their final states."""
    id = store.create_sweep(sweep_of(runs, name=name)).id
    while claims := store.claim(100, EPOCH):
        for claim in claims:
            if claim.kind is Kind.RUN:
                assert store.finish(claim, result(stored(STATE, f"{claim.id}/state.npz")))
            else:
                assert store.publish(claim, CUBE, seconds=1.0)
    return id


def reading(store: Store, id: str, *, runs: int = 2) -> Claim:
    """The claim of a publication that is to read again."""
    store.remeasure_sweep(id, runs=runs)
    [claim] = store.claim(10, EPOCH)
    assert claim.spec == {"remeasure": True}
    return claim


def reread(number: int, *, was: str = "00" * 32) -> Reread:
    return Reread(run_id(number), was, NEW, {"measurements": {"hole_diameter": {"value": 2.0}}})


def published(store: Store, claim: Claim, *rereads: Reread) -> bool:
    return store.publish(claim, CUBE, seconds=1.0, rereads=Rereads(rereads))


def test_results__are_replaced_with_the_publication(store: Store) -> None:
    id = computed(store)
    claim = reading(store, id)
    assert store.sweep(id).state is SweepState.PUBLISHING
    assert published(store, claim, reread(0))
    run, other = store.run(run_id(0)), store.run(run_id(1))
    assert (run.path, run.size, run.sha256) == (NEW.path, NEW.size, NEW.sha256)
    assert run.summary == {"measurements": {"hole_diameter": {"value": 2.0}}}
    assert store.run_file(run_id(0), ANSWER) == NEW
    assert (other.path, store.run_file(run_id(1), ANSWER)) == (stored().path, stored())
    assert store.sweep(id).state is SweepState.SUCCEEDED


def test_results__of_an_attempt_that_no_longer_counts_change_nothing(store: Store) -> None:
    id = computed(store)
    claim = reading(store, id)
    assert store.requeue(claim, Cause.LOST, reason="away")
    assert not published(store, claim, reread(0))
    assert store.run(run_id(0)).path == stored().path
    [again] = store.claim(10, EPOCH)
    assert again.spec == claim.spec  # the order is not forgotten


def test_result__that_is_another_by_now_stays(store: Store) -> None:
    id = computed(store)
    assert published(store, reading(store, id), reread(0, was="99" * 32))
    assert store.run(run_id(0)).path == stored().path
    assert store.run_file(run_id(0), ANSWER) == stored()


def test_next_publication__reads_nothing_again(store: Store) -> None:
    id = computed(store)
    assert published(store, reading(store, id), reread(0))
    store.retry_sweep(id)
    [claim] = store.claim(10, EPOCH)
    assert not claim.spec


@pytest.mark.parametrize("claimed", [False, True], ids=["published", "being published"])
def test_other_sweeps__that_use_the_runs_are_published_again(store: Store, claimed: bool) -> None:
    id = computed(store)
    using, apart = computed(store, runs=1, name="using"), ""
    apart = store.create_sweep(sweep_of(runs_of("fine", first=7), name="apart")).id
    finish_all(store)
    claim = reading(store, id)
    if claimed:
        store.retry_sweep(using)
        [stale] = store.claim(10, EPOCH)
    assert published(store, claim, reread(0))
    assert store.sweep(using).state is SweepState.PUBLISHING
    assert store.sweep(apart).state is SweepState.SUCCEEDED
    if claimed:
        assert not store.publish(stale, CUBE, seconds=1.0)
    [again] = store.claim(10, EPOCH)
    assert (again.sweep_id, again.spec) == (using, {})
    assert [event.kind for event in store.events(using)].count("outdated") == 1


def test_other_sweep__that_reads_by_itself_goes_on(store: Store) -> None:
    one, other = computed(store), computed(store, runs=1, name="other")
    first, second = reading(store, one), reading(store, other)
    assert published(store, first, reread(0))
    assert published(store, second, reread(0))
    assert store.run(run_id(0)).path == NEW.path
    assert {store.sweep(id).state for id in (one, other)} == {
        SweepState.SUCCEEDED,
        SweepState.PUBLISHING,
    }


def test_order__waits_for_what_is_under_way(store: Store) -> None:
    id = store.create_sweep(sweep_of(1)).id
    with pytest.raises(Conflict, match="queued"):
        store.remeasure_sweep(id, runs=1)
    [run] = store.claim(1, EPOCH)
    store.finish(run, result())
    store.claim(1, EPOCH)
    with pytest.raises(Conflict, match="publishing"):
        store.remeasure_sweep(id, runs=1)


def test_order__given_again_changes_nothing(store: Store) -> None:
    id = computed(store)
    claim = reading(store, id)
    store.remeasure_sweep(id, runs=2)
    assert published(store, claim, reread(0))
    assert [event.kind for event in store.events(id)].count("remeasuring") == 1


def test_cancelled_sweep__with_results_can_be_read_again(store: Store) -> None:
    id = store.create_sweep(sweep_of(2)).id
    [first] = store.claim(1, EPOCH)
    store.finish(first, result())
    store.cancel_sweep(id)
    finish_all(store)
    assert store.sweep(id).state is SweepState.CANCELLED
    assert published(store, reading(store, id), reread(0))
    assert store.sweep(id).state is SweepState.CANCELLED


def test_publications__can_be_claimed_alone(store: Store) -> None:
    id = computed(store)
    store.create_sweep(sweep_of(runs_of("fine", first=9), name="more"))
    store.remeasure_sweep(id, runs=2)
    claims = store.claim(10, EPOCH, publications_only=True)
    assert [claim.kind for claim in claims] == [Kind.PUBLISH]


def test_measured_runs__tell_what_was_kept(store: Store) -> None:
    id = store.create_sweep(sweep_of(runs_of("fine", "fine", "fine")), keep=Keep.FINAL).id
    first, second, _ = store.claim(3, EPOCH)
    store.finish(first, result(stored(STATE, "s.npz")))
    store.finish(second, result())
    with statements(store) as sent:
        runs = store.measured_runs(id)
    assert [run.state for run in runs] == [State.SUCCEEDED, State.SUCCEEDED, State.RUNNING]
    assert [run.kept for run in runs] == [stored(STATE, "s.npz"), None, None]
    assert runs[0].summary == {"numbers": {"steps": 7.0}}
    assert len([one for one in sent if one.startswith("SELECT")]) == 2


def test_publication__of_many_rereads_asks_a_bounded_number_of_statements(store: Store) -> None:
    counts = []
    for number in (2, 40):
        id = computed(store, runs=number, name=f"of {number}")
        claim = reading(store, id, runs=number)
        news = [replace(reread(0), run_id=run_id(place)) for place in range(number)]
        with statements(store) as sent:
            assert published(store, claim, *news)
        counts.append(len(sent))
        finish_all(store)
    assert counts[1] <= counts[0] + 4
