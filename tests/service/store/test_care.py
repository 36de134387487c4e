"""Which files count: retention by the sweeps that keep them, orphans, sweeps that were deleted."""

from datetime import UTC, datetime

import pytest

from service.records.jobs import Cause, Keep, LastAttempt, NotFound, State, Stored
from service.store import Store
from tests.service.support.fakes import run_id, stored, sweep_of
from tests.service.support.rows import claim_runs, finish_all, result

STATE, FILM = stored("state.npz", "runs/state.npz"), stored("film.npz", "runs/film.npz")


def finished(store: Store, *keeps: Keep) -> list[str]:
    """Sweeps of the same run, which has every file; returns their ids."""
    ids = [store.create_sweep(sweep_of(1), keep=keep).id for keep in keeps]
    [claim] = claim_runs(store, 1)
    store.finish(claim, result(STATE, FILM))
    finish_all(store)
    return ids


def test_discardable__what_no_sweep_keeps(store: Store) -> None:
    finished(store, Keep.NUMBERS)
    assert store.discardable(10) == ((run_id(0), FILM), (run_id(0), STATE))
    assert store.discardable(1) == ((run_id(0), FILM),)
    assert len(store.discardable(10, "00")) == 2
    assert store.discardable(10, "01") == ()


def test_discardable__nothing_that_one_of_them_keeps(store: Store) -> None:
    [_, final] = finished(store, Keep.NUMBERS, Keep.FINAL)
    assert store.discardable(10) == ((run_id(0), FILM),)
    film = store.create_sweep(sweep_of(1), keep=Keep.FILM)
    assert store.discardable(10) == ()
    finish_all(store)
    store.delete_sweep(film.id)
    store.delete_sweep(final)
    assert len(store.discardable(10)) == 2


def test_discardable__not_while_the_run_may_still_write(store: Store) -> None:
    store.create_sweep(sweep_of(1), keep=Keep.NUMBERS)
    [claim] = claim_runs(store, 1)
    store.fail(claim, Cause.CRASH, failure="SIGSEGV", reason="died", files=[STATE])
    assert len(store.discardable(10)) == 1
    store.create_sweep(sweep_of(1), keep=Keep.NUMBERS)
    assert store.discardable(10) == ()


def test_forget_files__they_are_no_longer_registered(store: Store) -> None:
    finished(store, Keep.NUMBERS)
    for id, file in store.discardable(10):
        store.forget_files(id, [file.name])
    assert store.discardable(10) == ()
    assert [file.name for file in store.run_files(run_id(0))] == ["result.json"]


def test_forget_files__a_run_keeps_what_is_left(store: Store) -> None:
    finished(store, Keep.FILM)
    store.forget_files(run_id(0), ["film.npz"])
    assert store.run(run_id(0)).keep is Keep.FINAL
    store.forget_files(run_id(0), ["state.npz"])
    assert store.run(run_id(0)).keep is Keep.NUMBERS


def test_drop__nothing_that_somebody_asked_for_meanwhile(store: Store) -> None:
    finished(store, Keep.NUMBERS)
    found = store.discardable(10)
    store.create_sweep(sweep_of(1, name="later"), keep=Keep.FINAL)
    assert store.drop(found) == ((run_id(0), FILM),)
    names = [file.name for file in store.run_files(run_id(0))]
    assert names == ["result.json", "state.npz"]


def test_files_between__those_of_neighbours(store: Store) -> None:
    store.create_sweep(sweep_of(4))
    finish_all(store)
    between = store.files_between(run_id(1), run_id(2))
    assert [job for job, _ in between] == [run_id(1), run_id(2)]


def test_files__every_one_page_by_page(store: Store) -> None:
    store.create_sweep(sweep_of(3))
    finish_all(store)
    seen: list[tuple[str, Stored]] = []
    after = ("", "")
    while page := store.files(after=after, limit=2):
        seen += page
        job, file = page[-1]
        after = (job, file.name)
    assert len(seen) == 4  # three results and a cube
    assert len({(job, file.name) for job, file in seen}) == 4


def test_known_attempts__the_last_of_each_job(store: Store) -> None:
    store.create_sweep(sweep_of(2))
    [claim] = claim_runs(store, 1)
    known = store.known_attempts(run_id(number) for number in range(2000))
    assert known == {
        run_id(0): LastAttempt(1, claim.token, State.RUNNING),
        run_id(1): LastAttempt(0, None, State.QUEUED),
    }


LATER = datetime(9999, 1, 1, tzinfo=UTC)


def test_forget_runs__that_no_sweep_has_any_more(store: Store) -> None:
    [first, second] = finished(store, Keep.FINAL, Keep.FINAL)
    store.delete_sweep(first)
    assert store.forget_runs(LATER, 9) == 0
    before = datetime.now(UTC)
    store.delete_sweep(second)
    assert store.forget_runs(before, 9) == 0
    assert store.forget_runs(LATER, 9) == 1
    with pytest.raises(NotFound):
        store.run(run_id(0))
    assert store.files() == ()
    assert store.forgotten_runs([run_id(0), run_id(1)]) == {run_id(0)}
    assert store.create_sweep(sweep_of(1)).new == 1


def test_forget_runs__not_one_that_was_asked_for_again(store: Store) -> None:
    [first] = finished(store, Keep.FINAL)
    store.delete_sweep(first)
    assert store.create_sweep(sweep_of(1)).new == 0
    assert store.forget_runs(LATER, 9) == 0


def test_forgotten__only_sweeps_that_were_deleted_here(store: Store) -> None:
    gone, kept = store.create_sweep(sweep_of(1)), store.create_sweep(sweep_of(1))
    finish_all(store)
    store.delete_sweep(gone.id)
    assert store.forgotten([gone.id, kept.id, run_id(77)]) == {gone.id}
