"""Leases on jobs: given to the dispatcher, adopted by its successor, ended with the result of the attempt.

Every update names job, attempt and term, and has no effect (it returns False, or None) unless they are
the last ones of the job: an attempt that was given up cannot overwrite the work of its successor.
"""

import secrets
from collections.abc import Collection, Mapping, Sequence
from dataclasses import replace
from typing import Any

import sqlalchemy as sa

from service.records.jobs import Cause, CrashCount, Keep, Kind, Lease, Result, State, Stored, before
from service.store.connection import Database
from service.store.events import log_attempts
from service.store.fair_queueing import IS_WANTED, QUEUE_ORDER, advance_classes, queue_for_film
from service.store.statements import (
    IS_HELD,
    LEASE_COLUMNS,
    NO_PROGRESS,
    PUBLISH_PRIORITY,
    Row,
    count_attempt,
    given_up,
    held_by,
    hold_publications,
    is_held,
    lease_record,
    now,
    register_files,
    release_publications,
    retention_if,
    unless_result,
)
from service.store.tables import CONTROL, JOBS, POINTS, TERMS


class Leases:
    """The queue as the dispatcher works through it."""

    def __init__(self, database: Database):
        self._database = database

    def take(
        self, limit: int, term: int, *, publications_only: bool = False, backed_off: Collection[str] = ()
    ) -> tuple[Lease, ...]:
        """Lease up to ``limit`` queued jobs: publications first, then runs by priority and virtual time.

        None in a term that has ended; publications only while the queue is paused, or on request;
        none of those that are ``backed_off``.
        """
        moment = now()
        head = sa.select(JOBS.c.id).where(JOBS.c.state == State.QUEUED)
        head = head.order_by(*QUEUE_ORDER).limit(limit)
        with self._database.writing() as connection:
            paused, has_ended = connection.execute(_standing(term)).one()
            if has_ended:
                return ()
            if paused is not None or publications_only:
                head = head.where(JOBS.c.priority == PUBLISH_PRIORITY)
            if backed_off:
                head = head.where(JOBS.c.id.not_in(backed_off))
            begin = _begin_attempts(head, term).returning(*LEASE_COLUMNS, JOBS.c.virtual_time, JOBS.c.ordinal)
            rows = connection.execute(begin).all()
            if not rows:
                return ()
            rows = sorted(rows, key=lambda row: (row.priority, row.virtual_time, row.ordinal))
            leases = tuple(lease_record(row) for row in rows)
            # In order, so that the last virtual time of each priority is the one that stays.
            advance_classes(connection, {row.priority: row.virtual_time for row in rows})
            log_attempts(connection, moment, "started", *leases)
        return leases

    def adopt(self, lease: Lease, term: int) -> Lease | None:
        """Carry on an attempt of an earlier term in this one; None: it no longer counts."""
        with self._database.writing() as connection:
            if connection.execute(_standing(term)).one().has_ended:
                return None
            update = JOBS.update().where(is_held(lease)).values(term=term)
            row = connection.execute(update.returning(*LEASE_COLUMNS)).first()
            if row is None:
                return None
            log_attempts(connection, now(), "adopted", lease)
        return _running(row)

    def held(self) -> tuple[Lease, ...]:
        """Every job that is running or being stopped, whatever the term of its lease."""
        held = JOBS.c.state.in_([State.RUNNING, State.CANCELLING])
        with self._database.reading() as connection:
            rows = connection.execute(sa.select(*LEASE_COLUMNS).where(held))
            return tuple(_running(row) for row in rows)

    # --- progress --------------------------------------------------------------------------------

    def record_progress(self, news: Sequence[tuple[Lease, float, float, Mapping[str, Any]]]) -> None:
        """Note the progress of attempts: lease, fraction, seconds so far, progress of the solver."""
        rows = [
            {**held_by(lease), "now_at": fraction, "spent": seconds, "message": dict(progress)}
            for lease, fraction, seconds, progress in news
        ]
        self._note(rows, fraction="now_at", seconds="spent", progress="message")

    def record_checkpoints(self, news: Sequence[tuple[Lease, int]]) -> None:
        """Note the step of the last checkpoint of attempts."""
        rows = [{**held_by(lease), "saved": step} for lease, step in news]
        self._note(rows, checkpoint="saved")

    def _note(self, rows: Sequence[Mapping[str, Any]], **columns: str) -> None:
        """Write news of attempts that still count; ``columns`` names the parameter of each column."""
        values = {name: sa.bindparam(parameter, type_=JOBS.c[name].type) for name, parameter in columns.items()}
        if rows:
            with self._database.writing() as connection:
                connection.execute(JOBS.update().where(IS_HELD).values(values), rows)

    # --- ends ------------------------------------------------------------------------------------

    def finish(self, lease: Lease, result: Result) -> bool:
        """Register the result of a run: a success, or the solver's verdict."""
        end: dict[str, Any] = {
            "state": State.SUCCEEDED if result.succeeded else State.FAILED,
            "cause": None if result.succeeded else Cause.VERDICT,
            "failure": result.failure,
            "reason": result.reason,
            "summary": dict(result.summary),
            "path": result.answer.path,
            "size": result.answer.size,
            "sha256": result.answer.sha256,
            "seconds": result.seconds,
            "fraction": 1.0,
            "checkpoint": None,
        }
        event = {name: end[name] for name in ("cause", "reason") if end[name] is not None}
        return self._end(lease, end["state"], end, files=result.files, event=event)

    def fail(
        self,
        lease: Lease,
        cause: Cause,
        *,
        failure: str,
        reason: str,
        crashes: CrashCount | None = None,
        files: Sequence[Stored] = (),
    ) -> bool:
        """End a job for good without a new result; ``files`` hold its log, and ``crashes`` are counted in its row.

        A run that had a result before goes back to it. Its checkpoint stays, for a retry.
        """
        end = {
            "state": sa.type_coerce(given_up(State.FAILED), JOBS.c.state.type),
            "keep": retention_if(sa.true()),
            **unless_result(cause=cause, failure=failure, reason=reason),
            **_counted(crashes),
        }
        event = {"cause": cause, "reason": reason}
        return self._end(lease, State.FAILED, end, files=files, event=event)

    def requeue(self, lease: Lease, cause: Cause, *, reason: str, crashes: CrashCount | None = None) -> State | None:
        """Put an attempt without result back into the queue, or end its job if no sweep waits for it.

        Returns the new state of the job; None: the attempt no longer counts. ``crashes`` are counted in its row.
        """
        moment = now()
        ends = sa.and_(JOBS.c.kind == Kind.RUN, sa.not_(IS_WANTED))
        state = sa.case((ends, given_up(State.CANCELLED)), else_=State.QUEUED.value)
        put_back = (
            JOBS.update()
            .where(is_held(lease))
            .values(state=sa.type_coerce(state, JOBS.c.state.type), keep=retention_if(ends))
            .values(finished=sa.case((ends, moment), else_=sa.null()))
            .values(NO_PROGRESS | _counted(crashes))
            .returning(JOBS.c.state)
        )
        with self._database.writing() as connection:
            outcome: State | None = connection.execute(put_back).scalar()
            if outcome is State.QUEUED:
                hold_publications(connection, JOBS.c.id == lease.id)
                count_attempt(connection, cause)
                log_attempts(connection, moment, "requeued", lease, cause=cause, reason=reason)
            elif outcome is not None:
                log_attempts(connection, moment, "cancelled", lease)
        return outcome

    def _end(
        self,
        lease: Lease,
        state: State,
        values: Mapping[str, Any],
        *,
        files: Sequence[Stored],
        event: Mapping[str, Any],
    ) -> bool:
        """End a leased job, and queue the publications that waited for it alone."""
        moment = now()
        end = JOBS.update().where(is_held(lease), JOBS.c.state.in_(before(state)))
        with self._database.writing() as connection:
            end = end.values(**values, finished=moment).returning(JOBS.c.path)
            row = connection.execute(end).first()
            if row is None:
                return False
            if row.path == values.get("path"):  # else it went back to an earlier result
                register_files(connection, lease.id, files)
            queue_for_film(connection, lease, moment)
            waiting = sa.select(POINTS.c.sweep_id).where(POINTS.c.run_id == lease.id)
            release_publications(connection, moment, JOBS.c.sweep_id.in_(waiting))
            log_attempts(connection, moment, state, lease, **event)
            if "cause" in event:
                count_attempt(connection, event["cause"])
        return True


def _running(row: Row) -> Lease:
    """The lease of an attempt under way; its process may keep less than the row demands by now."""
    return replace(lease_record(row), keep=Keep.NUMBERS)


def _standing(term: int) -> sa.Select[Any]:
    """Whether the queue is paused, and whether a later term has ended this one."""
    later = sa.exists().where(TERMS.c.term > term)
    return sa.select(CONTROL.c.paused, later.label("has_ended"))


def _begin_attempts(head: sa.Select[Any], term: int) -> sa.Update:
    """Begin an attempt of each of these jobs."""
    return (
        JOBS.update()
        .where(JOBS.c.id.in_(head))
        .values(state=State.RUNNING, attempt=JOBS.c.attempt + 1, term=term)
        .values(token=secrets.token_hex(4), started=now(), **NO_PROGRESS)
    )


def _counted(crashes: CrashCount | None) -> dict[str, Any]:
    """The columns of the crashes of a job; none where no crash is counted."""
    return {} if crashes is None else {"crashes": crashes.crashes, "crash_step": crashes.step}
