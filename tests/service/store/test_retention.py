"""Retention: files that sweeps keep, results that stay until they are replaced, garbage."""

from datetime import UTC, datetime
from typing import Any

import pytest

from service.records.jobs import Cause, Keep, Scrub, State, Stored, Submission
from service.store import Store
from tests.service.support.fakes import run_id, runs_of, stored, sweep_of
from tests.service.support.rows import TERM, finish_all, lease_runs, result

STATE, FILM = stored("state.npz", "runs/state.npz"), stored("film.npz", "runs/film.npz")
RUN = run_id(0)
LATER = datetime(9999, 1, 1, tzinfo=UTC)


def submitted(store: Store, keep: Keep) -> str:
    """A new sweep of the run."""
    return store.sweeps.create(Submission(sweep_of(1), keep=keep)).id


def finished(store: Store, *files: Stored, keep: Keep) -> str:
    """A published sweep of the run, which left these files."""
    sweep = submitted(store, keep)
    [lease] = lease_runs(store, 1)
    assert store.leases.finish(lease, result(*files))
    finish_all(store)
    return sweep


def names(store: Store) -> list[str]:
    return [file.name for file in store.runs.files(RUN)]


def test_drop__spares_files_that_a_sweep_demanded_meanwhile(store: Store) -> None:
    finished(store, STATE, FILM, keep=Keep.NUMBERS)
    discardable = store.retention.discardable(10, "")
    submitted(store, Keep.FINAL)
    assert store.retention.drop(discardable) == ((RUN, FILM),)
    assert names(store) == ["result.json", "state.npz"]


ALONE = Stored("state.npz", "runs/alone.npz", 1000, "")
SHARED = Stored("state.npz", "runs/shared.npz", 100, "")
OF_EACH = 3  # bytes of each result and each cube


@pytest.fixture
def three(store: Store) -> list[str]:
    """Sweeps of anna, bert and anna: the first of a run of its own, the others of one that they share."""
    ids = []
    for owner, number, files in (("anna", 0, [ALONE]), ("bert", 1, [SHARED]), ("anna", 1, [])):
        submission = Submission(sweep_of(runs_of("fine", first=number)), owner=owner)
        ids.append(store.sweeps.create(submission).id)
        for file in files:
            assert store.leases.finish(lease_runs(store, 1)[0], result(file))
        finish_all(store)
    return ids


def expired(store: Store, **rule: Any) -> list[tuple[str, int]]:
    return [(id, sweep.size) for id, sweep in store.retention.expired(LATER, **rule).items()]


def test_expired__are_the_oldest_with_what_goes_with_them(store: Store, three: list[str]) -> None:
    sizes = [1000 + 2 * OF_EACH, OF_EACH, 100 + 2 * OF_EACH]
    assert expired(store) == [*zip(three, sizes, strict=True)]
    assert expired(store, to_size=sum(sizes)) == []
    assert expired(store, to_size=sum(sizes) - 1) == [(three[0], sizes[0])]
    assert len(expired(store, to_size=sizes[2])) == 2
    assert expired(store, owner="bert") == [(three[1], OF_EACH)]  # its run stays for anna
    assert store.retention.expired(datetime(2000, 1, 1, tzinfo=UTC)) == {}


def test_expired__are_neither_pinned_nor_under_way(store: Store, three: list[str]) -> None:
    store.sweeps.pin(three[1], pinned=True)
    assert expired(store) == [(three[0], 1000 + 2 * OF_EACH), (three[2], OF_EACH)]
    store.sweeps.create(Submission(sweep_of(runs_of("fine", first=9)), owner="anna"))
    assert len(expired(store, owner="anna")) == 2


def test_film__that_cannot_be_computed_leaves_the_result(store: Store) -> None:
    finished(store, STATE, keep=Keep.NUMBERS)
    sweep = submitted(store, Keep.FILM)
    [lease] = lease_runs(store, 1)
    assert store.leases.fail(lease, Cause.TIME_LIMIT, failure="TimeLimit", reason="too long")
    assert store.runs.get(RUN).state is State.SUCCEEDED
    finish_all(store)
    assert store.sweeps.get(sweep).counts["succeeded"] == 1
    store.sweeps.retry(sweep)
    assert lease_runs(store, 1)[0].keep is Keep.FILM
    store.sweeps.cancel(sweep)
    assert names(store) == ["result.json", "state.npz"]


@pytest.mark.parametrize("is_adopted", [False, True])
def test_film__demanded_while_the_run_is_under_way_is_computed_afterwards(store: Store, is_adopted: bool) -> None:
    submitted(store, Keep.FINAL)
    [lease] = lease_runs(store, 1)
    submitted(store, Keep.FILM)
    term = TERM
    if is_adopted:
        term = store.terms.begin("another")
        adopted = store.leases.adopt(store.leases.held()[0], term)
        assert adopted is not None
        lease = adopted
    assert store.leases.finish(lease, result(STATE))
    [again] = store.leases.take(9, term)
    assert (again.id, again.keep) == (RUN, Keep.FILM)
    assert store.leases.finish(again, result(STATE, FILM))
    assert store.runs.get(RUN).state is State.SUCCEEDED


def test_state__is_kept_while_it_is_there_and_computed_again_once_dropped(store: Store) -> None:
    finished(store, STATE, keep=Keep.NUMBERS)
    kept = store.sweeps.create(Submission(sweep_of(1), keep=Keep.FINAL))
    assert (kept.new, store.retention.discardable(9, "")) == (0, ())
    finish_all(store)
    store.sweeps.delete(kept.id)
    assert store.retention.drop(store.retention.discardable(9, "")) == ((RUN, STATE),)
    assert store.sweeps.create(Submission(sweep_of(1), keep=Keep.FINAL)).new == 1


@pytest.mark.parametrize("damaged", [STATE, stored()])
def test_mend__computes_a_run_again_for_the_sweeps_that_have_it(store: Store, damaged: Stored) -> None:
    sweep = finished(store, STATE, keep=Keep.FINAL)
    assert store.publications.mend(damaged, most=3)
    assert (store.runs.get(RUN).sha256 is None) is (damaged != STATE)  # the result stays, if it is whole
    assert store.publications.mend(damaged, most=3) is (damaged == STATE)  # under way, or forgotten
    assert store.leases.finish(lease_runs(store, 1)[0], result(FILM))
    finish_all(store)
    kinds = [event.kind for event in store.events.of_sweep(sweep)]
    assert (kinds.count("lost"), kinds.count("outdated"), kinds.count("published")) == (1, 1, 2)
    store.retention.note_scrub(Scrub(began=1.0, whole=[2.0, 3, 0]))
    assert store.retention.scrub() == Scrub(began=1.0, whole=[2.0, 3, 0])
