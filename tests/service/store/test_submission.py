"""Accepted sweeps: shared runs, retention, idempotency keys."""

from contextlib import closing
from typing import cast

import pytest

from service.records.jobs import Cause, Keep, KeyReused, Kind, NotFound, Submission, SweepState
from service.store import Store, digest_of
from tests.service.support.fakes import run_id, sweep_of
from tests.service.support.rows import TERM, finish_all, lease_runs, result
from tests.service.support.targets import FakeRun

KEY = ("2b6f", "11" * 32)


def test_sweep__begins_queued_with_all_its_runs_new(store: Store, database_url: str) -> None:
    status = store.create_sweep(Submission(sweep_of(3)))
    assert (status.planned, status.reused, status.new) == (3, 0, 3)
    assert (status.state, status.counts["queued"]) == (SweepState.QUEUED, 3)
    assert (status.progress, status.eta_seconds) == (0.0, None)
    with closing(Store.open(database_url)) as again:
        assert again.sweep(status.id) == status
        assert again.sweep_document(status.id)["name"] == "asked"


def test_finished_runs__are_linked(store: Store) -> None:
    store.create_sweep(Submission(sweep_of(3)))
    finish_all(store)
    assert store.create_sweep(Submission(sweep_of(2))).state is SweepState.PUBLISHING
    assert [lease.kind for lease in store.lease(9, TERM)] == [Kind.PUBLISH]
    status = store.create_sweep(Submission(sweep_of(4)))
    assert (status.planned, status.reused, status.new) == (4, 3, 1)
    lease_runs(store, 1)
    assert store.lease(9, TERM) == ()


def test_run_under_way__is_joined(store: Store) -> None:
    store.create_sweep(Submission(sweep_of(2)))
    [lease, _] = lease_runs(store, 2)
    status = store.create_sweep(Submission(sweep_of(2)))
    assert (status.reused, status.new) == (2, 0)
    assert store.finish(lease, result())
    assert store.sweep(status.id).counts["succeeded"] == 1


def test_run__that_is_twice_in_a_sweep_is_computed_once(store: Store) -> None:
    status = store.create_sweep(Submission(sweep_of([FakeRun(run_id(1)), FakeRun(run_id(1))])))
    assert (status.planned, status.new) == (2, 1)
    finish_all(store)
    assert store.sweep(status.id).counts["succeeded"] == 2


def test_accident__is_computed_again_and_a_verdict_is_not(store: Store) -> None:
    store.create_sweep(Submission(sweep_of(2)))
    crashed, verdict = lease_runs(store, 2)
    assert store.fail(crashed, Cause.CRASH, failure="SIGSEGV", reason="died", crash_step=100)
    assert store.finish(verdict, result(succeeded=False))
    status = store.create_sweep(Submission(sweep_of(2)))
    assert (status.reused, status.new) == (1, 1)
    assert (status.counts["queued"], status.counts["failed"]) == (1, 1)
    [again] = lease_runs(store, 1)
    assert (again.crashes, again.crash_step) == (0, None)  # with a fresh budget


def test_failed_transaction__leaves_nothing(store: Store) -> None:
    """The digest cannot be stored, which shows when every other row is written."""
    broken = ("key", cast(str, object()))
    with pytest.raises(Exception, match=r"(?i)bind|adapt|support"):
        store.create_sweep(Submission(sweep_of(3), idempotency=broken))
    assert store.sweeps().items == ()
    assert store.queue().states == {}


def test_digest__finds_the_same_sweep(store: Store) -> None:
    status = store.create_sweep(Submission(sweep_of(2)))
    assert store.find_sweep(digest_of(sweep_of(2))) == status
    assert store.find_sweep(digest_of(sweep_of(3))) is None


def test_owner_priority_and_retention__are_those_of_the_submission(store: Store) -> None:
    status = store.create_sweep(Submission(sweep_of(1), owner="ann", priority=-7, keep=Keep.FILM))
    assert (status.owner, status.priority, status.keep) == ("ann", -7, Keep.FILM)
    [lease] = lease_runs(store, 1)
    assert (lease.priority, lease.keep) == (-7, Keep.FILM)


def test_shared_run__keeps_the_most_that_a_sweep_demands(store: Store) -> None:
    for runs, keep in ((2, Keep.FINAL), (1, Keep.FILM), (2, Keep.NUMBERS)):
        store.create_sweep(Submission(sweep_of(runs), keep=keep))
    assert [store.run(run_id(number)).keep for number in (0, 1)] == [Keep.FILM, Keep.FINAL]


# --- idempotency -----------------------------------------------------------------------------------


def test_same_key__is_the_same_sweep_for_each_owner(store: Store) -> None:
    status = store.create_sweep(Submission(sweep_of(2), owner="ann", idempotency=KEY))
    finish_all(store)
    again = store.create_sweep(Submission(sweep_of(2), owner="ann", idempotency=KEY))
    assert again == store.sweep(status.id)
    other = store.create_sweep(Submission(sweep_of(2), owner="bob", idempotency=KEY))
    assert other.id != status.id


def test_same_key__with_another_body_is_refused(store: Store) -> None:
    store.create_sweep(Submission(sweep_of(2), idempotency=KEY))
    with pytest.raises(KeyReused, match="2b6f"):
        store.create_sweep(Submission(sweep_of(3), idempotency=("2b6f", "22" * 32)))
    assert len(store.sweeps().items) == 1


def test_key__is_deleted_with_its_sweep(store: Store) -> None:
    status = store.create_sweep(Submission(sweep_of(1), idempotency=KEY))
    finish_all(store)
    store.delete_sweep(status.id)
    assert store.create_sweep(Submission(sweep_of(1), idempotency=KEY)).id != status.id
    with pytest.raises(NotFound):
        store.sweep(status.id)
