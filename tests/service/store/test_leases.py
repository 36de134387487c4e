"""Leases: fencing, terms of leadership, progress, budgets, publications."""

import pytest

from service.queue.retry import decide
from service.records.jobs import RESULT, Cause, Kind, NotFound, State, Submission, SweepState
from service.store import Store
from tests.service.support.fakes import run_id, runs_of, stored, sweep_of
from tests.service.support.rows import TERM, finish_all, lease_runs, result


def test_lease__passes_over_jobs_that_are_backed_off(store: Store) -> None:
    store.sweeps.create(Submission(sweep_of(3)))
    leases = store.leases.take(2, TERM, backed_off=(run_id(0),))
    assert [lease.id for lease in leases] == [run_id(1), run_id(2)]
    assert [lease.id for lease in store.leases.take(2, TERM)] == [run_id(0)]


def test_ended_attempt__counts_once(store: Store) -> None:
    store.sweeps.create(Submission(sweep_of(1)))
    [lease] = lease_runs(store, 1)
    assert store.leases.finish(lease, result())
    assert not store.leases.finish(lease, result(succeeded=False))
    assert store.leases.requeue(lease, Cause.LOST, reason="late") is None
    assert not store.leases.fail(lease, Cause.CRASH, failure="SIGKILL", reason="late")
    assert store.runs.get(lease.id).state is State.SUCCEEDED


def test_lost_attempt__is_fenced_by_its_successor(store: Store) -> None:
    store.sweeps.create(Submission(sweep_of(1)))
    [old] = lease_runs(store, 1)
    assert store.leases.requeue(old, Cause.LOST, reason="worker lost") is State.QUEUED
    [new] = store.leases.take(1, TERM + 1)
    assert not store.leases.finish(old, result())
    assert (new.attempt, new.term) == (old.attempt + 1, TERM + 1)
    assert store.leases.finish(new, result())


# --- terms -----------------------------------------------------------------------------------------


def test_term__ends_when_the_next_begins(store: Store) -> None:
    store.sweeps.create(Submission(sweep_of(2)))
    old, young = store.terms.begin("one"), store.terms.begin("two")
    assert store.leases.take(1, old) == ()
    assert len(store.leases.take(1, young)) == 1
    assert store.queue.status().term == young > old


def test_adopted_attempt__belongs_to_the_next_term(store: Store) -> None:
    sweep = store.sweeps.create(Submission(sweep_of(3))).id
    ended, held, stopped = store.leases.take(3, store.terms.begin("one"))
    store.leases.finish(ended, result())
    middle, young = store.terms.begin("two"), store.terms.begin("three")
    assert store.leases.adopt(ended, young) is None
    assert store.leases.adopt(held, middle) is None
    adopted = store.leases.adopt(held, young)
    assert adopted is not None
    assert (adopted.term, adopted.attempt, adopted.key) == (young, held.attempt, held.key)
    assert not store.leases.finish(held, result())
    assert store.leases.finish(adopted, result())
    store.sweeps.cancel(sweep)
    adopted = store.leases.adopt(stopped, young)
    assert adopted is not None
    assert adopted.state is State.CANCELLING


def test_blocked_reason__is_that_of_the_youngest_term(store: Store) -> None:
    old, young = store.terms.begin("one"), store.terms.begin("two")
    store.queue.set_blocked_reason("the scheduler is away", young)
    store.queue.set_blocked_reason(None, old)
    assert store.queue.status().blocked_reason == "the scheduler is away"
    store.queue.set_blocked_reason(None, young)
    assert store.queue.status().blocked_reason is None


# --- progress and budgets --------------------------------------------------------------------------


def test_progress__reaches_runs_and_sweep(store: Store) -> None:
    sweep = store.sweeps.create(Submission(sweep_of(2))).id
    leases = lease_runs(store, 2)
    store.leases.record_progress([(leases[0], 0.5, 3.0, {"step": 9})])
    run = store.runs.get(leases[0].id)
    assert (run.fraction, run.progress) == (0.5, {"step": 9})
    status = store.sweeps.get(sweep)
    assert status.progress == pytest.approx(0.25)
    # One and a half core seconds left at 6 s each, two side by side.
    assert status.eta_seconds == pytest.approx(1.5 * 6.0 / 2)


def test_progress__of_attempts_that_no_longer_count_is_ignored(store: Store) -> None:
    store.sweeps.create(Submission(sweep_of(3)))
    leases = lease_runs(store, 3)
    store.leases.requeue(leases[1], Cause.LOST, reason="")
    store.leases.record_progress([(lease, 0.5, 3.0, {"step": 9}) for lease in leases])
    store.leases.record_checkpoints([(lease, 400) for lease in leases])
    runs = [store.runs.get(lease.id) for lease in leases]
    assert [run.fraction for run in runs] == [0.5, None, 0.5]
    assert [run.checkpoint for run in runs] == [400, None, 400]
    store.leases.requeue(leases[0], Cause.LOST, reason="")
    assert store.runs.get(leases[0].id).checkpoint == 400  # for the next attempt
    store.leases.finish(leases[2], result())
    assert store.runs.get(leases[2].id).checkpoint is None


def test_crashes__are_counted_at_the_same_checkpoint(store: Store) -> None:
    store.sweeps.create(Submission(sweep_of(1)))
    for step in (None, None, 100, 100, 50, 200, None):
        [lease] = lease_runs(store, 1)
        crashes = decide(lease, Cause.CRASH, step).crashes
        assert store.leases.requeue(lease, Cause.CRASH, reason="", crashes=crashes)
    [lease] = lease_runs(store, 1)
    assert store.leases.requeue(lease, Cause.LOST, reason="")  # a loss is not charged
    [lease] = lease_runs(store, 1)
    assert (lease.crashes, lease.crash_step) == (2, 200)


def test_causes__are_counted(store: Store) -> None:
    store.sweeps.create(Submission(sweep_of(4)))
    lost, crashed, verdict, fine = lease_runs(store, 4)
    store.leases.requeue(lost, Cause.LOST, reason="")
    store.leases.fail(crashed, Cause.CRASH, failure="SIGSEGV", reason="")
    store.leases.finish(verdict, result(succeeded=False))
    store.leases.finish(fine, result())
    counted = {cause: number for cause, number in store.queue.attempts_by_cause().items() if number}
    assert counted == {Cause.LOST: 1, Cause.CRASH: 1, Cause.VERDICT: 1}


# --- results ---------------------------------------------------------------------------------------


def test_result__is_in_the_row_of_its_run(store: Store) -> None:
    store.sweeps.create(Submission(sweep_of(2)))
    verdict, crashed = lease_runs(store, 2)
    store.leases.finish(verdict, result(stored("state.npz", "runs/state.npz"), succeeded=False))
    run = store.runs.get(verdict.id)
    assert (run.state, run.cause, run.failure) == (State.FAILED, Cause.VERDICT, "UnphysicalState")
    assert (run.path, run.size, run.sha256) == (stored().path, stored().size, stored().sha256)
    assert run.summary == {"numbers": {"steps": 7.0}}
    assert [file.name for file in store.runs.files(verdict.id)] == [RESULT, "state.npz"]
    assert store.runs.file(verdict.id, "state.npz").path == "runs/state.npz"
    with pytest.raises(NotFound, match=r"film\.npz"):
        store.runs.file(verdict.id, "film.npz")
    log = stored("log.txt", "runs/log.txt")
    store.leases.fail(crashed, Cause.CRASH, failure="SIGSEGV", reason="died", files=[log])
    assert store.runs.files(crashed.id) == (log,)
    assert store.runs.get(crashed.id).path is None


# --- publications ----------------------------------------------------------------------------------


def test_publication__waits_for_the_last_run_and_comes_before_others(store: Store) -> None:
    sweep = store.sweeps.create(Submission(sweep_of(6))).id
    leases = lease_runs(store, 6)
    for place in (5, 0, 3, 4):
        assert store.leases.finish(leases[place], result())
    store.leases.fail(leases[1], Cause.ERROR, failure="RuntimeError", reason="no")
    store.sweeps.create(Submission(sweep_of(runs_of("fine", first=10)), priority=-100))
    assert [lease.kind for lease in store.leases.take(1, TERM)] == [Kind.RUN]
    assert store.leases.finish(leases[2], result())
    assert store.sweeps.get(sweep).state is SweepState.PUBLISHING
    store.sweeps.create(Submission(sweep_of(runs_of("fine", first=20)), priority=-100))
    [publication] = store.leases.take(1, TERM)
    assert publication.sweep_id == sweep
    assert store.publications.publish(publication, [stored("cube.nc", "cube.nc")], seconds=1.0)
    status = store.sweeps.get(sweep)
    assert (status.state, status.counts["failed"]) == (SweepState.SUCCEEDED, 1)


def test_publication__waits_again_for_runs_that_another_sweep_queued(store: Store) -> None:
    first = store.sweeps.create(Submission(sweep_of(2))).id
    for lease in lease_runs(store, 2):
        store.leases.fail(lease, Cause.ERROR, failure="OSError", reason="no")
    assert store.sweeps.get(first).state is SweepState.PUBLISHING
    [publication] = store.leases.take(1, TERM)
    store.sweeps.create(Submission(sweep_of(1)))  # queues the first run, while that is under way
    assert store.leases.requeue(publication, Cause.LOST, reason="gone")
    store.sweeps.create(Submission(sweep_of(2)))
    assert store.sweeps.get(first).counts["queued"] == 2
    finish_all(store)
    assert [point.state for point in store.publications.inputs(first)[1]] == [State.SUCCEEDED] * 2


def test_publication__fails_its_sweep(store: Store) -> None:
    sweep = store.sweeps.create(Submission(sweep_of(1))).id
    [lease] = lease_runs(store, 1)
    store.leases.finish(lease, result())
    [publication] = store.leases.take(1, TERM)
    store.leases.fail(publication, Cause.ERROR, failure="OSError", reason="disk full")
    status = store.sweeps.get(sweep)
    assert (status.state, status.reason) == (SweepState.FAILED, "disk full")


def test_publication_inputs__are_the_document_and_the_end_of_every_point(store: Store) -> None:
    sweep = store.sweeps.create(Submission(sweep_of(3))).id
    good, bad, _ = lease_runs(store, 3)
    store.leases.finish(good, result())
    store.leases.fail(bad, Cause.CRASH, failure="SIGSEGV", reason="died")
    store.sweeps.cancel(sweep)
    document, points = store.publications.inputs(sweep)
    assert document["name"] == "asked"
    assert [(point.state, point.reason) for point in points] == [
        (State.SUCCEEDED, None),
        (State.FAILED, "died"),
        (State.CANCELLED, None),
    ]
