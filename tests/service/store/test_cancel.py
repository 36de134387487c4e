"""The store lets go: sweeps cancelled, tried again, deleted; runs that others wait for go on."""

import pytest
import sqlalchemy as sa

from service.records.jobs import Cause, Claim, Conflict, Kind, NotFound, State, SweepState
from service.store import Store
from service.store.tables import JOBS
from tests.service.support.fakes import run_id, runs_of, stored, sweep_of
from tests.service.support.rows import TERM, claim_runs, finish_all, result, statements


def test_cancel__queued_runs_end_and_running_ones_are_to_be_stopped(store: Store) -> None:
    row = store.create_sweep(sweep_of(3))
    [claim] = claim_runs(store, 1)
    seen = store.cancel_sweep(row.id)
    assert seen.state is SweepState.CANCELLED
    assert seen.counts["cancelled"] == 3
    assert store.run(claim.id).state is State.CANCELLING
    assert [one.state for one in store.claimed()] == [State.CANCELLING]
    assert store.requeue(claim, Cause.LOST, reason="stopped")
    assert store.run(claim.id).state is State.CANCELLED
    assert store.claim(9, TERM) == ()


def test_cancel__is_idempotent_and_changes_nothing_that_is_done(store: Store) -> None:
    row = store.create_sweep(sweep_of(2))
    assert store.cancel_sweep(row.id) == store.cancel_sweep(row.id)
    done = store.create_sweep(sweep_of(runs_of("fine", first=9)))
    finish_all(store)
    assert store.cancel_sweep(done.id).state is SweepState.SUCCEEDED


def test_cancel__a_shared_run_goes_on(store: Store) -> None:
    mine, theirs = store.create_sweep(sweep_of(2)), store.create_sweep(sweep_of(2))
    [claim] = claim_runs(store, 1)
    store.cancel_sweep(mine.id)
    assert store.run(claim.id).state is State.RUNNING
    assert store.sweep(theirs.id).counts["queued"] == 1
    finish_all_from(store, claim)
    assert store.sweep(mine.id).counts["cancelled"] == 2
    assert store.sweep(theirs.id).state is SweepState.SUCCEEDED


def finish_all_from(store: Store, claim: Claim) -> None:
    assert store.finish(claim, result())
    finish_all(store)


def test_cancel__what_was_computed_is_published(store: Store) -> None:
    row = store.create_sweep(sweep_of(3))
    [claim] = claim_runs(store, 1)
    store.finish(claim, result())
    assert store.cancel_sweep(row.id).state is SweepState.CANCELLING
    finish_all(store)
    assert store.sweep(row.id).state is SweepState.CANCELLED
    assert store.artifacts(row.id)


def test_cancel__progress_is_what_was_computed(store: Store) -> None:
    row = store.create_sweep(sweep_of(4))
    done, running = claim_runs(store, 2)
    store.finish(done, result())
    store.progress([(running, 0.5, 3.0, {})])
    assert store.cancel_sweep(row.id).progress == pytest.approx(0.25)
    assert store.requeue(running, Cause.LOST, reason="stopped")
    finish_all(store)
    seen = store.sweep(row.id)
    assert (seen.state, seen.eta_seconds) == (SweepState.CANCELLED, 0.0)
    assert seen.progress == pytest.approx(0.25)
    assert store.retry_sweep(row.id).progress == pytest.approx(0.25)
    finish_all(store)
    assert store.sweep(row.id).progress == 1.0


def test_cancel__a_result_that_comes_first_is_kept(store: Store) -> None:
    row = store.create_sweep(sweep_of(1))
    [claim] = claim_runs(store, 1)
    store.cancel_sweep(row.id)
    assert store.finish(claim, result())
    assert store.run(claim.id).state is State.SUCCEEDED


def test_cancel__a_run_that_somebody_wants_again_is_queued_when_it_has_stopped(
    store: Store,
) -> None:
    row = store.create_sweep(sweep_of(1))
    [claim] = claim_runs(store, 1)
    store.cancel_sweep(row.id)
    again = store.create_sweep(sweep_of(1))
    assert store.requeue(claim, Cause.LOST, reason="stopped")
    assert store.run(claim.id).state is State.QUEUED
    finish_all(store)
    assert store.sweep(again.id).state is SweepState.SUCCEEDED


def test_cancel__a_sweep_that_is_being_published_goes_on(store: Store) -> None:
    publishing = store.create_sweep(sweep_of(1))
    [claim] = claim_runs(store, 1)
    store.finish(claim, result(succeeded=False))
    [publication] = store.claim(1, TERM)
    # Another sweep asks for the same run again, so that it is unfinished once more.
    other = store.create_sweep(sweep_of(1))
    [second] = store.claim(1, TERM)
    store.publish(second, [stored("cube.nc")], seconds=1.0)
    store.retry_sweep(other.id, verdicts=True)
    assert store.cancel_sweep(publishing.id).state is SweepState.PUBLISHING
    assert store.publish(publication, [stored("cube.nc")], seconds=1.0)


def test_cancel__a_sweep_that_is_done_keeps_no_run_going(store: Store) -> None:
    done = store.create_sweep(sweep_of(1))
    [claim] = claim_runs(store, 1)
    store.fail(claim, Cause.CRASH, failure="SIGSEGV", reason="died")
    finish_all(store)
    assert store.sweep(done.id).is_terminal
    again = store.create_sweep(sweep_of(1))
    claim_runs(store, 1)
    store.cancel_sweep(again.id)
    assert [one.state for one in store.claimed()] == [State.CANCELLING]


def test_retry__accidents_and_cancelled_runs_but_no_verdict(store: Store) -> None:
    row = store.create_sweep(sweep_of(3))
    crashed, verdict, _ = claim_runs(store, 3)
    store.fail(crashed, Cause.CRASH, failure="SIGSEGV", reason="died")
    store.finish(verdict, result(succeeded=False))
    store.cancel_sweep(row.id)
    seen = store.retry_sweep(row.id)
    assert seen.state is SweepState.RUNNING
    assert (seen.counts["queued"], seen.counts["failed"], seen.counts["cancelling"]) == (1, 1, 1)
    run = store.run(crashed.id)
    assert (run.crashes, run.cause, run.reason) == (0, None, None)


def test_retry__a_verdict_on_request(store: Store) -> None:
    row = store.create_sweep(sweep_of(1))
    finish_all(store, succeeded=False)
    assert store.retry_sweep(row.id).counts["queued"] == 0
    finish_all(store)
    assert store.retry_sweep(row.id, verdicts=True).counts["queued"] == 1
    assert store.run(run_id(0)).state is State.QUEUED


def test_retry__publishes_again_and_keeps_the_old_files_until_then(store: Store) -> None:
    row = store.create_sweep(sweep_of(1))
    finish_all(store)
    assert store.retry_sweep(row.id).state is SweepState.PUBLISHING
    assert store.artifacts(row.id)
    [publication] = store.claim(1, TERM)
    assert publication.attempt == 2
    with pytest.raises(Conflict):
        store.retry_sweep(row.id)


def test_delete__only_what_has_ended(store: Store) -> None:
    row = store.create_sweep(sweep_of(1))
    with pytest.raises(Conflict):
        store.delete_sweep(row.id)
    finish_all(store)
    store.delete_sweep(row.id)
    with pytest.raises(NotFound):
        store.sweep(row.id)
    assert store.run(run_id(0)).state is State.SUCCEEDED
    assert store.forgotten([row.id]) == {row.id}


@pytest.mark.parametrize("order", ["sweep", "cancel_sweep", "retry_sweep", "delete_sweep"])
def test_unknown_sweep__is_not_found(store: Store, order: str) -> None:
    with pytest.raises(NotFound):
        getattr(store, order)(run_id(77))


def test_unknown_run__is_not_found_and_a_publication_is_no_run(store: Store) -> None:
    store.create_sweep(sweep_of(1))
    finish_all(store)
    with store._database.reading() as reading:
        kind = JOBS.c.kind == Kind.PUBLISH
        id = reading.execute(sa.select(JOBS.c.id).where(kind)).scalar_one()
    for unknown in (run_id(77), id):
        with pytest.raises(NotFound):
            store.run(unknown)


def test_retry__the_files_of_a_run_that_is_queued_again_are_forgotten(store: Store) -> None:
    row = store.create_sweep(sweep_of(1))
    [claim] = claim_runs(store, 1)
    store.fail(claim, Cause.CRASH, failure="SIGSEGV", reason="died", files=[stored("log.txt")])
    finish_all(store)
    assert [file.name for file in store.run_files(run_id(0))] == ["log.txt"]
    store.retry_sweep(row.id)
    assert store.run_files(run_id(0)) == ()


def test_cancel__the_database_is_told_in_one_statement_a_table(store: Store) -> None:
    shared = store.create_sweep(sweep_of(2), priority=5)
    mine = store.create_sweep(sweep_of(4), priority=-5)
    [done, running] = claim_runs(store, 2)
    store.finish(done, result())
    with statements(store) as sent:
        store.cancel_sweep(mine.id)
    for table in ("points", "jobs", "sweeps"):
        assert len([one for one in sent if one.startswith(f"UPDATE {table} ")]) == 1
    assert store.run(running.id).state is State.RUNNING
    assert store.run(running.id).priority == 5
    assert store.sweep(shared.id).counts["running"] == 1
    assert store.sweep(mine.id).state is SweepState.CANCELLING  # its one result is published
