"""The store: acceptance, sharing, claims and their fencing, cancel, retry, pages, events."""

import threading
from collections.abc import Iterator
from contextlib import closing, contextmanager
from pathlib import Path
from typing import Any

import pytest
import sqlalchemy as sa
from alembic.autogenerate import compare_metadata
from alembic.migration import MigrationContext

from service.jobs import (
    Cause,
    Claim,
    Conflict,
    Kind,
    NotFound,
    Result,
    State,
    StoreUnavailable,
    SweepState,
)
from service.store import Store, connection
from service.store.tables import JOBS, SWEEPS, TABLES
from studies.errors import InvalidInput
from tests.service.doubles import open_store, run_id, runs_of, settings_in, stored, sweep_of
from tests.service.targets import Run

EPOCH = 1


@pytest.fixture
def store(tmp_path: Path) -> Iterator[Store]:
    with closing(open_store(settings_in(tmp_path))) as opened:
        yield opened


def result(*, succeeded: bool = True) -> Result:
    reason = None if succeeded else "density = 3e4"
    failure = None if succeeded else "UnphysicalState"
    return Result(stored(), succeeded, reason, failure, {"numbers": {"steps": 7.0}}, 2.0)


def finish_all(store: Store, *, succeeded: bool = True) -> None:
    """Compute everything that is queued, publications included."""
    while claims := store.claim(100, EPOCH):
        for claim in claims:
            if claim.kind is Kind.PUBLISH:
                assert store.publish(claim, [stored("cube.nc", "cube.nc")], seconds=1.0)
            else:
                assert store.finish(claim, result(succeeded=succeeded))


def claim_runs(store: Store, count: int) -> list[Claim]:
    claims = store.claim(count, EPOCH)
    assert [claim.kind for claim in claims] == [Kind.RUN] * count
    return list(claims)


@contextmanager
def statements(store: Store) -> Iterator[list[str]]:
    """The statements that the block sends, transactions included."""
    sent: list[str] = []

    def note(_c: Any, _cursor: Any, statement: str, *_rest: Any) -> None:
        sent.append(statement)

    engine = store._database._engine
    sa.event.listen(engine, "before_cursor_execute", note)
    try:
        yield sent
    finally:
        sa.event.remove(engine, "before_cursor_execute", note)


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
    assert store.claim(10, EPOCH) == ()


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
    assert [claim.kind for claim in store.claim(9, EPOCH)] == [Kind.PUBLISH]


def test_accept__a_run_asked_twice_in_one_sweep_is_computed_once(store: Store) -> None:
    row = store.create_sweep(sweep_of([Run(run_id(1)), Run(run_id(1))]))
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

    monkeypatch.setattr("service.store.store.log_event", refuse)
    with pytest.raises(RuntimeError):
        store.create_sweep(sweep_of(3))
    assert store.sweeps().items == ()
    assert store.states() == {}


def test_accept__survives_the_end_of_the_process(store: Store, tmp_path: Path) -> None:
    row = store.create_sweep(sweep_of(3))
    with closing(open_store(settings_in(tmp_path))) as again:
        assert again.sweep(row.id) == row
        assert again.sweep_document(row.id)["name"] == "asked"


def test_find__knows_the_question_again(store: Store) -> None:
    from service.store import digest_of

    row = store.create_sweep(sweep_of(2))
    assert store.find_sweep(digest_of(sweep_of(2))) == row
    assert store.find_sweep(digest_of(sweep_of(3))) is None


# --- claims and their fencing ---------------------------------------------------------------------


def test_claim__takes_runs_in_the_order_of_asking(store: Store) -> None:
    store.create_sweep(sweep_of(runs_of("fine", "fine", first=10)))
    store.create_sweep(sweep_of(runs_of("fine", first=0)))
    taken = [store.claim(1, EPOCH)[0].id for _ in range(3)]
    assert taken == [run_id(10), run_id(11), run_id(0)]


def test_claim__a_publication_comes_before_runs(store: Store) -> None:
    store.create_sweep(sweep_of(runs_of("fine")))
    store.create_sweep(sweep_of(runs_of("fine", first=5)))
    [claim] = claim_runs(store, 1)
    store.finish(claim, result())
    assert store.claim(1, EPOCH)[0].kind is Kind.PUBLISH


def test_claim__two_dispatchers_never_get_the_same_job(store: Store) -> None:
    store.create_sweep(sweep_of(200))
    taken: list[str] = []

    def take() -> None:
        while claims := store.claim(3, EPOCH):
            taken.extend(claim.id for claim in claims)

    threads = [threading.Thread(target=take) for _ in range(4)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert sorted(taken) == [run_id(number) for number in range(200)]


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
    [new] = store.claim(1, EPOCH + 1)
    assert not store.finish(old, result())
    assert (new.attempt, new.epoch) == (old.attempt + 1, EPOCH + 1)
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


# --- publication ---------------------------------------------------------------------------------


def test_publication__waits_for_the_last_run(store: Store) -> None:
    row = store.create_sweep(sweep_of(2))
    first, last = claim_runs(store, 2)
    store.finish(first, result())
    assert store.claim(1, EPOCH) == ()
    store.fail(last, Cause.ERROR, failure="RuntimeError", reason="no")
    assert store.sweep(row.id).state is SweepState.PUBLISHING
    [publication] = store.claim(1, EPOCH)
    assert publication.sweep_id == row.id


def test_publication__a_failed_run_does_not_fail_the_sweep(store: Store) -> None:
    row = store.create_sweep(sweep_of(2))
    finish_all(store, succeeded=False)
    seen = store.sweep(row.id)
    assert (seen.state, seen.counts["failed"]) == (SweepState.SUCCEEDED, 2)


def test_publication__registers_its_files_all_at_once(store: Store) -> None:
    row = store.create_sweep(sweep_of(1))
    finish_all(store)
    assert [file.name for file in store.artifacts(row.id)] == ["cube.nc"]
    assert store.artifact(row.id, "cube.nc").path == "cube.nc"
    with pytest.raises(NotFound):
        store.artifact(row.id, "report.html")


def test_publication__its_failure_is_the_failure_of_the_sweep(store: Store) -> None:
    row = store.create_sweep(sweep_of(1))
    [claim] = claim_runs(store, 1)
    store.finish(claim, result())
    [publication] = store.claim(1, EPOCH)
    store.fail(publication, Cause.ERROR, failure="OSError", reason="disk full")
    seen = store.sweep(row.id)
    assert (seen.state, seen.reason) == (SweepState.FAILED, "disk full")


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


# --- cancel, retry, delete -----------------------------------------------------------------------


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
    assert store.claim(9, EPOCH) == ()


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
    [publication] = store.claim(1, EPOCH)
    # Another sweep asks for the same run again, so that it is unfinished once more.
    other = store.create_sweep(sweep_of(1))
    [second] = store.claim(1, EPOCH)
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
    assert store.run(run_id(0)).path is None


def test_retry__publishes_again_and_keeps_the_old_files_until_then(store: Store) -> None:
    row = store.create_sweep(sweep_of(1))
    finish_all(store)
    assert store.retry_sweep(row.id).state is SweepState.PUBLISHING
    assert store.artifacts(row.id)
    [publication] = store.claim(1, EPOCH)
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


# --- questions -----------------------------------------------------------------------------------


def test_sweeps__pages_are_complete_and_youngest_first(store: Store) -> None:
    ids = [store.create_sweep(sweep_of(1, name=f"s{number}")).id for number in range(5)]
    seen, cursor = [], None
    while True:
        page = store.sweeps(limit=2, cursor=cursor)
        seen += [row.id for row in page.items]
        cursor = page.next_cursor
        if cursor is None:
            break
    assert seen == ids[::-1]


def test_sweeps__can_be_asked_for_by_state(store: Store) -> None:
    done = store.create_sweep(sweep_of(1))
    finish_all(store)
    cancelled = store.create_sweep(sweep_of(runs_of("fine", first=10)))
    store.cancel_sweep(cancelled.id)
    queued = store.create_sweep(sweep_of(runs_of("fine", first=20)))
    expected = {
        SweepState.SUCCEEDED: done.id,
        SweepState.CANCELLED: cancelled.id,
        SweepState.QUEUED: queued.id,
    }
    for state in SweepState:
        found = [row.id for row in store.sweeps(state=state).items]
        assert found == ([expected[state]] if state in expected else [])


def test_points__pages_in_the_order_of_the_sweep_with_coordinates(store: Store) -> None:
    row = store.create_sweep(sweep_of(5))
    first = store.sweep_runs(row.id, limit=3)
    rest = store.sweep_runs(row.id, limit=3, cursor=first.next_cursor)
    points = [*first.items, *rest.items]
    assert [point.index for point in points] == [(0,), (1,), (2,), (3,), (4,)]
    assert points[2].coordinates == {"speed": 2000.0}
    assert rest.next_cursor is None


def test_points__can_be_asked_for_by_state(store: Store) -> None:
    row = store.create_sweep(sweep_of(3))
    _, bad, _ = claim_runs(store, 3)
    store.fail(bad, Cause.CRASH, failure="SIGSEGV", reason="died")
    [point] = store.sweep_runs(row.id, state=State.FAILED).items
    assert (point.run.id, point.run.reason) == (bad.id, "died")


@pytest.mark.parametrize("cursor", ["", "x", "-1", "1; drop table", "9" * 30, "٣"])
def test_cursor__only_one_that_a_page_gave(store: Store, cursor: str) -> None:
    row = store.create_sweep(sweep_of(1))
    with pytest.raises(InvalidInput, match="cursor"):
        store.sweeps(cursor=cursor)
    with pytest.raises(InvalidInput, match="cursor"):
        store.sweep_runs(row.id, cursor=cursor)


def test_events__tell_the_story_of_a_sweep_and_of_nothing_else(store: Store) -> None:
    store.create_sweep(sweep_of(1))
    finish_all(store)
    row = store.create_sweep(sweep_of(runs_of("fine", first=5)))
    [claim] = claim_runs(store, 1)
    store.requeue(claim, Cause.LOST, reason="worker lost")
    finish_all(store)
    events = store.events(row.id)
    assert [event.kind for event in events] == [
        *("accepted", "started", "requeued", "started", "succeeded", "started", "published")
    ]
    assert store.events(row.id, after=events[2].number) == events[3:]
    numbers = [event.number for event in events]
    assert numbers == sorted(set(numbers))


def test_known_runs__those_that_need_no_computation(store: Store) -> None:
    store.create_sweep(sweep_of(3))
    done, accident, _ = claim_runs(store, 3)
    store.finish(done, result())
    store.fail(accident, Cause.CRASH, failure="SIGSEGV", reason="died")
    assert len(store.known_runs(run_id(number) for number in range(2000))) == 2


# --- size, database ------------------------------------------------------------------------------


def test_size__a_page_takes_at_most_three_statements(store: Store) -> None:
    row = store.create_sweep(sweep_of(2000))
    for question in (
        store.sweeps,
        lambda: store.sweep(row.id),
        lambda: store.sweep_runs(row.id, state=State.QUEUED),
        lambda: store.events(row.id),
    ):
        with statements(store) as sent:
            question()
        assert len([one for one in sent if not one.startswith("BEGIN")]) <= 3


def test_size__a_cancel_takes_as_many_statements_for_a_thousand_runs_as_for_one(
    store: Store,
) -> None:
    small = store.create_sweep(sweep_of(1))
    large = store.create_sweep(sweep_of(runs_of(*["fine"] * 1000, first=100)))
    sent = []
    for row in (small, large):
        with statements(store) as said:
            store.cancel_sweep(row.id)
        sent.append(len(said))
    assert sent[0] == sent[1]


def test_size__the_queue_is_read_through_its_index(store: Store) -> None:
    query = (
        sa.select(JOBS.c.id)
        .where(JOBS.c.state == State.QUEUED)
        .order_by(JOBS.c.priority, JOBS.c.queued, JOBS.c.ordinal)
    )
    with store._database.reading() as reading:
        text = query.compile(reading, compile_kwargs={"literal_binds": True})
        plan = reading.exec_driver_sql(f"EXPLAIN QUERY PLAN {text}").all()
    assert "USING COVERING INDEX jobs_queue" in str(plan) or "USING INDEX jobs_queue" in str(plan)
    assert "TEMP B-TREE" not in str(plan)


def test_migrations__make_the_tables_that_the_queries_expect(store: Store) -> None:
    with store._database.reading() as reading:
        options = {"compare_type": True, "include_object": _is_not_version}
        context = MigrationContext.configure(reading, opts=options)
        assert compare_metadata(context, TABLES) == []


def _is_not_version(_object: Any, name: str | None, *_rest: Any) -> bool:
    return name != "alembic_version"


def test_migrations__opening_again_changes_nothing(store: Store, tmp_path: Path) -> None:
    row = store.create_sweep(sweep_of(1))
    with closing(open_store(settings_in(tmp_path))) as again:
        assert again.sweep(row.id).planned == 1


def test_sqlite__is_durable_and_checks_its_references(store: Store) -> None:
    with store._database.writing() as writing:
        pragmas = {
            name: writing.exec_driver_sql(f"PRAGMA {name}").scalar()
            for name in ("journal_mode", "synchronous", "foreign_keys", "busy_timeout")
        }
    assert pragmas == {
        "journal_mode": "wal",
        "synchronous": 2,  # FULL
        "foreign_keys": 1,
        "busy_timeout": connection.BUSY_MILLISECONDS,
    }


def test_database_locked__is_said_and_nothing_changes(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(connection, "BUSY_MILLISECONDS", 50)
    settings = settings_in(tmp_path)
    with closing(open_store(settings)) as store, closing(open_store(settings)) as other:
        with other._database.writing() as holding:
            holding.execute(sa.select(SWEEPS.c.id))
            with pytest.raises(StoreUnavailable, match="locked"):
                store.create_sweep(sweep_of(1))
            assert store.sweeps().items == ()  # reading goes on
        assert store.create_sweep(sweep_of(1)).planned == 1


def test_orders__the_dispatcher_hears_of_them(store: Store) -> None:
    heard: list[None] = []
    store.on_order(lambda: heard.append(None))
    row = store.create_sweep(sweep_of(1))
    store.cancel_sweep(row.id)
    assert len(heard) == 2
