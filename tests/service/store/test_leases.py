"""Leases: fencing, terms of leadership, progress, budgets, publications."""

import pytest

from service.records.jobs import Cause, Kind, Submission, SweepState
from service.store import Store
from tests.service.support.fakes import runs_of, stored, sweep_of
from tests.service.support.rows import TERM, lease_runs, result

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
