"""Leases: fencing, terms of leadership, progress, budgets, publications."""

import pytest

from service.records.jobs import Cause, Kind, State, Submission, SweepState
from service.store import Store
from tests.service.support.fakes import run_id, runs_of, stored, sweep_of
from tests.service.support.rows import TERM, lease_runs, result


def test_lease__passes_over_jobs_that_are_backed_off(store: Store) -> None:
    store.sweeps.create(Submission(sweep_of(3)))
    leases = store.leases.take(2, TERM, backed_off=(run_id(0),))
    assert [lease.id for lease in leases] == [run_id(1), run_id(2)]
    assert [lease.id for lease in store.leases.take(2, TERM)] == [run_id(0)]


# --- terms -----------------------------------------------------------------------------------------


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
    message = {"fraction": 0.5, "seconds": 3.0, "step": 9}
    store.leases.record_progress([(leases[0], message)])
    run = store.runs.get(leases[0].id)
    assert (run.fraction, run.progress) == (0.5, message)
    status = store.sweeps.get(sweep)
    assert status.progress == pytest.approx(0.25)
    # One and a half core seconds left at 6 s each, two side by side.
    assert status.eta_seconds == pytest.approx(1.5 * 6.0 / 2)


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
    assert store.leases.publish(publication, [stored("cube.nc", "cube.nc")], seconds=1.0)
    status = store.sweeps.get(sweep)
    assert (status.state, status.counts["failed"]) == (SweepState.SUCCEEDED, 1)


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
