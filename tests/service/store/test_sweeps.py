"""Sweeps: accepted, cancelled, retried, replaced and deleted; pages, points and tallies."""

from contextlib import closing
from dataclasses import replace
from operator import attrgetter
from typing import cast

import pytest

from service.records.jobs import (
    RESULT,
    Cause,
    Conflict,
    CrashCount,
    Keep,
    NotFound,
    State,
    Stored,
    Submission,
    SweepState,
)
from service.store import Store
from studies.quantities.findings import InvalidInput
from tests.service.support.fakes import run_id, runs_of, stored, sweep_of
from tests.service.support.rows import TERM, finish_all, lease_runs, result, statements
from tests.service.support.targets import FakeRun

KEY = ("2b6f", "11" * 32)

# --- submission ------------------------------------------------------------------------------------


def test_run__that_is_twice_in_a_sweep_is_computed_once(store: Store) -> None:
    status = store.sweeps.create(Submission(sweep_of([FakeRun(run_id(1)), FakeRun(run_id(1))])))
    assert (status.planned, status.new) == (2, 1)
    finish_all(store)
    assert store.sweeps.get(status.id).counts["succeeded"] == 2


def test_accident__is_computed_again_and_a_verdict_is_not(store: Store) -> None:
    store.sweeps.create(Submission(sweep_of(2)))
    crashed, verdict = lease_runs(store, 2)
    assert store.leases.fail(crashed, Cause.CRASH, failure="SIGSEGV", reason="died", crashes=CrashCount(1, 100))
    assert store.leases.finish(verdict, result(succeeded=False))
    status = store.sweeps.create(Submission(sweep_of(2)))
    assert (status.reused, status.new) == (1, 1)
    assert (status.counts["queued"], status.counts["failed"]) == (1, 1)
    [again] = lease_runs(store, 1)
    assert (again.crashes, again.crash_step) == (0, None)  # with a fresh budget


def test_failed_transaction__leaves_nothing(store: Store) -> None:
    """The digest cannot be stored, which shows when every other row is written."""
    broken = ("key", cast(str, object()))
    with pytest.raises(Exception, match=r"(?i)bind|adapt|support"):
        store.sweeps.create(Submission(sweep_of(3), idempotency=broken))
    assert store.sweeps.page().items == ()
    assert store.queue.status().states == {}


def test_digest__finds_the_same_sweep(store: Store) -> None:
    status = store.sweeps.create(Submission(sweep_of(2)))
    assert store.sweeps.find(sweep_of(2).digest) == status
    assert store.sweeps.find(sweep_of(3).digest) is None


def test_shared_run__keeps_the_most_that_a_sweep_demands(store: Store) -> None:
    for runs, keep in ((2, Keep.FINAL), (1, Keep.FILM), (2, Keep.NUMBERS)):
        store.sweeps.create(Submission(sweep_of(runs), keep=keep))
    assert [store.runs.get(run_id(number)).keep for number in (0, 1)] == [Keep.FILM, Keep.FINAL]


def test_same_key__is_the_same_sweep_for_each_owner(store: Store) -> None:
    status = store.sweeps.create(Submission(sweep_of(2), owner="ann", idempotency=KEY))
    finish_all(store)
    again = store.sweeps.create(Submission(sweep_of(2), owner="ann", idempotency=KEY))
    assert again == store.sweeps.get(status.id)
    other = store.sweeps.create(Submission(sweep_of(2), owner="bob", idempotency=KEY))
    assert other.id != status.id


# --- cancel ----------------------------------------------------------------------------------------


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


# --- queries ---------------------------------------------------------------------------------------


def test_sweeps__are_paged_youngest_first_and_filtered_by_state(store: Store) -> None:
    done = store.sweeps.create(Submission(sweep_of(1))).id
    finish_all(store)
    cancelled = store.sweeps.create(Submission(sweep_of(runs_of("fine", first=10)))).id
    store.sweeps.cancel(cancelled)
    queued = store.sweeps.create(Submission(sweep_of(runs_of("fine", first=20)))).id
    first = store.sweeps.page(limit=2)
    rest = store.sweeps.page(limit=2, cursor=first.next_cursor)
    ids = [status.id for page in (first, rest) for status in page.items]
    assert (ids, rest.next_cursor) == ([queued, cancelled, done], None)
    expected = {SweepState.SUCCEEDED: [done], SweepState.CANCELLED: [cancelled], SweepState.QUEUED: [queued]}
    for state in SweepState:
        of_state = [status.id for status in store.sweeps.page(state=state).items]
        assert of_state == expected.get(state, [])


def test_points__are_paged_in_the_order_of_the_sweep(store: Store) -> None:
    sweep = store.sweeps.create(Submission(sweep_of(5))).id
    first = store.sweeps.points(sweep, limit=3)
    rest = store.sweeps.points(sweep, limit=3, cursor=first.next_cursor)
    points = [*first.items, *rest.items]
    assert [point.index for point in points] == [(0,), (1,), (2,), (3,), (4,)]
    assert points[2].coordinates == {"speed": 2000.0}
    assert rest.next_cursor is None
    [lease] = lease_runs(store, 1)
    store.leases.fail(lease, Cause.CRASH, failure="SIGSEGV", reason="died")
    [point] = store.sweeps.points(sweep, state=State.FAILED).items
    assert (point.run.id, point.run.reason) == (lease.id, "died")


@pytest.mark.parametrize("cursor", ["", "x", "-1", "1; drop table", "9" * 30, "٣"])
def test_cursor__that_no_page_gave_is_refused(store: Store, cursor: str) -> None:
    sweep = store.sweeps.create(Submission(sweep_of(1))).id
    with pytest.raises(InvalidInput, match="cursor"):
        store.sweeps.page(cursor=cursor)
    with pytest.raises(InvalidInput, match="cursor"):
        store.sweeps.points(sweep, cursor=cursor)


# --- tallies ---------------------------------------------------------------------------------------


def counting(store: Store, id: str) -> int:
    """Number of statements that count points when a sweep is shown."""
    with statements(store) as sent:
        store.sweeps.get(id)
    return len([text for text in sent if "count(" in text.lower()])


def test_tally__counts_runs_that_lost_an_answer(store: Store) -> None:
    sweep = store.sweeps.create(Submission(sweep_of(2))).id
    first, second = lease_runs(store, 2)
    store.leases.finish(first, result())
    store.leases.finish(second, replace(result(), reason="lost_particles: no final_length"))
    status = store.sweeps.get(sweep)
    assert (status.counts["succeeded"], status.lost_answers) == (2, 1)
    assert status.tally == "2 succeeded (1 of them lost an answer)"


def test_tally__of_an_ended_sweep_is_read_once(store: Store) -> None:
    sweep = store.sweeps.create(Submission(sweep_of(2))).id
    assert (counting(store, sweep), counting(store, sweep)) == (1, 1)
    finish_all(store)
    assert (counting(store, sweep), counting(store, sweep)) == (1, 0)
    assert store.sweeps.get(sweep) == store.sweeps.page().items[0]
    assert store.sweeps.get(sweep).counts["succeeded"] == 2


def test_tally__is_read_again_when_another_sweep_queues_a_run(store: Store, database_url: str) -> None:
    sweep = store.sweeps.create(Submission(sweep_of(1), keep=Keep.NUMBERS)).id
    finish_all(store)
    with closing(Store.open(database_url)) as replica:
        services = (store, replica)
        assert [service.sweeps.get(sweep).counts["succeeded"] for service in services] == [1, 1]
        store.sweeps.create(Submission(sweep_of(1), keep=Keep.FILM))
        assert [service.sweeps.get(sweep).counts["queued"] for service in services] == [1, 1]
        finish_all(store)
        assert [service.sweeps.get(sweep).counts["succeeded"] for service in services] == [1, 1]
