"""Leases on jobs: given to the dispatcher, adopted by its successor, ended with the result of the attempt.

Every update names job, attempt and term, and has no effect (it returns False, or None) unless they are
the last ones of the job: an attempt that was given up cannot overwrite the work of its successor.
"""

import secrets
from collections.abc import Collection, Mapping, Sequence
from dataclasses import replace
from typing import Any

import sqlalchemy as sa

from service.files.lost_results import Loss
from service.records.fault_points import fault_point
from service.records.jobs import COUNTED, Cause, Keep, Kind, Lease, Result, State, Stored, before, crashes_before
from service.store import leadership
from service.store.connection import Part
from service.store.fair_queueing import IS_WANTED, QUEUE_ORDER, advance_classes, queue_for_film
from service.store.leadership import Leadership
from service.store.lost_results import forget_results
from service.store.statements import (
    IS_HELD,
    LEASE_COLUMNS,
    PUBLISH_PRIORITY,
    Row,
    count_attempt,
    given_up,
    held_by,
    hold_publications,
    is_held,
    lease_record,
    log_attempts,
    now,
    register_files,
    release_publications,
    retention_if,
    unless_result,
)
from service.store.tables import ARTIFACTS, CONTROL, JOBS, POINTS, TERMS

# Columns of a job that say how far its attempt is.
NO_PROGRESS = dict.fromkeys(("fraction", "progress", "seconds"), sa.null())


class Leases(Part):
    """The queue as the dispatcher works through it."""

    # --- terms of leadership ---------------------------------------------------------------------

    def lead(self, owner: str) -> Leadership | None:
        """Become the service that works through the queue; None: another one is."""
        return leadership.lead(self._database, owner)

    def begin_term(self, owner: str) -> int:
        """Number of a new term of leadership; no lease is given in earlier ones any more."""
        begin = TERMS.insert().values(owner=owner, started=now())
        with self._database.writing() as connection:
            return connection.execute(begin.returning(TERMS.c.term)).scalar_one()

    def set_blocked_reason(self, reason: str | None, term: int | None = None) -> None:
        """Note why nothing is begun although there is work; None: nothing blocks the queue.

        Without effect for a ``term`` that has ended; None stands for a service that never led.
        """
        note = CONTROL.update().values(blocked_reason=reason)
        if term is not None:
            note = note.where(sa.not_(sa.exists().where(TERMS.c.term > term)))
        with self._database.writing() as connection:
            connection.execute(note)

    # --- leases ----------------------------------------------------------------------------------

    def lease(
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

    def leases(self) -> tuple[Lease, ...]:
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
        crash_step: int | None = None,
        files: Sequence[Stored] = (),
    ) -> bool:
        """End a job for good without a new result; ``files`` hold its log.

        A run that had a result before goes back to it. Its checkpoint stays, for a retry.
        """
        end = {
            "state": sa.type_coerce(given_up(State.FAILED), JOBS.c.state.type),
            "keep": retention_if(sa.true()),
            **unless_result(cause=cause, failure=failure, reason=reason),
            **_crash_count(lease, cause, crash_step),
        }
        event = {"cause": cause, "reason": reason}
        return self._end(lease, State.FAILED, end, files=files, event=event)

    def requeue(self, lease: Lease, cause: Cause, *, reason: str, crash_step: int | None = None) -> State | None:
        """Put an attempt without result back into the queue, or end its job if no sweep waits for it.

        Returns the new state of the job; None: the attempt no longer counts. ``crash_step`` is the
        step of the last checkpoint of an attempt that crashed.
        """
        moment = now()
        ends = sa.and_(JOBS.c.kind == Kind.RUN, sa.not_(IS_WANTED))
        state = sa.case((ends, given_up(State.CANCELLED)), else_=State.QUEUED.value)
        put_back = (
            JOBS.update()
            .where(is_held(lease))
            .values(state=sa.type_coerce(state, JOBS.c.state.type), keep=retention_if(ends))
            .values(finished=sa.case((ends, moment), else_=sa.null()))
            .values(NO_PROGRESS | _crash_count(lease, cause, crash_step))
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

    def lose_results(self, lease: Lease, losses: Sequence[Loss]) -> bool:
        """End a publication that found results of its runs lost: it waits until they are computed again.

        Raises TooManyLost, and changes nothing, beyond the limits of ``lost_results``.
        """
        moment = now()
        wait = JOBS.update().where(is_held(lease)).values(NO_PROGRESS)
        wait = wait.values(state=State.WAITING, unfinished_point=sa.null())
        reason = f"results of {len(losses)} runs are lost"
        with self._database.writing() as connection:
            if not connection.execute(wait).rowcount:
                return False
            forget_results(connection, moment, lease, losses)
            count_attempt(connection, Cause.LOST)
            log_attempts(connection, moment, "requeued", lease, cause=Cause.LOST, reason=reason)
        return True

    def publish(self, lease: Lease, files: Sequence[Stored], *, seconds: float) -> bool:
        """Register the files of a publication, in place of earlier ones, all at once."""
        moment = now()
        end = {"state": State.SUCCEEDED, "seconds": seconds, "finished": moment}
        with self._database.writing() as connection:
            if not connection.execute(JOBS.update().where(is_held(lease)).values(end)).rowcount:
                return False
            connection.execute(ARTIFACTS.delete().where(ARTIFACTS.c.job_id == lease.id))
            register_files(connection, lease.id, files)
            names = [file.name for file in files]
            log_attempts(connection, moment, "published", lease, files=names)
            fault_point("publication-before-commit")
        return True

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
            fault_point("result-before-commit")
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


def _crash_count(lease: Lease, cause: Cause, step: int | None) -> dict[str, Any]:
    """Crashes at the last checkpoint after one more attempt; other causes leave them as they are."""
    if cause not in COUNTED:
        return {}
    furthest = max(step or 0, lease.crash_step or 0)
    return {"crashes": crashes_before(lease, step) + 1, "crash_step": furthest}
