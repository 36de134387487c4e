"""The store as a queue: claims and their fencing, reigns, budgets, results, publications."""

import pytest

from service.records.jobs import (
    RESULT,
    Cause,
    Kind,
    NotFound,
    State,
    SweepState,
    crashes_before,
)
from service.store import Store
from tests.service.support.fakes import run_id, runs_of, stored, sweep_of
from tests.service.support.rows import TERM, claim_runs, finish_all, result

# --- claims and their fencing ----------------------------------------------------------------------


def test_claim__a_publication_comes_before_runs(store: Store) -> None:
    store.create_sweep(sweep_of(runs_of("fine")))
    store.create_sweep(sweep_of(runs_of("fine", first=5)))
    [claim] = claim_runs(store, 1)
    store.finish(claim, result())
    assert store.claim(1, TERM)[0].kind is Kind.PUBLISH


def test_claim__passes_over_those_that_rest(store: Store) -> None:
    store.create_sweep(sweep_of(3))
    epoch = store.begin_epoch("test")
    claims = store.claim(2, epoch, resting=(run_id(0),))
    assert [claim.id for claim in claims] == [run_id(1), run_id(2)]
    assert [claim.id for claim in store.claim(2, epoch)] == [run_id(0)]


def test_fencing__only_the_first_end_of_an_attempt_counts(store: Store) -> None:
    store.create_sweep(sweep_of(1))
    [claim] = claim_runs(store, 1)
    assert store.finish(claim, result())
    assert not store.finish(claim, result(succeeded=False))
    assert not store.requeue(claim, Cause.LOST, reason="late")
    assert not store.fail(claim, Cause.CRASH, failure="SIGKILL", reason="late")
    assert store.run(claim.id).state is State.SUCCEEDED


def test_fencing__an_attempt_that_was_given_up_has_no_say(store: Store) -> None:
    store.create_sweep(sweep_of(1))
    [old] = claim_runs(store, 1)
    assert store.requeue(old, Cause.LOST, reason="worker lost")
    [new] = store.claim(1, TERM + 1)
    assert not store.finish(old, result())
    assert (new.attempt, new.epoch) == (old.attempt + 1, TERM + 1)
    assert store.finish(new, result())


def test_epochs__grow(store: Store) -> None:
    assert store.begin_epoch("one") < store.begin_epoch("two")


def test_requeue__only_a_crash_is_charged(store: Store) -> None:
    store.create_sweep(sweep_of(1))
    for cause, crashes in ((Cause.LOST, 0), (Cause.CRASH, 1), (Cause.LOST, 1), (Cause.CRASH, 2)):
        [claim] = claim_runs(store, 1)
        assert store.requeue(claim, cause, reason="")
        assert store.run(claim.id).crashes == crashes


def test_progress__reaches_run_and_sweep(store: Store) -> None:
    row = store.create_sweep(sweep_of(2))
    [claim, other] = claim_runs(store, 2)
    store.progress([(claim, 0.5, 3.0, {"step": 9})])
    run = store.run(claim.id)
    assert (run.fraction, run.progress) == (0.5, {"step": 9})
    seen = store.sweep(row.id)
    assert seen.progress == pytest.approx(0.25)
    # One and a half core seconds left at 6 s each, two side by side.
    assert seen.eta_seconds == pytest.approx(1.5 * 6.0 / 2)
    store.finish(claim, result())
    store.finish(other, result())
    assert store.sweep(row.id).progress == 1.0


def test_progress__of_several_attempts_at_once(store: Store) -> None:
    store.create_sweep(sweep_of(3))
    claims = claim_runs(store, 3)
    store.requeue(claims[1], Cause.LOST, reason="")
    store.progress([(claim, 0.5, 3.0, {"step": 9}) for claim in claims])
    store.checkpointed([(claim, 400) for claim in claims])
    seen = [store.run(claim.id) for claim in claims]
    assert [(run.fraction, run.checkpoint) for run in seen] == [
        (0.5, 400),
        (None, None),
        (0.5, 400),
    ]
    store.progress([])


def test_progress__of_an_attempt_that_ended_is_ignored(store: Store) -> None:
    store.create_sweep(sweep_of(1))
    [claim] = claim_runs(store, 1)
    store.requeue(claim, Cause.LOST, reason="")
    store.progress([(claim, 0.5, 3.0, {})])
    assert store.run(claim.id).fraction is None


def test_finish__the_row_has_file_and_summary(store: Store) -> None:
    store.create_sweep(sweep_of(1))
    [claim] = claim_runs(store, 1)
    store.finish(claim, result(succeeded=False))
    run = store.run(claim.id)
    assert (run.state, run.cause, run.failure) == (State.FAILED, Cause.VERDICT, "UnphysicalState")
    assert (run.path, run.size, run.sha256) == ("runs/result.json", 2, "00" * 32)
    assert run.summary == {"numbers": {"steps": 7.0}}
    assert store.pace() == 2.0


def test_checkpoint__its_step_stays_until_the_run_has_ended(store: Store) -> None:
    store.create_sweep(sweep_of(1))
    [claim] = claim_runs(store, 1)
    store.checkpointed([(claim, 400)])
    store.requeue(claim, Cause.LOST, reason="")
    assert store.run(claim.id).checkpoint == 400
    store.checkpointed([(claim, 900)])  # too late
    [claim] = claim_runs(store, 1)
    assert store.run(claim.id).checkpoint == 400
    store.finish(claim, result())
    assert store.run(claim.id).checkpoint is None


def test_crashes__are_counted_at_the_same_checkpoint(store: Store) -> None:
    store.create_sweep(sweep_of(1))
    told = []
    for step in (None, None, 100, 100, 50, 200, None):
        [claim] = claim_runs(store, 1)
        told.append(crashes_before(claim, step))
        assert store.requeue(claim, Cause.CRASH, reason="", crash_step=step)
    assert told == [0, 1, 0, 1, 2, 0, 1]
    [claim] = claim_runs(store, 1)
    assert (claim.crashes, claim.crash_step) == (2, 200)


def test_crashes__a_run_that_is_asked_for_again_begins_anew(store: Store) -> None:
    store.create_sweep(sweep_of(1))
    [claim] = claim_runs(store, 1)
    store.fail(claim, Cause.CRASH, failure="SIGSEGV", reason="died", crash_step=100)
    store.create_sweep(sweep_of(1))
    [claim] = [one for one in store.claim(9, TERM) if one.kind is Kind.RUN]
    assert (claim.crashes, claim.crash_step) == (0, None)


def test_causes__are_counted(store: Store) -> None:
    store.create_sweep(sweep_of(4))
    lost, crashed, verdict, fine = claim_runs(store, 4)
    store.requeue(lost, Cause.LOST, reason="")
    store.fail(crashed, Cause.CRASH, failure="SIGSEGV", reason="")
    store.finish(verdict, result(succeeded=False))
    store.finish(fine, result())
    counted = {cause: number for cause, number in store.attempts_by_cause().items() if number}
    assert counted == {Cause.LOST: 1, Cause.CRASH: 1, Cause.VERDICT: 1}
    assert set(store.attempts_by_cause()) == set(Cause)


def test_files__of_a_run_are_those_of_the_attempt_that_counts(store: Store) -> None:
    store.create_sweep(sweep_of(2))
    first, second = claim_runs(store, 2)
    store.finish(first, result(stored("state.npz", "runs/state.npz")))
    assert [file.name for file in store.run_files(first.id)] == [RESULT, "state.npz"]
    assert store.run_file(first.id, "state.npz").path == "runs/state.npz"
    with pytest.raises(NotFound, match=r"film\.npz"):
        store.run_file(first.id, "film.npz")
    log = stored("log.txt", "runs/log.txt")
    store.fail(second, Cause.CRASH, failure="SIGSEGV", reason="died", files=[log])
    assert store.run_files(second.id) == (log,)
    assert store.run(second.id).path is None
    with pytest.raises(NotFound, match="run"):
        store.run_files(run_id(77))


# --- reigns ----------------------------------------------------------------------------------------


def test_epochs__the_youngest_alone_claims(store: Store) -> None:
    store.create_sweep(sweep_of(2))
    old, young = store.begin_epoch("one"), store.begin_epoch("two")
    assert store.claim(1, old) == ()
    assert len(store.claim(1, young)) == 1
    assert store.queue().epoch == young


def test_adopt__an_attempt_goes_on_under_the_next_reign(store: Store) -> None:
    store.create_sweep(sweep_of(1))
    old = store.begin_epoch("one")
    [claim] = store.claim(1, old)
    young = store.begin_epoch("two")
    adopted = store.adopt(claim, young)
    assert adopted is not None
    assert (adopted.epoch, adopted.attempt, adopted.key) == (young, claim.attempt, claim.key)
    assert not store.finish(claim, result())  # its first owner has no say any more
    assert store.finish(adopted, result())


def test_adopt__only_what_still_counts_and_only_by_the_youngest(store: Store) -> None:
    store.create_sweep(sweep_of(2))
    old = store.begin_epoch("one")
    ended, held = store.claim(2, old)
    store.finish(ended, result())
    middle, young = store.begin_epoch("two"), store.begin_epoch("three")
    assert store.adopt(ended, young) is None
    assert store.adopt(held, middle) is None
    assert store.adopt(held, young) is not None


def test_adopt__what_was_to_be_stopped_still_is(store: Store) -> None:
    row = store.create_sweep(sweep_of(1))
    [claim] = claim_runs(store, 1)
    store.cancel_sweep(row.id)
    adopted = store.adopt(claim, store.begin_epoch("two"))
    assert adopted is not None
    assert adopted.state is State.CANCELLING


def test_hindrance__is_told_until_it_is_gone(store: Store) -> None:
    store.hinder("the scheduler is away")
    assert store.queue().hindrance == "the scheduler is away"
    store.hinder(None)
    assert store.queue().hindrance is None


# --- publication -----------------------------------------------------------------------------------


def test_publication__waits_for_the_last_run(store: Store) -> None:
    row = store.create_sweep(sweep_of(2))
    first, last = claim_runs(store, 2)
    store.finish(first, result())
    assert store.claim(1, TERM) == ()
    store.fail(last, Cause.ERROR, failure="RuntimeError", reason="no")
    assert store.sweep(row.id).state is SweepState.PUBLISHING
    [publication] = store.claim(1, TERM)
    assert publication.sweep_id == row.id


def test_publication__waits_for_the_last_run_whichever_it_is(store: Store) -> None:
    row = store.create_sweep(sweep_of(6))
    claims = claim_runs(store, 6)
    for place in (5, 0, 3, 4, 1):
        assert store.finish(claims[place], result())
        assert store.claim(1, TERM) == ()
    assert store.finish(claims[2], result())
    [publication] = store.claim(1, TERM)
    assert publication.sweep_id == row.id


def test_publication__waits_again_for_a_run_that_another_sweep_asked_for_again(
    store: Store,
) -> None:
    first = store.create_sweep(sweep_of(2))
    crashed, last = claim_runs(store, 2)
    store.fail(crashed, Cause.CRASH, failure="SIGSEGV", reason="died")
    store.create_sweep(sweep_of(1))
    store.finish(last, result())
    assert store.sweep(first.id).state is SweepState.RUNNING
    finish_all(store)
    assert store.sweep(first.id).counts["succeeded"] == 2


def test_publication__a_failed_run_does_not_fail_the_sweep(store: Store) -> None:
    row = store.create_sweep(sweep_of(2))
    finish_all(store, succeeded=False)
    seen = store.sweep(row.id)
    assert (seen.state, seen.counts["failed"]) == (SweepState.SUCCEEDED, 2)


def test_publication__registers_its_files_all_at_once(store: Store) -> None:
    row = store.create_sweep(sweep_of(1))
    finish_all(store)
    assert [(file.name, file.path) for file in store.artifacts(row.id)] == [("cube.nc", "cube.nc")]


def test_publication__its_failure_is_the_failure_of_the_sweep(store: Store) -> None:
    row = store.create_sweep(sweep_of(1))
    [claim] = claim_runs(store, 1)
    store.finish(claim, result())
    [publication] = store.claim(1, TERM)
    store.fail(publication, Cause.ERROR, failure="OSError", reason="disk full")
    seen = store.sweep(row.id)
    assert (seen.state, seen.reason) == (SweepState.FAILED, "disk full")


def test_publication__that_fails_again_leaves_the_earlier_files(store: Store) -> None:
    row = store.create_sweep(sweep_of(1))
    finish_all(store)
    store.retry_sweep(row.id)
    [publication] = store.claim(1, TERM)
    log = stored("log.txt", "log.txt")
    store.fail(publication, Cause.ERROR, failure="OSError", reason="disk full", files=[log])
    assert [file.name for file in store.artifacts(row.id)] == ["cube.nc", "log.txt"]


def test_publication__its_files_replace_all_earlier_ones(store: Store) -> None:
    row = store.create_sweep(sweep_of(1))
    finish_all(store)
    store.retry_sweep(row.id)
    [publication] = store.claim(1, TERM)
    assert store.publish(publication, [stored("report.html", "report.html")], seconds=1.0)
    assert [file.name for file in store.artifacts(row.id)] == ["report.html"]


def test_publication__is_told_how_every_point_ended(store: Store) -> None:
    row = store.create_sweep(sweep_of(3))
    good, bad, _ = claim_runs(store, 3)
    store.finish(good, result())
    store.fail(bad, Cause.CRASH, failure="SIGSEGV", reason="died")
    store.cancel_sweep(row.id)
    document, outcomes = store.question(row.id)
    assert document["name"] == "asked"
    assert [(one.state, one.reason) for one in outcomes] == [
        (State.SUCCEEDED, None),
        (State.FAILED, "died"),
        (State.CANCELLED, None),
    ]
