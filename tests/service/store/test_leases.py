"""Leases: fencing, terms of leadership, progress, budgets, publications."""

import pytest

from service.records.jobs import RESULT, Cause, Kind, NotFound, State, Submission, SweepState, crashes_before
from service.store import Store
from tests.service.support.fakes import run_id, runs_of, stored, sweep_of
from tests.service.support.rows import TERM, finish_all, lease_runs, result


def test_lease__passes_over_jobs_that_are_backed_off(store: Store) -> None:
    store.create_sweep(Submission(sweep_of(3)))
    leases = store.lease(2, TERM, backed_off=(run_id(0),))
    assert [lease.id for lease in leases] == [run_id(1), run_id(2)]
    assert [lease.id for lease in store.lease(2, TERM)] == [run_id(0)]


def test_ended_attempt__counts_once(store: Store) -> None:
    store.create_sweep(Submission(sweep_of(1)))
    [lease] = lease_runs(store, 1)
    assert store.finish(lease, result())
    assert not store.finish(lease, result(succeeded=False))
    assert store.requeue(lease, Cause.LOST, reason="late") is None
    assert not store.fail(lease, Cause.CRASH, failure="SIGKILL", reason="late")
    assert store.run(lease.id).state is State.SUCCEEDED


def test_lost_attempt__is_fenced_by_its_successor(store: Store) -> None:
    store.create_sweep(Submission(sweep_of(1)))
    [old] = lease_runs(store, 1)
    assert store.requeue(old, Cause.LOST, reason="worker lost") is State.QUEUED
    [new] = store.lease(1, TERM + 1)
    assert not store.finish(old, result())
    assert (new.attempt, new.term) == (old.attempt + 1, TERM + 1)
    assert store.finish(new, result())


# --- terms -----------------------------------------------------------------------------------------


def test_term__ends_when_the_next_begins(store: Store) -> None:
    store.create_sweep(Submission(sweep_of(2)))
    old, young = store.begin_term("one"), store.begin_term("two")
    assert store.lease(1, old) == ()
    assert len(store.lease(1, young)) == 1
    assert store.queue().term == young > old


def test_adopted_attempt__belongs_to_the_next_term(store: Store) -> None:
    sweep = store.create_sweep(Submission(sweep_of(3))).id
    ended, held, stopped = store.lease(3, store.begin_term("one"))
    store.finish(ended, result())
    middle, young = store.begin_term("two"), store.begin_term("three")
    assert store.adopt(ended, young) is None
    assert store.adopt(held, middle) is None
    adopted = store.adopt(held, young)
    assert adopted is not None
    assert (adopted.term, adopted.attempt, adopted.key) == (young, held.attempt, held.key)
    assert not store.finish(held, result())
    assert store.finish(adopted, result())
    store.cancel_sweep(sweep)
    adopted = store.adopt(stopped, young)
    assert adopted is not None
    assert adopted.state is State.CANCELLING


def test_blocked_reason__is_that_of_the_youngest_term(store: Store) -> None:
    old, young = store.begin_term("one"), store.begin_term("two")
    store.set_blocked_reason("the scheduler is away", young)
    store.set_blocked_reason(None, old)
    assert store.queue().blocked_reason == "the scheduler is away"
    store.set_blocked_reason(None, young)
    assert store.queue().blocked_reason is None


# --- progress and budgets --------------------------------------------------------------------------


def test_progress__reaches_runs_and_sweep(store: Store) -> None:
    sweep = store.create_sweep(Submission(sweep_of(2))).id
    leases = lease_runs(store, 2)
    store.record_progress([(leases[0], 0.5, 3.0, {"step": 9})])
    run = store.run(leases[0].id)
    assert (run.fraction, run.progress) == (0.5, {"step": 9})
    status = store.sweep(sweep)
    assert status.progress == pytest.approx(0.25)
    # One and a half core seconds left at 6 s each, two side by side.
    assert status.eta_seconds == pytest.approx(1.5 * 6.0 / 2)


def test_progress__of_attempts_that_no_longer_count_is_ignored(store: Store) -> None:
    store.create_sweep(Submission(sweep_of(3)))
    leases = lease_runs(store, 3)
    store.requeue(leases[1], Cause.LOST, reason="")
    store.record_progress([(lease, 0.5, 3.0, {"step": 9}) for lease in leases])
    store.record_checkpoints([(lease, 400) for lease in leases])
    runs = [store.run(lease.id) for lease in leases]
    assert [run.fraction for run in runs] == [0.5, None, 0.5]
    assert [run.checkpoint for run in runs] == [400, None, 400]
    store.requeue(leases[0], Cause.LOST, reason="")
    assert store.run(leases[0].id).checkpoint == 400  # for the next attempt
    store.finish(leases[2], result())
    assert store.run(leases[2].id).checkpoint is None


def test_crashes__are_counted_at_the_same_checkpoint(store: Store) -> None:
    store.create_sweep(Submission(sweep_of(1)))
    counted = []
    for step in (None, None, 100, 100, 50, 200, None):
        [lease] = lease_runs(store, 1)
        counted.append(crashes_before(lease, step))
        assert store.requeue(lease, Cause.CRASH, reason="", crash_step=step)
    assert counted == [0, 1, 0, 1, 2, 0, 1]
    [lease] = lease_runs(store, 1)
    assert store.requeue(lease, Cause.LOST, reason="")  # a loss is not charged
    [lease] = lease_runs(store, 1)
    assert (lease.crashes, lease.crash_step) == (2, 200)


def test_causes__are_counted(store: Store) -> None:
    store.create_sweep(Submission(sweep_of(4)))
    lost, crashed, verdict, fine = lease_runs(store, 4)
    store.requeue(lost, Cause.LOST, reason="")
    store.fail(crashed, Cause.CRASH, failure="SIGSEGV", reason="")
    store.finish(verdict, result(succeeded=False))
    store.finish(fine, result())
    counted = {cause: number for cause, number in store.attempts_by_cause().items() if number}
    assert counted == {Cause.LOST: 1, Cause.CRASH: 1, Cause.VERDICT: 1}


# --- results ---------------------------------------------------------------------------------------


def test_result__is_in_the_row_of_its_run(store: Store) -> None:
    store.create_sweep(Submission(sweep_of(2)))
    verdict, crashed = lease_runs(store, 2)
    store.finish(verdict, result(stored("state.npz", "runs/state.npz"), succeeded=False))
    run = store.run(verdict.id)
    assert (run.state, run.cause, run.failure) == (State.FAILED, Cause.VERDICT, "UnphysicalState")
    assert (run.path, run.size, run.sha256) == (stored().path, stored().size, stored().sha256)
    assert run.summary == {"numbers": {"steps": 7.0}}
    assert [file.name for file in store.run_files(verdict.id)] == [RESULT, "state.npz"]
    assert store.run_file(verdict.id, "state.npz").path == "runs/state.npz"
    with pytest.raises(NotFound, match=r"film\.npz"):
        store.run_file(verdict.id, "film.npz")
    log = stored("log.txt", "runs/log.txt")
    store.fail(crashed, Cause.CRASH, failure="SIGSEGV", reason="died", files=[log])
    assert store.run_files(crashed.id) == (log,)
    assert store.run(crashed.id).path is None


# --- publications ----------------------------------------------------------------------------------


def test_publication__waits_for_the_last_run_and_comes_before_others(store: Store) -> None:
    sweep = store.create_sweep(Submission(sweep_of(6))).id
    leases = lease_runs(store, 6)
    for place in (5, 0, 3, 4):
        assert store.finish(leases[place], result())
    store.fail(leases[1], Cause.ERROR, failure="RuntimeError", reason="no")
    store.create_sweep(Submission(sweep_of(runs_of("fine", first=10)), priority=-100))
    assert [lease.kind for lease in store.lease(1, TERM)] == [Kind.RUN]
    assert store.finish(leases[2], result())
    assert store.sweep(sweep).state is SweepState.PUBLISHING
    store.create_sweep(Submission(sweep_of(runs_of("fine", first=20)), priority=-100))
    [publication] = store.lease(1, TERM)
    assert publication.sweep_id == sweep
    assert store.publish(publication, [stored("cube.nc", "cube.nc")], seconds=1.0)
    status = store.sweep(sweep)
    assert (status.state, status.counts["failed"]) == (SweepState.SUCCEEDED, 1)


def test_publication__waits_again_for_runs_that_another_sweep_queued(store: Store) -> None:
    first = store.create_sweep(Submission(sweep_of(2))).id
    for lease in lease_runs(store, 2):
        store.fail(lease, Cause.ERROR, failure="OSError", reason="no")
    assert store.sweep(first).state is SweepState.PUBLISHING
    [publication] = store.lease(1, TERM)
    store.create_sweep(Submission(sweep_of(1)))  # queues the first run, while that is under way
    assert store.requeue(publication, Cause.LOST, reason="gone")
    store.create_sweep(Submission(sweep_of(2)))
    assert store.sweep(first).counts["queued"] == 2
    finish_all(store)
    assert [point.state for point in store.publication_inputs(first)[1]] == [State.SUCCEEDED] * 2


def test_publication__fails_its_sweep(store: Store) -> None:
    sweep = store.create_sweep(Submission(sweep_of(1))).id
    [lease] = lease_runs(store, 1)
    store.finish(lease, result())
    [publication] = store.lease(1, TERM)
    store.fail(publication, Cause.ERROR, failure="OSError", reason="disk full")
    status = store.sweep(sweep)
    assert (status.state, status.reason) == (SweepState.FAILED, "disk full")


def test_publication_inputs__are_the_document_and_the_end_of_every_point(store: Store) -> None:
    sweep = store.create_sweep(Submission(sweep_of(3))).id
    good, bad, _ = lease_runs(store, 3)
    store.finish(good, result())
    store.fail(bad, Cause.CRASH, failure="SIGSEGV", reason="died")
    store.cancel_sweep(sweep)
    document, points = store.publication_inputs(sweep)
    assert document["name"] == "asked"
    assert [(point.state, point.reason) for point in points] == [
        (State.SUCCEEDED, None),
        (State.FAILED, "died"),
        (State.CANCELLED, None),
    ]
