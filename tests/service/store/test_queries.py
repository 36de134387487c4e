"""Queries about events, runs and the queue as a whole."""

from service.records.jobs import Cause, JobTally, Kind, State, Submission
from service.store import Store
from tests.service.support.fakes import run_id, sweep_of
from tests.service.support.rows import finish_all, lease_runs, result


def test_events__of_a_sweep_of_a_run_and_of_everything(store: Store) -> None:
    assert store.events.last() == 0
    store.sweeps.create(Submission(sweep_of(1)))
    finish_all(store)
    sweep = store.sweeps.create(Submission(sweep_of(2))).id
    [lease] = lease_runs(store, 1)
    store.leases.requeue(lease, Cause.LOST, reason="worker lost")
    finish_all(store)
    events = store.events.of_sweep(sweep)
    assert [event.kind for event in events] == [
        *("accepted", "started", "requeued", "started", "succeeded", "started", "published")
    ]
    assert store.events.of_sweep(sweep, after=events[2].number) == events[3:]
    of_run = store.events.of_run(lease.id)
    assert [event.kind for event in of_run] == ["started", "requeued", "started", "succeeded"]
    assert of_run[1].body == {"attempt": 1, "cause": "lost", "reason": "worker lost"}
    everything = store.events.all()
    assert [event.number for event in everything] == sorted({one.number for one in everything})
    assert store.events.last() == everything[-1].number


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


def test_job_tally__is_by_kind_state_and_duration(store: Store) -> None:
    store.sweeps.create(Submission(sweep_of(3)))
    for lease in lease_runs(store, 2):
        store.leases.finish(lease, result())
    done = JobTally(Kind.RUN, State.SUCCEEDED, 2, 2, 4.0)
    queued = JobTally(Kind.RUN, State.QUEUED, None, 1, 0.0)
    waiting = JobTally(Kind.PUBLISH, State.WAITING, None, 1, 0.0)
    assert set(store.queue.tally((0.5, 1.0, 2.0))) == {done, queued, waiting}


def test_measured_rate__is_that_of_all_results_or_of_one_scenario(store: Store) -> None:
    assert store.runs.measured_rate() is None
    store.sweeps.create(Submission(sweep_of(1)))
    finish_all(store)
    scenario = store.runs.get(run_id(0)).scenario
    rates = [store.runs.measured_rate(of) for of in (None, scenario, "another")]
    assert rates == [2.0, 2.0, None]
