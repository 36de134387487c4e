"""Sweeps and their runs: accepted, cancelled, retried, replaced, published; tallies and progress."""

from contextlib import closing
from dataclasses import replace
from pathlib import Path

import pytest
from pydantic import JsonValue

from service.records.jobs import (
    RESULT,
    AttemptProgress,
    Cause,
    Conflict,
    CrashCount,
    Keep,
    Kind,
    Stored,
    Submission,
    Summary,
    SweepState,
)
from service.records.logbook import Wanted
from service.store import Store
from tests.service.support.fakes import run_id, runs_of, stored, sweep_of
from tests.service.support.rows import TERM, finish_all, lease_runs, result, statements


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


def test_shared_run__keeps_the_most_that_a_sweep_demands(store: Store) -> None:
    for runs, keep in ((2, Keep.FINAL), (1, Keep.FILM), (2, Keep.NUMBERS)):
        store.sweeps.create(Submission(sweep_of(runs), keep=keep))
    assert [store.runs.get(run_id(number)).keep for number in (0, 1)] == [Keep.FILM, Keep.FINAL]


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
    event = store.events.of_sweep(sweep)[-1]
    assert (event.kind, event.body) == ("retried", {"runs": 1})
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
    store.leases.fail(publication, Cause.CRASH, failure="SIGSEGV", reason="died", crashes=CrashCount(3, 0))
    store.sweeps.retry(sweep)
    [publication] = store.leases.take(1, TERM)
    assert publication.crashes == 0  # a budget of its own
    assert store.leases.publish(publication, [stored("report.html", "report.html")], seconds=1.0)
    assert [file.name for file in store.publications.files(sweep)] == ["report.html"]


NEW = Stored(RESULT, "runs/result-1.json", 3, "11" * 32)
SUMMARY: Summary = {"measurements": {"hole_diameter": {"value": 2.0}}}


def computed(store: Store, runs: int) -> str:
    sweep = store.sweeps.create(Submission(sweep_of(runs))).id
    finish_all(store)
    return sweep


def test_replaced_result__publishes_the_sweeps_that_use_it_again(store: Store) -> None:
    both, other = computed(store, 2), computed(store, 1)
    waiting = store.sweeps.create(Submission(sweep_of(3))).id
    assert store.runs.replace_result(run_id(1), "99" * 32, NEW, SUMMARY) == ()  # replaced before
    assert store.runs.get(run_id(1)).sha256 == stored().sha256
    assert store.runs.replace_result(run_id(1), stored().sha256, NEW, SUMMARY) == (both,)
    run, published = store.runs.get(run_id(1)), store.publications.inputs(both, Path("/data"))[1]
    assert (run.sha256, run.summary) == (NEW.sha256, SUMMARY)
    assert (f"/data/{NEW.path}", NEW.sha256) in {(each["path"], each["sha256"]) for each in published}
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


@pytest.mark.parametrize("is_published", [True, False])
def test_first_result__publishes_the_sweeps_that_were_published_without_it_again(
    store: Store, is_published: bool
) -> None:
    earlier = store.sweeps.create(Submission(sweep_of(1))).id
    store.leases.fail(lease_runs(store, 1)[0], Cause.ERROR, failure="RuntimeError", reason="no")
    [publication] = store.leases.take(1, TERM)
    if is_published:
        store.leases.publish(publication, [stored("cube.nc", "cube.nc")], seconds=1.0)
    store.sweeps.create(Submission(sweep_of(1)))
    store.leases.finish(lease_runs(store, 1)[0], result())
    assert store.sweeps.get(earlier).state is SweepState.PUBLISHING
    assert not store.leases.publish(publication, [stored("cube.nc", "cube.nc")], seconds=1.0)


@pytest.mark.parametrize(
    ("text", "found"),
    [
        *(("my-alloy", True), ("titanium", True), ("6061", True), ("perforation ASKED", True)),
        *(("projectile", False), ("titanium copper", False), ("100%", False)),
    ],
)
def test_search__finds_a_sweep_by_its_scenario_and_its_materials_in_two_statements(
    store: Store, text: str, found: bool
) -> None:
    sweep = sweep_of(1)
    document: dict[str, JsonValue] = {
        "fixed": {"projectile": "my-alloy"},
        "axes": {"target": ["al-6061-t6", "ti-6al-4v"]},
    }
    store.sweeps.create(Submission(replace(sweep, document={**sweep.document, **document})))
    with statements(store) as sent:
        page = store.sweeps.logbook(Wanted(text=text))
    assert bool(page.entries) is found
    assert len([each for each in sent if not each.startswith("BEGIN")]) <= 2


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
    assert status.tally == "2 succeeded (1 of them lacks a value)"


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


def test_progress__reaches_runs_and_sweep(store: Store) -> None:
    sweep = store.sweeps.create(Submission(sweep_of(2))).id
    leases = lease_runs(store, 2)
    message: AttemptProgress = {"fraction": 0.5, "seconds": 3.0, "step": 9}
    store.leases.record_progress([(leases[0], message)])
    run = store.runs.get(leases[0].id)
    assert (run.fraction, run.progress) == (0.5, message)
    status = store.sweeps.get(sweep)
    assert status.progress == pytest.approx(0.25)
    # One and a half core seconds left at 6 s each, two side by side.
    assert status.eta_seconds == pytest.approx(1.5 * 6.0 / 2)


def test_publication__waits_for_the_last_run_and_comes_before_others(store: Store) -> None:
    sweep = store.sweeps.create(Submission(sweep_of(6))).id
    leases = lease_runs(store, 6)
    for place in (5, 0, 3, 4):
        assert store.leases.finish(leases[place], result())
    store.leases.fail(leases[1], Cause.ERROR, failure="RuntimeError", reason="no")
    store.sweeps.create(Submission(sweep_of(runs_of("fine", first=10)), priority=-100))
    assert [lease.kind for lease in store.leases.take(1, TERM)] == [Kind.RUN]
    assert store.leases.finish(leases[2], result())
    assert store.sweeps.cancel(sweep).state is SweepState.PUBLISHING  # nothing is left to cancel
    store.sweeps.create(Submission(sweep_of(runs_of("fine", first=20)), priority=-100))
    [publication] = store.leases.take(1, TERM)
    assert publication.sweep_id == sweep
    assert store.leases.publish(publication, [stored("cube.nc", "cube.nc")], seconds=1.0)
    status = store.sweeps.get(sweep)
    assert (status.state, status.counts["failed"]) == (SweepState.SUCCEEDED, 1)


def test_runs_under_way__have_the_sweeps_that_wait_for_them(store: Store) -> None:
    mine = store.sweeps.create(Submission(sweep_of(2))).id
    theirs = store.sweeps.create(Submission(sweep_of(1))).id
    shared, own = lease_runs(store, 2)
    waiting = {run.id: set(sweeps) for run, sweeps in store.runs.under_way()}
    assert waiting == {shared.id: {mine, theirs}, own.id: {mine}}
    store.sweeps.cancel(theirs)
    waiting = {run.id: set(sweeps) for run, sweeps in store.runs.under_way()}
    assert waiting == {shared.id: {mine}, own.id: {mine}}
