"""Leases on jobs: given to the dispatcher, adopted by its successor, ended with the result of the attempt.

Each method is one transaction: the move of the job (``transitions``), its files, its event and the counts. An attempt
that is no longer the last one of its job has no effect (False, or None).
"""

from bisect import bisect_left
from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import replace
from datetime import datetime

import sqlalchemy as sa

from service.records.jobs import RUN_SECONDS, AttemptProgress, Cause, CrashCount, Keep, Lease, Result, State, Stored
from service.store import transitions
from service.store.connection import Repository
from service.store.events import log_attempts
from service.store.fair_queueing import schedule, take_due
from service.store.tables import (
    ARTIFACTS,
    CAUSES,
    CONTROL,
    HAS_RESULT,
    IS_QUEUED,
    IS_UNDER_WAY,
    JOBS,
    PUBLISH_PRIORITY,
    RESULTS,
    TERMS,
    count_bytes,
    insert_into,
    now,
    sweeps_waiting_for,
)


class Leases(Repository):
    """The queue as the dispatcher works through it."""

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
            leases = tuple(sorted(transitions.claim(connection, due, term), key=lambda lease: due.index(lease.id)))
            log_attempts(connection, moment, "started", *leases)
        return leases

    def adopt(self, lease: Lease, term: int) -> Lease | None:
        """Carry on an attempt of an earlier term in this one; None: it no longer counts."""
        with self._database.writing() as connection:
            if connection.execute(_standing(term)).one().has_ended:
                return None
            renewed = transitions.renew_lease(connection, lease, term)
            if renewed is None:
                return None
            log_attempts(connection, now(), "adopted", lease)
        return _running(renewed)

    def held(self) -> tuple[Lease, ...]:
        """Every job that is running or being stopped, whatever the term of its lease."""
        rows = self._database.rows(sa.select(*transitions.LEASE_COLUMNS).where(IS_UNDER_WAY))
        return tuple(_running(transitions.lease_record(row)) for row in rows)

    def record_progress(self, news: Sequence[tuple[Lease, AttemptProgress]]) -> None:
        """Note the last message about each of these attempts, and the step of its last checkpoint."""
        with self._database.writing() as connection:
            transitions.note_progress(connection, news)

    # --- ends ------------------------------------------------------------------------------------

    def finish(self, lease: Lease, result: Result) -> bool:
        """Register the result of a run: a success, or the solver's verdict.

        Publications that were made without it are made again.
        """
        moment = now()
        state = State.SUCCEEDED if result.succeeded else State.FAILED
        verdict = {} if result.succeeded else {"cause": Cause.VERDICT}
        reason = {} if result.reason is None else {"reason": result.reason}
        with self._database.writing() as connection:
            had_result = connection.scalar(sa.select(HAS_RESULT).where(JOBS.c.id == lease.id))
            run = transitions.finish(connection, lease, result, moment)
            if run is None:
                return False
            register_files(connection, lease.id, result.files)
            transitions.queue_for_film(connection, lease, moment)
            if not had_result:
                for id in transitions.outdate_publications(connection, moment, _is_of(lease)):
                    schedule(connection, id)  # its other runs may be under way
            transitions.release_publications(connection, moment, _is_of(lease))
            log_attempts(connection, moment, state, lease, **verdict, **reason)
            key = {"scenario": run.scenario, "succeeded": result.succeeded}
            key["bucket"] = bisect_left(RUN_SECONDS, result.seconds)
            _add(connection, RESULTS, key, {"attempts": 1, "seconds": result.seconds, "cost": run.cost})
            if not result.succeeded:
                count_attempt(connection, Cause.VERDICT)
        return True

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
        moment = now()
        with self._database.writing() as connection:
            why = {"cause": cause, "failure": failure, "reason": reason}
            job = transitions.fail(connection, lease, moment, crashes, why)
            if job is None:
                return False
            if job.path is None:  # else it went back to an earlier result
                register_files(connection, lease.id, files)
            transitions.release_publications(connection, moment, _is_of(lease))
            log_attempts(connection, moment, State.FAILED, lease, cause=cause, reason=reason)
            count_attempt(connection, cause)
        return True

    def requeue(self, lease: Lease, cause: Cause, *, reason: str, crashes: CrashCount | None = None) -> State | None:
        """Put an attempt without result back into the queue, or end its job if no sweep waits for it.

        Returns the new state of the job; None: the attempt no longer counts. ``crashes`` are counted in its row.
        """
        moment = now()
        with self._database.writing() as connection:
            outcome = transitions.requeue(connection, lease, moment, crashes)
            if outcome is State.QUEUED:
                count_attempt(connection, cause)
                log_attempts(connection, moment, "requeued", lease, cause=cause, reason=reason)
            elif outcome is not None:
                log_attempts(connection, moment, "cancelled", lease)
        return outcome

    def publish(self, lease: Lease, files: Sequence[Stored], *, seconds: float, headline: str = "") -> bool:
        """Register the files of a publication and the headline of its report, in place of earlier ones, all at once."""
        moment = now()
        with self._database.writing() as connection:
            if not transitions.publish(connection, lease, moment, seconds, headline):
                return False
            connection.execute(ARTIFACTS.delete().where(ARTIFACTS.c.job_id == lease.id))
            register_files(connection, lease.id, files)
            names = [file.name for file in files]
            log_attempts(connection, moment, "published", lease, files=names)
        return True


def _is_of(lease: Lease) -> sa.ColumnElement[bool]:
    """The publication is of a sweep that the leased run counts for."""
    return JOBS.c.sweep_id.in_(sweeps_waiting_for(lease.id))


def _running(lease: Lease) -> Lease:
    """The lease of an attempt under way; its process may keep less than the row demands by now."""
    return replace(lease, keep=Keep.NUMBERS)


def _standing(term: int) -> sa.Select[datetime | None, bool]:
    """Whether the queue is paused, and whether a later term has ended this one."""
    later = sa.exists().where(TERMS.c.term > term)
    return sa.select(CONTROL.c.paused, later.label("has_ended"))


def count_attempt(connection: sa.Connection, cause: Cause) -> None:
    """Count an attempt that did not succeed."""
    _add(connection, CAUSES, {"cause": cause}, {"attempts": 1})


def _add(
    connection: sa.Connection, table: sa.Table, key: Mapping[str, str | bool | int], sums: Mapping[str, float]
) -> None:
    """Add to the sums in the row with a key, which is made if it is missing."""
    insert = insert_into(connection, table).values(**key, **sums)
    more = {name: table.c[name] + value for name, value in sums.items()}
    connection.execute(insert.on_conflict_do_update(index_elements=[*key], set_=more))


def register_files(connection: sa.Connection, job_id: str, files: Iterable[Stored]) -> None:
    """Register files of a job, in place of those of the same names."""
    rows = [{**vars(file), "job_id": job_id} for file in files]
    if rows:
        names = [row["name"] for row in rows]
        same = ARTIFACTS.delete().where(ARTIFACTS.c.job_id == job_id)
        connection.execute(same.where(ARTIFACTS.c.name.in_(names)))
        connection.execute(ARTIFACTS.insert(), rows)
        count_bytes(connection, JOBS.c.id == job_id)
