"""Retention: files that sweeps keep, results that stay until they are replaced, garbage."""

from datetime import UTC, datetime

import pytest

from service.records.jobs import Cause, Keep, State, Stored, Submission
from service.store import Store
from tests.service.support.fakes import run_id, stored, sweep_of
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


# --- garbage ---------------------------------------------------------------------------------------


def test_drop__spares_files_that_a_sweep_demanded_meanwhile(store: Store) -> None:
    finished(store, STATE, FILM, keep=Keep.NUMBERS)
    discardable = store.retention.discardable(10)
    submitted(store, Keep.FINAL)
    assert store.retention.drop(discardable) == ((RUN, FILM),)
    assert names(store) == ["result.json", "state.npz"]


# --- results that stay -----------------------------------------------------------------------------


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
    assert (kept.new, store.retention.discardable(9)) == (0, ())
    finish_all(store)
    store.sweeps.delete(kept.id)
    assert store.retention.drop(store.retention.discardable(9)) == ((RUN, STATE),)
    assert store.sweeps.create(Submission(sweep_of(1), keep=Keep.FINAL)).new == 1
