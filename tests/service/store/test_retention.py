"""Retention: files that sweeps keep, results that stay until they are replaced, garbage."""

from datetime import UTC, datetime

import pytest

from service.records.jobs import Cause, Keep, LastAttempt, NotFound, State, Stored, Submission, SweepState
from service.store import Store
from tests.service.support.fakes import run_id, stored, sweep_of
from tests.service.support.rows import TERM, finish_all, lease_runs, result

STATE, FILM = stored("state.npz", "runs/state.npz"), stored("film.npz", "runs/film.npz")
RUN = run_id(0)
LATER = datetime(9999, 1, 1, tzinfo=UTC)


def submitted(store: Store, keep: Keep) -> str:
    """A new sweep of the run."""
    return store.create_sweep(Submission(sweep_of(1), keep=keep)).id


def finished(store: Store, *files: Stored, keep: Keep) -> str:
    """A published sweep of the run, which left these files."""
    sweep = submitted(store, keep)
    [lease] = lease_runs(store, 1)
    assert store.finish(lease, result(*files))
    finish_all(store)
    return sweep


def names(store: Store) -> list[str]:
    return [file.name for file in store.run_files(RUN)]


# --- garbage ---------------------------------------------------------------------------------------


def test_discardable__are_files_that_no_sweep_keeps(store: Store) -> None:
    finished(store, STATE, FILM, keep=Keep.NUMBERS)
    assert store.discardable(10) == ((RUN, FILM), (RUN, STATE))
    assert store.discardable(1) == ((RUN, FILM),)
    assert [len(store.discardable(10, shard)) for shard in ("00", "01")] == [2, 0]
    final = submitted(store, Keep.FINAL)
    assert store.discardable(10) == ((RUN, FILM),)
    film = submitted(store, Keep.FILM)
    assert store.discardable(10) == ()
    finish_all(store)
    for sweep in (final, film):
        store.delete_sweep(sweep)
    assert len(store.discardable(10)) == 2


def test_discardable__are_no_files_of_a_run_that_may_write(store: Store) -> None:
    submitted(store, Keep.NUMBERS)
    [lease] = lease_runs(store, 1)
    store.fail(lease, Cause.CRASH, failure="SIGSEGV", reason="died", files=[STATE])
    assert len(store.discardable(10)) == 1
    submitted(store, Keep.NUMBERS)
    assert store.discardable(10) == ()


def test_drop__spares_files_that_a_sweep_demanded_meanwhile(store: Store) -> None:
    finished(store, STATE, FILM, keep=Keep.NUMBERS)
    discardable = store.discardable(10)
    submitted(store, Keep.FINAL)
    assert store.drop(discardable) == ((RUN, FILM),)
    assert names(store) == ["result.json", "state.npz"]


def test_forgotten_files__lower_the_retention_of_their_run(store: Store) -> None:
    finished(store, STATE, FILM, keep=Keep.FILM)
    for name, keep in (("film.npz", Keep.FINAL), ("state.npz", Keep.NUMBERS)):
        store.forget_files(RUN, [name])
        assert store.run(RUN).keep is keep
    assert names(store) == ["result.json"]


def test_files__are_listed_page_by_page_and_between_ids(store: Store) -> None:
    store.create_sweep(Submission(sweep_of(3)))
    finish_all(store)
    listed: list[tuple[str, Stored]] = []
    after = ("", "")
    while page := store.files(after=after, limit=2):
        listed += page
        after = (page[-1][0], page[-1][1].name)
    assert len(listed) == len(set(listed)) == 4  # three results and a cube
    between = store.files_between(run_id(1), run_id(2))
    assert [job for job, _ in between] == [run_id(1), run_id(2)]


def test_last_attempts__are_those_of_known_jobs(store: Store) -> None:
    store.create_sweep(Submission(sweep_of(2)))
    [lease] = lease_runs(store, 1)
    assert store.last_attempts(run_id(number) for number in range(2000)) == {
        run_id(0): LastAttempt(1, lease.token, State.RUNNING),
        run_id(1): LastAttempt(0, None, State.QUEUED),
    }


def test_forget_runs__takes_those_of_deleted_sweeps(store: Store) -> None:
    first, second = finished(store, keep=Keep.FINAL), submitted(store, Keep.FINAL)
    finish_all(store)
    store.delete_sweep(first)
    assert store.forget_runs(LATER, 9) == 0
    before = datetime.now(UTC)
    store.delete_sweep(second)
    assert store.forget_runs(before, 9) == 0
    assert store.forget_runs(LATER, 9) == 1
    with pytest.raises(NotFound):
        store.run(RUN)
    assert store.files() == ()
    assert store.forgotten_runs([RUN, run_id(1)]) == {RUN}
    assert store.create_sweep(Submission(sweep_of(1))).new == 1


# --- results that stay -----------------------------------------------------------------------------


@pytest.fixture
def retried_verdict(store: Store) -> str:
    """A sweep whose verdict is queued again."""
    sweep = store.create_sweep(Submission(sweep_of(1))).id
    finish_all(store, succeeded=False)
    assert store.retry_sweep(sweep, verdicts=True).counts["queued"] == 1
    run = store.run(RUN)
    assert (run.path, run.cause) == ("runs/result.json", Cause.VERDICT)
    return sweep


def test_verdict__stays_until_it_is_replaced(store: Store, retried_verdict: str) -> None:
    assert names(store) == ["result.json"]
    [lease] = lease_runs(store, 1)
    assert store.finish(lease, result(STATE))
    assert (store.run(RUN).state, store.run(RUN).cause) == (State.SUCCEEDED, None)


@pytest.mark.parametrize("end", ["cancelled", "stopped", "failed"])
def test_verdict__comes_back_when_the_retry_ends_without_a_result(store: Store, retried_verdict: str, end: str) -> None:
    leases = lease_runs(store, 0 if end == "cancelled" else 1)
    if end == "failed":
        assert store.fail(leases[0], Cause.ERROR, failure="OSError", reason="no", files=[STATE])
    else:
        store.cancel_sweep(retried_verdict)
    if end == "stopped":
        assert store.requeue(leases[0], Cause.LOST, reason="stopped") is State.FAILED
    run = store.run(RUN)
    assert (run.state, run.cause, run.failure) == (State.FAILED, Cause.VERDICT, "UnphysicalState")
    assert names(store) == ["result.json"]


def test_missing_film__is_computed_for_the_sweep_that_demands_it(store: Store) -> None:
    earlier = finished(store, STATE, keep=Keep.NUMBERS)
    status = store.create_sweep(Submission(sweep_of(1), keep=Keep.FILM))
    assert (status.new, status.state) == (1, SweepState.QUEUED)
    assert store.sweep(earlier).state is SweepState.SUCCEEDED
    [lease] = lease_runs(store, 1)
    assert lease.keep is Keep.FILM
    assert store.finish(lease, result(STATE, FILM))
    finish_all(store)
    assert store.create_sweep(Submission(sweep_of(1), keep=Keep.FILM)).new == 0


def test_film__that_cannot_be_computed_leaves_the_result(store: Store) -> None:
    finished(store, STATE, keep=Keep.NUMBERS)
    sweep = submitted(store, Keep.FILM)
    [lease] = lease_runs(store, 1)
    assert store.fail(lease, Cause.TIME_LIMIT, failure="TimeLimit", reason="too long")
    assert store.run(RUN).state is State.SUCCEEDED
    finish_all(store)
    assert store.sweep(sweep).counts["succeeded"] == 1
    store.retry_sweep(sweep)
    assert lease_runs(store, 1)[0].keep is Keep.FILM
    store.cancel_sweep(sweep)
    assert names(store) == ["result.json", "state.npz"]


@pytest.mark.parametrize("is_adopted", [False, True])
def test_film__demanded_while_the_run_is_under_way_is_computed_afterwards(store: Store, is_adopted: bool) -> None:
    submitted(store, Keep.FINAL)
    [lease] = lease_runs(store, 1)
    submitted(store, Keep.FILM)
    term = TERM
    if is_adopted:
        term = store.begin_term("another")
        adopted = store.adopt(store.leases()[0], term)
        assert adopted is not None
        lease = adopted
    assert store.finish(lease, result(STATE))
    [again] = store.lease(9, term)
    assert (again.id, again.keep) == (RUN, Keep.FILM)
    assert store.finish(again, result(STATE, FILM))
    assert store.run(RUN).state is State.SUCCEEDED


def test_state__is_kept_while_it_is_there_and_computed_again_once_dropped(store: Store) -> None:
    finished(store, STATE, keep=Keep.NUMBERS)
    kept = store.create_sweep(Submission(sweep_of(1), keep=Keep.FINAL))
    assert (kept.new, store.discardable(9)) == (0, ())
    finish_all(store)
    store.delete_sweep(kept.id)
    assert store.drop(store.discardable(9)) == ((RUN, STATE),)
    assert store.create_sweep(Submission(sweep_of(1), keep=Keep.FINAL)).new == 1
