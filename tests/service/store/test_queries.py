"""Queries about events, runs and the queue as a whole."""

from service.records.jobs import Submission
from service.store import Store
from tests.service.support.fakes import sweep_of
from tests.service.support.rows import lease_runs

# --- runs and the queue ----------------------------------------------------------------------------


def test_runs_under_way__have_the_sweeps_that_wait_for_them(store: Store) -> None:
    mine = store.sweeps.create(Submission(sweep_of(2))).id
    theirs = store.sweeps.create(Submission(sweep_of(1))).id
    shared, own = lease_runs(store, 2)
    waiting = {run.id: set(sweeps) for run, sweeps in store.runs.under_way()}
    assert waiting == {shared.id: {mine, theirs}, own.id: {mine}}
    store.sweeps.cancel(theirs)
    waiting = {run.id: set(sweeps) for run, sweeps in store.runs.under_way()}
    assert waiting == {shared.id: {mine}, own.id: {mine}}
