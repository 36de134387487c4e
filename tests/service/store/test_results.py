"""A result is never lost: it is computed again for a verdict, or for files, and stays until there is another."""

import pytest

from service.records.jobs import Cause, Claim, Keep, Kind, State, SweepState
from service.store import Store
from tests.service.support.fakes import run_id, stored, sweep_of
from tests.service.support.rows import TERM, claim_runs, finish_all, result

STATE, FILM = stored("state.npz", "runs/state.npz"), stored("film.npz", "runs/film.npz")


def names(store: Store) -> list[str]:
    return [file.name for file in store.run_files(run_id(0))]


def verdict_of_two(store: Store) -> tuple[str, str]:
    """Two sweeps that have the same verdict, both published."""
    ids = [store.create_sweep(sweep_of(1), owner=owner).id for owner in ("ann", "bob")]
    finish_all(store, succeeded=False)
    return ids[0], ids[1]


def finished(store: Store, *files: object, keep: Keep = Keep.NUMBERS) -> str:
    """A sweep of one run that has succeeded, published; its id."""
    row = store.create_sweep(sweep_of(1), keep=keep)
    [claim] = claim_runs(store, 1)
    store.finish(claim, result(*files))  # type: ignore[arg-type]
    finish_all(store)
    return row.id


def test_requeue__says_where_the_job_went(store: Store) -> None:
    row = store.create_sweep(sweep_of(2))
    one, other = claim_runs(store, 2)
    assert store.requeue(one, Cause.LOST, reason="") is State.QUEUED
    assert store.requeue(one, Cause.LOST, reason="late") is None
    store.cancel_sweep(row.id)
    assert store.requeue(other, Cause.LOST, reason="stopped") is State.CANCELLED


# --- verdicts --------------------------------------------------------------------------------------


def test_verdict__that_is_tried_again_stays_until_there_is_another(store: Store) -> None:
    [_, bob] = verdict_of_two(store)
    before = store.run(run_id(0))
    assert store.retry_sweep(bob, verdicts=True).counts["queued"] == 1
    run = store.run(run_id(0))
    assert (run.path, run.summary, run.cause) == (before.path, before.summary, Cause.VERDICT)
    assert names(store) == ["result.json"]
    [claim] = claim_runs(store, 1)
    assert store.finish(claim, result(STATE))
    assert (store.run(run_id(0)).state, store.run(run_id(0)).cause) == (State.SUCCEEDED, None)


def test_verdict__is_there_again_when_the_second_try_is_cancelled(store: Store) -> None:
    [ann, bob] = verdict_of_two(store)
    store.retry_sweep(bob, verdicts=True)
    store.cancel_sweep(bob)
    seen = store.sweep(ann)
    assert (seen.state, seen.counts["failed"]) == (SweepState.SUCCEEDED, 1)
    run = store.run(run_id(0))
    assert (run.state, run.cause, run.path) == (State.FAILED, Cause.VERDICT, "runs/result.json")
    assert store.claim(9, TERM) == ()


def test_verdict__is_there_again_when_the_second_try_is_stopped(store: Store) -> None:
    [_, bob] = verdict_of_two(store)
    store.retry_sweep(bob, verdicts=True)
    [claim] = claim_runs(store, 1)
    store.cancel_sweep(bob)
    assert store.requeue(claim, Cause.LOST, reason="stopped")
    assert (store.run(run_id(0)).state, store.run(run_id(0)).cause) == (State.FAILED, Cause.VERDICT)


@pytest.mark.parametrize("cause", [Cause.ERROR, Cause.CRASH])
def test_verdict__is_there_again_when_the_second_try_has_an_accident(
    store: Store, cause: Cause
) -> None:
    [_, bob] = verdict_of_two(store)
    store.retry_sweep(bob, verdicts=True)
    [claim] = claim_runs(store, 1)
    log = stored("log.txt", "runs/other/log.txt")
    assert store.fail(claim, cause, failure="OSError", reason="no", files=[log])
    run = store.run(run_id(0))
    assert (run.state, run.cause, run.failure) == (State.FAILED, Cause.VERDICT, "UnphysicalState")
    assert names(store) == ["result.json"]
    assert store.events(bob)[-1].body["reason"] == "no"


# --- files that were not kept ------------------------------------------------------------------------


def test_film__of_a_finished_run_that_has_none_is_made(store: Store) -> None:
    ann = finished(store, STATE)
    row = store.create_sweep(sweep_of(1), keep=Keep.FILM)
    assert (row.new, row.state) == (1, SweepState.QUEUED)
    assert store.sweep(ann).state is SweepState.SUCCEEDED
    [claim] = claim_runs(store, 1)
    assert claim.keep is Keep.FILM
    assert store.finish(claim, result(STATE, FILM))
    assert names(store) == ["film.npz", "result.json", "state.npz"]
    finish_all(store)
    assert store.create_sweep(sweep_of(1), keep=Keep.FILM).new == 0


def test_film__that_cannot_be_made_costs_nobody_the_result(store: Store) -> None:
    ann = finished(store, STATE)
    row = store.create_sweep(sweep_of(1), keep=Keep.FILM)
    [claim] = claim_runs(store, 1)
    assert store.fail(claim, Cause.TIME_LIMIT, failure="TimeLimit", reason="too long")
    assert store.run(run_id(0)).state is State.SUCCEEDED
    assert store.sweep(ann).counts["succeeded"] == 1
    finish_all(store)
    assert store.sweep(row.id).counts["succeeded"] == 1
    store.retry_sweep(row.id)
    assert claim_runs(store, 1)[0].keep is Keep.FILM


def test_film__that_is_no_longer_wanted_is_not_made(store: Store) -> None:
    finished(store, STATE)
    row = store.create_sweep(sweep_of(1), keep=Keep.FILM)
    store.cancel_sweep(row.id)
    assert store.run(run_id(0)).state is State.SUCCEEDED
    assert names(store) == ["result.json", "state.npz"]


def test_film__asked_for_while_the_run_is_under_way_is_made(store: Store) -> None:
    store.create_sweep(sweep_of(1))
    [claim] = claim_runs(store, 1)
    row = store.create_sweep(sweep_of(1), keep=Keep.FILM)
    assert store.finish(claim, result(STATE))
    assert store.run(run_id(0)).path is not None
    [again] = store.claim(9, TERM)
    assert (again.kind, again.keep) == (Kind.RUN, Keep.FILM)
    assert store.finish(again, result(STATE, FILM))
    finish_all(store)
    assert store.sweep(row.id).state is SweepState.SUCCEEDED


def test_film__asked_for_while_the_run_is_under_way_is_made_after_a_change_of_leader(
    store: Store,
) -> None:
    store.create_sweep(sweep_of(1))
    claim_runs(store, 1)
    store.create_sweep(sweep_of(1), keep=Keep.FILM)
    epoch = store.begin_epoch("another")
    [claim] = store.claimed()
    adopted = store.adopt(claim, epoch)
    assert adopted is not None
    assert store.finish(adopted, result(STATE))
    [again] = store.claim(9, epoch)
    assert (again.kind, again.keep) == (Kind.RUN, Keep.FILM)


def test_film__that_was_made_is_not_made_again_after_a_change_of_leader(store: Store) -> None:
    store.create_sweep(sweep_of(1), keep=Keep.FILM)
    claim_runs(store, 1)
    epoch = store.begin_epoch("another")
    [claim] = store.claimed()
    adopted = store.adopt(claim, epoch)
    assert adopted is not None
    assert store.finish(adopted, result(STATE, FILM))
    assert store.run(run_id(0)).state is State.SUCCEEDED


def test_state__that_is_still_there_is_kept_for_who_asks_now(store: Store) -> None:
    finished(store, STATE)
    row = store.create_sweep(sweep_of(1), keep=Keep.FINAL)
    assert row.new == 0
    assert store.discardable(9) == ()


def test_state__that_was_dropped_is_made_again(store: Store) -> None:
    finished(store, STATE)
    assert store.drop(store.discardable(9)) == ((run_id(0), STATE),)
    assert store.create_sweep(sweep_of(1), keep=Keep.FINAL).new == 1


def test_verdict__has_no_files_that_it_could_lack(store: Store) -> None:
    store.create_sweep(sweep_of(1), keep=Keep.NUMBERS)
    finish_all(store, succeeded=False)
    assert store.create_sweep(sweep_of(1), keep=Keep.FILM).new == 0


# --- publications of others --------------------------------------------------------------------------


def both_failed(store: Store) -> str:
    """A sweep whose publication is queued, because its two runs had accidents."""
    row = store.create_sweep(sweep_of(2), owner="ann")
    for claim in claim_runs(store, 2):
        store.fail(claim, Cause.ERROR, failure="OSError", reason="no")
    assert store.sweep(row.id).state is SweepState.PUBLISHING
    return row.id


def test_publication__waits_again_for_runs_that_another_sweep_queued(store: Store) -> None:
    ann = both_failed(store)
    store.create_sweep(sweep_of(2), owner="bob")
    claims: list[Claim] = claim_runs(store, 2)
    for claim in claims:
        store.finish(claim, result(STATE))
    assert {claim.kind for claim in store.claim(9, TERM)} == {Kind.PUBLISH}
    assert [one.state for one in store.question(ann)[1]] == [State.SUCCEEDED] * 2


def test_publication__that_was_lost_waits_again_too(store: Store) -> None:
    ann = both_failed(store)
    [publication] = store.claim(1, TERM)
    store.create_sweep(sweep_of(2), owner="bob")
    assert store.requeue(publication, Cause.LOST, reason="gone")
    claim_runs(store, 2)
    assert store.sweep(ann).state is SweepState.RUNNING
