"""Cancelled, retried, replaced and deleted sweeps; runs that other sweeps wait for go on."""

import pytest

from service.records.jobs import RESULT, Cause, Conflict, NotFound, State, Stored, Submission, SweepState
from service.store import Store
from tests.service.support.fakes import run_id, stored, sweep_of
from tests.service.support.rows import TERM, finish_all, lease_runs, result, statements


def test_cancel__ends_queued_runs_and_stops_running_ones(store: Store) -> None:
    sweep = store.create_sweep(Submission(sweep_of(3))).id
    [lease] = lease_runs(store, 1)
    status = store.cancel_sweep(sweep)
    assert (status.state, status.counts["cancelled"]) == (SweepState.CANCELLED, 3)
    assert store.cancel_sweep(sweep) == status
    assert [held.state for held in store.leases()] == [State.CANCELLING]
    assert store.requeue(lease, Cause.LOST, reason="stopped") is State.CANCELLED
    assert store.lease(9, TERM) == ()


def test_cancel__leaves_shared_runs_to_the_other_sweep(store: Store) -> None:
    mine, theirs = (store.create_sweep(Submission(sweep_of(2))).id for _ in range(2))
    [lease] = lease_runs(store, 1)
    store.cancel_sweep(mine)
    assert store.run(lease.id).state is State.RUNNING
    assert store.sweep(theirs).counts["queued"] == 1
    assert store.finish(lease, result())
    finish_all(store)
    assert store.sweep(mine).counts["cancelled"] == 2
    assert store.sweep(theirs).state is SweepState.SUCCEEDED


def test_cancel__publishes_what_was_computed(store: Store) -> None:
    sweep = store.create_sweep(Submission(sweep_of(4))).id
    done, running = lease_runs(store, 2)
    store.finish(done, result())
    store.record_progress([(running, 0.5, 3.0, {})])
    status = store.cancel_sweep(sweep)
    assert status.state is SweepState.CANCELLING
    assert status.progress == pytest.approx(0.25)
    assert store.requeue(running, Cause.LOST, reason="stopped")
    finish_all(store)
    status = store.sweep(sweep)
    assert (status.state, status.eta_seconds) == (SweepState.CANCELLED, 0.0)
    assert status.progress == pytest.approx(0.25)
    assert store.artifacts(sweep)
    assert store.retry_sweep(sweep).progress == pytest.approx(0.25)
    finish_all(store)
    assert store.sweep(sweep).progress == 1.0
    assert store.cancel_sweep(sweep).state is SweepState.SUCCEEDED  # nothing is left to cancel


def test_stopped_run__is_queued_again_for_a_sweep_that_came_meanwhile(store: Store) -> None:
    sweep = store.create_sweep(Submission(sweep_of(1))).id
    [lease] = lease_runs(store, 1)
    store.cancel_sweep(sweep)
    again = store.create_sweep(Submission(sweep_of(1))).id
    assert store.requeue(lease, Cause.LOST, reason="stopped") is State.QUEUED
    finish_all(store)
    assert store.sweep(again).state is SweepState.SUCCEEDED


def test_cancel__is_one_statement_for_each_table(store: Store) -> None:
    shared = store.create_sweep(Submission(sweep_of(2), priority=5)).id
    mine = store.create_sweep(Submission(sweep_of(4), priority=-5)).id
    [done, running] = lease_runs(store, 2)
    store.finish(done, result())
    with statements(store) as sent:
        store.cancel_sweep(mine)
    for table in ("points", "jobs", "sweeps"):
        assert len([text for text in sent if text.startswith(f"UPDATE {table} ")]) == 1
    assert (store.run(running.id).state, store.run(running.id).priority) == (State.RUNNING, 5)
    assert store.sweep(shared).counts["running"] == 1


# --- retry -----------------------------------------------------------------------------------------


def test_retry__queues_accidents_and_cancelled_runs_and_on_request_verdicts(store: Store) -> None:
    sweep = store.create_sweep(Submission(sweep_of(3))).id
    crashed, verdict, _ = lease_runs(store, 3)
    log = stored("log.txt")
    store.fail(crashed, Cause.CRASH, failure="SIGSEGV", reason="died", files=[log])
    assert store.run_files(crashed.id) == (log,)
    store.finish(verdict, result(succeeded=False))
    store.cancel_sweep(sweep)
    counts = store.retry_sweep(sweep).counts
    assert (counts["queued"], counts["failed"], counts["cancelling"]) == (1, 1, 1)
    run = store.run(crashed.id)
    assert (run.crashes, run.cause, run.reason) == (0, None, None)
    assert store.run_files(crashed.id) == ()
    assert store.retry_sweep(sweep, verdicts=True).counts["queued"] == 2


def test_retry__publishes_again_and_keeps_the_earlier_files_until_then(store: Store) -> None:
    sweep = store.create_sweep(Submission(sweep_of(1))).id
    finish_all(store)
    assert store.retry_sweep(sweep).state is SweepState.PUBLISHING
    [publication] = store.lease(1, TERM)
    with pytest.raises(Conflict):
        store.retry_sweep(sweep)
    log = stored("log.txt", "log.txt")
    store.fail(publication, Cause.ERROR, failure="OSError", reason="disk full", files=[log])
    assert [file.name for file in store.artifacts(sweep)] == ["cube.nc", "log.txt"]
    store.retry_sweep(sweep)
    [publication] = store.lease(1, TERM)
    assert store.publish(publication, [stored("report.html", "report.html")], seconds=1.0)
    assert [file.name for file in store.artifacts(sweep)] == ["report.html"]


# --- replaced results ------------------------------------------------------------------------------

NEW = Stored(RESULT, "runs/result-1.json", 3, "11" * 32)
SUMMARY = {"measurements": {"hole_diameter": {"value": 2.0}}}


def computed(store: Store, runs: int) -> str:
    """A sweep of computed runs, published."""
    sweep = store.create_sweep(Submission(sweep_of(runs))).id
    finish_all(store)
    return sweep


def test_replaced_result__publishes_the_sweeps_that_use_it_again(store: Store) -> None:
    both, other = computed(store, 2), computed(store, 1)
    waiting = store.create_sweep(Submission(sweep_of(3))).id
    assert store.replace_result(run_id(1), "99" * 32, NEW, SUMMARY) == ()  # replaced before
    assert store.run(run_id(1)).path == stored().path
    assert store.replace_result(run_id(1), stored().sha256, NEW, SUMMARY) == (both,)
    run = store.run(run_id(1))
    assert (run.path, run.size, run.sha256, run.summary) == (NEW.path, 3, NEW.sha256, SUMMARY)
    assert store.run_file(run_id(1), RESULT) == NEW
    states = [store.sweep(sweep).state for sweep in (both, other, waiting)]
    assert states == [SweepState.PUBLISHING, SweepState.SUCCEEDED, SweepState.RUNNING]
    assert [event.kind for event in store.events(both)].count("outdated") == 1


def test_publication__of_an_earlier_result_no_longer_counts(store: Store) -> None:
    sweep = computed(store, 1)
    store.retry_sweep(sweep)
    [stale] = store.lease(9, TERM)
    assert store.replace_result(run_id(0), stored().sha256, NEW, SUMMARY) == (sweep,)
    assert not store.publish(stale, [stored("cube.nc", "cube.nc")], seconds=1.0)
    assert [lease.sweep_id for lease in store.lease(9, TERM)] == [sweep]


# --- delete ----------------------------------------------------------------------------------------


def test_delete__takes_only_sweeps_that_have_ended(store: Store) -> None:
    sweep = store.create_sweep(Submission(sweep_of(1))).id
    with pytest.raises(Conflict):
        store.delete_sweep(sweep)
    finish_all(store)
    store.delete_sweep(sweep)
    assert store.run(run_id(0)).state is State.SUCCEEDED
    assert store.deleted_sweeps([sweep, run_id(77)]) == {sweep}


@pytest.mark.parametrize("method", ["sweep", "cancel_sweep", "retry_sweep", "delete_sweep", "run", "run_files"])
def test_unknown_id__is_not_found(store: Store, method: str) -> None:
    with pytest.raises(NotFound):
        getattr(store, method)(run_id(77))
