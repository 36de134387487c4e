"""The store accepts sweeps: shared runs, what is kept, submissions that are sent twice."""

from contextlib import closing

import pytest

from service.records.jobs import Cause, Keep, KeyReused, Kind, NotFound, SweepState
from service.store import Store, digest_of
from tests.service.support.fakes import run_id, sweep_of
from tests.service.support.rows import TERM, claim_runs, finish_all, result
from tests.service.support.targets import FakeRun

# --- acceptance ----------------------------------------------------------------------------------


def test_accept__says_planned_reused_and_new(store: Store) -> None:
    row = store.create_sweep(sweep_of(3))
    assert (row.planned, row.reused, row.new) == (3, 0, 3)
    assert row.state is SweepState.QUEUED
    assert row.counts == {
        **dict.fromkeys(("running", "cancelling", "succeeded", "failed", "cancelled"), 0),
        "queued": 3,
    }
    assert (row.progress, row.eta_seconds) == (0.0, None)


def test_accept__the_same_question_computes_nothing_new(store: Store) -> None:
    store.create_sweep(sweep_of(3))
    finish_all(store)
    row = store.create_sweep(sweep_of(4))
    assert (row.planned, row.reused, row.new) == (4, 3, 1)
    assert len(claim_runs(store, 1)) == 1
    assert store.claim(10, TERM) == ()


def test_accept__a_run_under_way_is_joined(store: Store) -> None:
    store.create_sweep(sweep_of(2))
    [claim, _] = claim_runs(store, 2)
    row = store.create_sweep(sweep_of(2))
    assert (row.reused, row.new) == (2, 0)
    assert store.finish(claim, result())
    assert store.sweep(row.id).counts["succeeded"] == 1


def test_accept__when_everything_is_there_only_the_publication_is_left(store: Store) -> None:
    store.create_sweep(sweep_of(2))
    finish_all(store)
    row = store.create_sweep(sweep_of(2))
    assert row.state is SweepState.PUBLISHING
    assert [claim.kind for claim in store.claim(9, TERM)] == [Kind.PUBLISH]


def test_accept__a_run_asked_twice_in_one_sweep_is_computed_once(store: Store) -> None:
    row = store.create_sweep(sweep_of([FakeRun(run_id(1)), FakeRun(run_id(1))]))
    assert (row.planned, row.new) == (2, 1)
    finish_all(store)
    assert store.sweep(row.id).counts["succeeded"] == 2


def test_accept__an_accident_is_tried_again_and_a_verdict_is_not(store: Store) -> None:
    store.create_sweep(sweep_of(2))
    crashed, verdict = claim_runs(store, 2)
    assert store.fail(crashed, Cause.CRASH, failure="SIGSEGV", reason="died")
    assert store.finish(verdict, result(succeeded=False))
    row = store.create_sweep(sweep_of(2))
    assert (row.reused, row.new) == (1, 1)
    assert (row.counts["queued"], row.counts["failed"]) == (1, 1)


def test_accept__all_or_nothing(store: Store, monkeypatch: pytest.MonkeyPatch) -> None:
    def refuse(*_arguments: object, **_words: object) -> None:
        raise RuntimeError("no more")

    monkeypatch.setattr("service.store.orders.log_event", refuse)
    with pytest.raises(RuntimeError):
        store.create_sweep(sweep_of(3))
    assert store.sweeps().items == ()
    assert store.queue().states == {}


def test_accept__survives_the_end_of_the_process(store: Store, database_url: str) -> None:
    row = store.create_sweep(sweep_of(3))
    with closing(Store.open(database_url)) as again:
        assert again.sweep(row.id) == row
        assert again.sweep_document(row.id)["name"] == "asked"


def test_find__knows_the_question_again(store: Store) -> None:
    row = store.create_sweep(sweep_of(2))
    assert store.find_sweep(digest_of(sweep_of(2))) == row
    assert store.find_sweep(digest_of(sweep_of(3))) is None


# --- what the owner says ---------------------------------------------------------------------------


def test_accept__keeps_what_the_owner_says(store: Store) -> None:
    row = store.create_sweep(sweep_of(1), owner="ann", priority=-7, keep=Keep.FILM)
    assert (row.owner, row.priority, row.keep) == ("ann", -7, Keep.FILM)
    assert store.sweep(row.id) == row
    [claim] = claim_runs(store, 1)
    assert (claim.priority, claim.keep) == (-7, Keep.FILM)


def test_keep__a_run_keeps_the_most_that_any_sweep_asks(store: Store) -> None:
    store.create_sweep(sweep_of(2), keep=Keep.FINAL)
    store.create_sweep(sweep_of(1), keep=Keep.FILM)
    store.create_sweep(sweep_of(2), keep=Keep.NUMBERS)
    assert store.run(run_id(0)).keep is Keep.FILM
    assert store.run(run_id(1)).keep is Keep.FINAL


# --- sent twice ------------------------------------------------------------------------------------

KEY = ("2b6f", "11" * 32)


def test_idempotency__the_same_key_is_the_same_sweep(store: Store) -> None:
    row = store.create_sweep(sweep_of(2), owner="ann", idempotency=KEY)
    finish_all(store)
    again = store.create_sweep(sweep_of(2), owner="ann", idempotency=KEY)
    assert again == store.sweep(row.id)
    assert len(store.sweeps().items) == 1


def test_idempotency__another_body_is_refused_and_nothing_stored(store: Store) -> None:
    store.create_sweep(sweep_of(2), idempotency=KEY)
    with pytest.raises(KeyReused, match="2b6f"):
        store.create_sweep(sweep_of(3), idempotency=("2b6f", "22" * 32))
    assert len(store.sweeps().items) == 1


def test_idempotency__each_owner_has_keys_of_his_own(store: Store) -> None:
    first = store.create_sweep(sweep_of(1), owner="ann", idempotency=KEY)
    other = store.create_sweep(sweep_of(1), owner="bob", idempotency=KEY)
    assert first.id != other.id


def test_idempotency__a_key_goes_with_its_sweep(store: Store) -> None:
    row = store.create_sweep(sweep_of(1), idempotency=KEY)
    finish_all(store)
    store.delete_sweep(row.id)
    again = store.create_sweep(sweep_of(1), idempotency=KEY)
    assert again.id != row.id
    with pytest.raises(NotFound):
        store.sweep(row.id)


def test_idempotency__nothing_is_noted_of_a_submission_that_failed(
    store: Store, monkeypatch: pytest.MonkeyPatch
) -> None:
    def refuse(*_arguments: object, **_words: object) -> None:
        raise RuntimeError("no more")

    with monkeypatch.context() as patch:
        patch.setattr("service.store.orders.log_event", refuse)
        with pytest.raises(RuntimeError):
            store.create_sweep(sweep_of(3), idempotency=KEY)
    assert store.create_sweep(sweep_of(2), idempotency=KEY).planned == 2
