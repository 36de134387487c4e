"""Leases on jobs: given to the dispatcher, adopted by its successor, ended with the result of the attempt.

Every update names job, attempt and term, and has no effect (it returns False, or None) unless they are
the last ones of the job: an attempt that was given up cannot overwrite the work of its successor.
"""

import secrets
from bisect import bisect_left
from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import replace
from typing import Any

import sqlalchemy as sa

from service.records.jobs import RUN_SECONDS, Cause, CrashCount, Keep, Kind, Lease, Result, State, Stored, before
from service.store.connection import Database
from service.store.events import log_attempts, outdate_publications
from service.store.fair_queueing import IS_WANTED, queue_for_film, schedule, take_due
from service.store.tables import (
    ARTIFACTS,
    CAUSES,
    CONTROL,
    HAS_RESULT,
    IS_QUEUED,
    IS_UNDER_WAY,
    JOBS,
    POINTS,
    PUBLISH_PRIORITY,
    RESULTS,
    TERMS,
    StatementRow,
    given_up,
    hold_publications,
    insert_into,
    now,
    release_publications,
    retention_if,
    unless_result,
)

LEASE_COLUMNS = [JOBS.c[field] for field in Lease.__dataclass_fields__]
# Columns of a job that say how far its attempt is.
NO_PROGRESS = dict.fromkeys(("fraction", "progress", "seconds"), sa.null())


def _is_held(id: Any, attempt: Any, term: Any) -> sa.ColumnElement[bool]:
    return sa.and_(
        JOBS.c.id == id,
        JOBS.c.attempt == attempt,
        JOBS.c.term == term,
        # Not IN: a list of states cannot be executed for many leases at once.
        sa.or_(JOBS.c.state == State.RUNNING, JOBS.c.state == State.CANCELLING),
    )


def is_held(lease: Lease) -> sa.ColumnElement[bool]:
    """The lease is the last one of its job, and the attempt has not ended."""
    return _is_held(lease.id, lease.attempt, lease.term)


# ``is_held`` for many leases at once, each with the parameters of ``held_by``.
IS_HELD = _is_held(*(sa.bindparam(f"held_{name}") for name in ("id", "attempt", "term")))


def held_by(lease: Lease) -> dict[str, Any]:
    """Parameters of IS_HELD."""
    return {"held_id": lease.id, "held_attempt": lease.attempt, "held_term": lease.term}


class Leases:
    """The queue as the dispatcher works through it."""

    def __init__(self, database: Database):
        self._database = database

    def take(
        self, limit: int, term: int, *, publications_only: bool = False, backed_off: Collection[str] = ()
    ) -> tuple[Lease, ...]:
        """Lease up to ``limit`` queued jobs: publications first, then runs by priority, shares and virtual time.

        None in a term that has ended; publications only while the queue is paused, or on request;
        none of those that are ``backed_off``.
        """
        moment = now()
        is_due = () if not backed_off else (JOBS.c.id.not_in(backed_off),)
        publications = sa.select(JOBS.c.id).where(IS_QUEUED, JOBS.c.priority == PUBLISH_PRIORITY)
        # In the order of their index, which is read then: another one holds all queued jobs.
        publications = publications.order_by(JOBS.c.owner, JOBS.c.virtual_time, JOBS.c.ordinal)
        publications = publications.where(*is_due).limit(limit)
        with self._database.writing() as connection:
            paused, has_ended = connection.execute(_standing(term)).one()
            if has_ended:
                return ()
            due = list(connection.scalars(publications))
            if paused is None and not publications_only and len(due) < limit:
                due += take_due(connection, limit - len(due), *is_due)
            if not due:
                return ()
            rows = connection.execute(_begin_attempts(due, term).returning(*LEASE_COLUMNS))
            leases = tuple(sorted(map(lease_record, rows), key=lambda lease: due.index(lease.id)))
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
        with self._database.reading() as connection:
            rows = connection.execute(sa.select(*LEASE_COLUMNS).where(IS_UNDER_WAY))
            return tuple(_running(row) for row in rows)

    # --- progress --------------------------------------------------------------------------------

    def record_progress(self, news: Sequence[tuple[Lease, Mapping[str, Any]]]) -> None:
        """Note the last message about each of these attempts, and the step of its last checkpoint."""
        progress = {name: sa.bindparam(f"new_{name}", type_=JOBS.c[name].type) for name in NO_PROGRESS}
        rows = [
            {
                **held_by(lease),
                "new_fraction": float(message.get("fraction") or 0.0),
                "new_seconds": float(message["seconds"]),
                "new_progress": dict(message),
            }
            for lease, message in news
        ]
        saved = [
            {**held_by(lease), "step": message["checkpoint"]} for lease, message in news if "checkpoint" in message
        ]
        with self._database.writing() as connection:
            if rows:
                connection.execute(JOBS.update().where(IS_HELD).values(progress), rows)
            if saved:
                connection.execute(JOBS.update().where(IS_HELD).values(checkpoint=sa.bindparam("step")), saved)

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
        """End a leased job, and queue the publications that waited for it alone, or were made without its result."""
        moment = now()
        end = JOBS.update().where(is_held(lease), JOBS.c.state.in_(before(state)))
        with self._database.writing() as connection:
            had_result = connection.scalar(sa.select(HAS_RESULT).where(JOBS.c.id == lease.id))
            end = end.values(**values, finished=moment).returning(JOBS.c.path, JOBS.c.scenario, JOBS.c.cost)
            row = connection.execute(end).first()
            if row is None:
                return False
            if row.path == values.get("path"):  # else it went back to an earlier result
                register_files(connection, lease.id, files)
            queue_for_film(connection, lease, moment)
            using = sa.select(POINTS.c.sweep_id).where(POINTS.c.run_id == lease.id, ~POINTS.c.detached)
            if row.path and not had_result:
                for id in outdate_publications(connection, moment, JOBS.c.sweep_id.in_(using)):
                    schedule(connection, id)  # its other runs may be under way
            release_publications(connection, moment, JOBS.c.sweep_id.in_(using))
            log_attempts(connection, moment, state, lease, **event)
            if "seconds" in values:
                count_result(connection, row, values["seconds"], succeeded=state is State.SUCCEEDED)
            if "cause" in event:
                count_attempt(connection, event["cause"])
        return True


def _running(row: StatementRow) -> Lease:
    """The lease of an attempt under way; its process may keep less than the row demands by now."""
    return replace(lease_record(row), keep=Keep.NUMBERS)


def _standing(term: int) -> sa.Select[Any]:
    """Whether the queue is paused, and whether a later term has ended this one."""
    later = sa.exists().where(TERMS.c.term > term)
    return sa.select(CONTROL.c.paused, later.label("has_ended"))


def _begin_attempts(ids: Sequence[str], term: int) -> sa.Update:
    """Begin an attempt of each of these jobs."""
    return (
        JOBS.update()
        .where(JOBS.c.id.in_(ids))
        .values(state=State.RUNNING, attempt=JOBS.c.attempt + 1, term=term)
        .values(token=secrets.token_hex(4), started=now(), **NO_PROGRESS)
    )


def _counted(crashes: CrashCount | None) -> dict[str, Any]:
    """The columns of the crashes of a job; none where no crash is counted."""
    return {} if crashes is None else {"crashes": crashes.crashes, "crash_step": crashes.step}


def wait_again(connection: sa.Connection, lease: Lease, *conditions: sa.ColumnElement[bool]) -> bool:
    """End the attempt of a leased publication: it waits for runs again. False: the attempt no longer counts."""
    wait = JOBS.update().where(is_held(lease), *conditions).values(NO_PROGRESS)
    wait = wait.values(state=State.WAITING, unfinished_point=sa.null(), finished=sa.null())
    return connection.execute(wait).rowcount > 0


def count_result(connection: sa.Connection, run: StatementRow, seconds: float, *, succeeded: bool) -> None:
    """Count an attempt that ended with a result, of a run of this scenario and estimated cost."""
    key = {"scenario": run.scenario, "succeeded": succeeded, "bucket": bisect_left(RUN_SECONDS, seconds)}
    sums = {"attempts": 1, "seconds": seconds, "cost": run.cost}
    insert = insert_into(connection, RESULTS).values(**key, **sums)
    more = {name: RESULTS.c[name] + value for name, value in sums.items()}
    connection.execute(insert.on_conflict_do_update(index_elements=[*key], set_=more))


def count_attempt(connection: sa.Connection, cause: Cause) -> None:
    """Count an attempt that did not succeed."""
    insert = insert_into(connection, CAUSES).values(cause=cause, attempts=1)
    one_more = {"attempts": CAUSES.c.attempts + 1}
    connection.execute(insert.on_conflict_do_update(index_elements=["cause"], set_=one_more))


def register_files(connection: sa.Connection, job_id: str, files: Iterable[Stored]) -> None:
    """Register files of a job, in place of those of the same names."""
    rows = [{**vars(file), "job_id": job_id} for file in files]
    if rows:
        names = [row["name"] for row in rows]
        same = ARTIFACTS.delete().where(ARTIFACTS.c.job_id == job_id)
        connection.execute(same.where(ARTIFACTS.c.name.in_(names)))
        connection.execute(ARTIFACTS.insert(), rows)


def lease_record(row: StatementRow) -> Lease:
    """A lease from a row with LEASE_COLUMNS."""
    values = {field: row._mapping[JOBS.c[field]] for field in Lease.__dataclass_fields__}
    return Lease(**{**values, "spec": values["spec"] or {}})
