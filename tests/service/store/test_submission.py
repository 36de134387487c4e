"""Accepted sweeps: shared runs, retention, idempotency keys."""

from typing import cast

import pytest

from service.records.jobs import Cause, CrashCount, Keep, Submission
from service.store import Store
from tests.service.support.fakes import run_id, sweep_of
from tests.service.support.rows import finish_all, lease_runs, result
from tests.service.support.targets import FakeRun

KEY = ("2b6f", "11" * 32)


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


# --- idempotency -----------------------------------------------------------------------------------


def test_same_key__is_the_same_sweep_for_each_owner(store: Store) -> None:
    status = store.sweeps.create(Submission(sweep_of(2), owner="ann", idempotency=KEY))
    finish_all(store)
    again = store.sweeps.create(Submission(sweep_of(2), owner="ann", idempotency=KEY))
    assert again == store.sweeps.get(status.id)
    other = store.sweeps.create(Submission(sweep_of(2), owner="bob", idempotency=KEY))
    assert other.id != status.id
