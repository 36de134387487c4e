"""Cancelled, retried, replaced and deleted sweeps; runs that other sweeps wait for go on."""

from operator import attrgetter

import pytest

from service.records.jobs import RESULT, Cause, Conflict, NotFound, State, Stored, Submission, SweepState
from service.store import Store
from tests.service.support.fakes import run_id, stored, sweep_of
from tests.service.support.rows import TERM, finish_all, lease_runs, result


def test_cancel__publishes_what_was_computed(store: Store) -> None:
    sweep = store.sweeps.create(Submission(sweep_of(4))).id
    done, running = lease_runs(store, 2)
    store.leases.finish(done, result())
    store.leases.record_progress([(running, {"fraction": 0.5, "seconds": 3.0})])
    status = store.sweeps.cancel(sweep)
    assert status.state is SweepState.CANCELLING
    assert status.progress == pytest.approx(0.25)
    assert store.leases.requeue(running, Cause.LOST, reason="stopped")
    finish_all(store)
    status = store.sweeps.get(sweep)
    assert (status.state, status.eta_seconds) == (SweepState.CANCELLED, 0.0)
    assert status.progress == pytest.approx(0.25)
    assert store.publications.files(sweep)
    assert store.sweeps.retry(sweep).progress == pytest.approx(0.25)
    finish_all(store)
    assert store.sweeps.get(sweep).progress == 1.0
    assert store.sweeps.cancel(sweep).state is SweepState.SUCCEEDED  # nothing is left to cancel


# --- retry -----------------------------------------------------------------------------------------


def test_retry__queues_accidents_and_cancelled_runs_and_on_request_verdicts(store: Store) -> None:
    sweep = store.sweeps.create(Submission(sweep_of(3))).id
    crashed, verdict, _ = lease_runs(store, 3)
    log = stored("log.txt")
    store.leases.fail(crashed, Cause.CRASH, failure="SIGSEGV", reason="died", files=[log])
    assert store.runs.files(crashed.id) == (log,)
    store.leases.finish(verdict, result(succeeded=False))
    store.sweeps.cancel(sweep)
    counts = store.sweeps.retry(sweep).counts
    assert (counts["queued"], counts["failed"], counts["cancelling"]) == (1, 1, 1)
    run = store.runs.get(crashed.id)
    assert (run.crashes, run.cause, run.reason) == (0, None, None)
    assert store.runs.files(crashed.id) == ()
    assert store.sweeps.retry(sweep, verdicts=True).counts["queued"] == 2


def test_retry__publishes_again_and_keeps_the_earlier_files_until_then(store: Store) -> None:
    sweep = store.sweeps.create(Submission(sweep_of(1))).id
    finish_all(store)
    assert store.sweeps.retry(sweep).state is SweepState.PUBLISHING
    [publication] = store.leases.take(1, TERM)
    with pytest.raises(Conflict):
        store.sweeps.retry(sweep)
    log = stored("log.txt", "log.txt")
    store.leases.fail(publication, Cause.ERROR, failure="OSError", reason="disk full", files=[log])
    assert [file.name for file in store.publications.files(sweep)] == ["cube.nc", "log.txt"]
    store.sweeps.retry(sweep)
    [publication] = store.leases.take(1, TERM)
    assert store.leases.publish(publication, [stored("report.html", "report.html")], seconds=1.0)
    assert [file.name for file in store.publications.files(sweep)] == ["report.html"]


# --- replaced results ------------------------------------------------------------------------------

NEW = Stored(RESULT, "runs/result-1.json", 3, "11" * 32)
SUMMARY = {"measurements": {"hole_diameter": {"value": 2.0}}}


def computed(store: Store, runs: int) -> str:
    """A sweep of computed runs, published."""
    sweep = store.sweeps.create(Submission(sweep_of(runs))).id
    finish_all(store)
    return sweep


def test_replaced_result__publishes_the_sweeps_that_use_it_again(store: Store) -> None:
    both, other = computed(store, 2), computed(store, 1)
    waiting = store.sweeps.create(Submission(sweep_of(3))).id
    assert store.runs.replace_result(run_id(1), "99" * 32, NEW, SUMMARY) == ()  # replaced before
    assert store.runs.get(run_id(1)).path == stored().path
    assert store.runs.replace_result(run_id(1), stored().sha256, NEW, SUMMARY) == (both,)
    run = store.runs.get(run_id(1))
    assert (run.path, run.size, run.sha256, run.summary) == (NEW.path, 3, NEW.sha256, SUMMARY)
    assert store.runs.file(run_id(1), RESULT) == NEW
    states = [store.sweeps.get(sweep).state for sweep in (both, other, waiting)]
    assert states == [SweepState.PUBLISHING, SweepState.SUCCEEDED, SweepState.RUNNING]
    assert [event.kind for event in store.events.of_sweep(both)].count("outdated") == 1


def test_publication__of_an_earlier_result_no_longer_counts(store: Store) -> None:
    sweep = computed(store, 1)
    store.sweeps.retry(sweep)
    [stale] = store.leases.take(9, TERM)
    assert store.runs.replace_result(run_id(0), stored().sha256, NEW, SUMMARY) == (sweep,)
    assert not store.leases.publish(stale, [stored("cube.nc", "cube.nc")], seconds=1.0)
    assert [lease.sweep_id for lease in store.leases.take(9, TERM)] == [sweep]


# --- delete ----------------------------------------------------------------------------------------


def test_delete__takes_only_sweeps_that_have_ended(store: Store) -> None:
    sweep = store.sweeps.create(Submission(sweep_of(1))).id
    with pytest.raises(Conflict):
        store.sweeps.delete(sweep)
    finish_all(store)
    store.sweeps.delete(sweep)
    assert store.runs.get(run_id(0)).state is State.SUCCEEDED
    assert store.retention.deleted_sweeps([sweep, run_id(77)]) == {sweep}


@pytest.mark.parametrize(
    "method", ["sweeps.get", "sweeps.cancel", "sweeps.retry", "sweeps.delete", "runs.get", "runs.files"]
)
def test_unknown_id__is_not_found(store: Store, method: str) -> None:
    with pytest.raises(NotFound):
        attrgetter(method)(store)(run_id(77))
