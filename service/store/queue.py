"""The queue as a whole: paused or not, jobs by state, its leader, why nothing begins."""

import math
import threading
import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from datetime import datetime

import sqlalchemy as sa

from service.records.jobs import ACTIVE, Cause, JobTally, Kind, QueueRow, State
from service.store import leadership
from service.store.connection import Database
from service.store.events import log_event
from service.store.tables import CAUSES, CONTROL, EVENTS, JOBS, TERMS, now

# Counts of jobs are reused for so many seconds, while no event is logged: any client may ask for them, and with 11 000
# jobs they take 35 ms (2026-11).
REUSE_SECONDS = 0.5


@dataclass(frozen=True)
class _Counts:
    """Jobs by state, and since when the oldest queued run waits, after an event."""

    event: int
    time: float  # monotonic, of the end of counting
    states: Mapping[State, int]
    oldest: datetime | None


class Queue:
    """Each query is one read transaction, of a few statements whatever the size; each command is one transaction."""

    def __init__(self, database: Database):
        self._database = database
        self._counts = _Counts(-1, -math.inf, {}, None)
        self._counting = threading.Lock()

    def pause(self) -> QueueRow:
        """Begin no more runs; those under way go on, and finished sweeps are published."""
        moment = now()
        pause = CONTROL.update().where(CONTROL.c.paused.is_(None)).values(paused=moment)
        with self._database.commanding() as connection:
            if connection.execute(pause).rowcount:
                log_event(connection, moment, "paused")
        return self.status()

    def resume(self) -> QueueRow:
        resume = CONTROL.update().where(CONTROL.c.paused.is_not(None)).values(paused=None)
        with self._database.commanding() as connection:
            if connection.execute(resume).rowcount:
                log_event(connection, now(), "resumed")
        return self.status()

    def allow_forgetting(self, results: int) -> None:
        """Let this many lost results be forgotten beyond the limits, once: their runs are computed again."""
        with self._database.commanding() as connection:
            connection.execute(CONTROL.update().values(forgettable=results))

    def set_blocked_reason(self, reason: str | None, term: int | None = None) -> None:
        """Note why nothing is begun although there is work; None: nothing blocks the queue.

        Without effect for a ``term`` that has ended; None stands for a service that never led.
        """
        note = CONTROL.update().values(blocked_reason=reason)
        if term is not None:
            note = note.where(sa.not_(sa.exists().where(TERMS.c.term > term)))
        with self._database.writing() as connection:
            connection.execute(note)

    def status(self) -> QueueRow:
        """The queue at this moment; counts without an event are up to ``REUSE_SECONDS`` old."""
        youngest = sa.select(sa.func.coalesce(sa.func.max(TERMS.c.term), 0)).scalar_subquery()
        event = sa.select(sa.func.coalesce(sa.func.max(EVENTS.c.number), 0)).scalar_subquery()
        query = sa.select(CONTROL.c.paused, CONTROL.c.blocked_reason, youngest.label("term"), event.label("event"))
        query = query.add_columns(CONTROL.c.clock["paused"].as_string().label("deletion_paused"))
        with self._database.reading() as connection:
            row = connection.execute(query).one()
            counts = self._counted(connection, row.event)
            return QueueRow(
                paused=row.paused,
                blocked_reason=row.blocked_reason,
                deletion_paused=row.deletion_paused,
                states=counts.states,
                oldest_queued=counts.oldest,
                term=row.term,
                leader=leadership.leader(self._database, connection),
            )

    def _counted(self, connection: sa.Connection, event: int) -> _Counts:
        """The counts after an event; one thread counts at a time."""
        with self._counting:
            known = self._counts
            if known.event < event or time.monotonic() - known.time > REUSE_SECONDS:
                queued = sa.case((JOBS.c.kind == Kind.RUN, JOBS.c.queued))
                columns = (JOBS.c.state, sa.func.count().label("jobs"), sa.func.min(queued).label("oldest"))
                rows = connection.execute(sa.select(*columns).group_by(JOBS.c.state)).all()
                jobs = {State(row.state): row.jobs for row in rows}
                oldest = next((row.oldest for row in rows if row.state == State.QUEUED), None)
                known = self._counts = _Counts(event, time.monotonic(), jobs, oldest)
            return known

    def tally(self, edges: Sequence[float]) -> tuple[JobTally, ...]:
        """Jobs by kind, state and place of their measured seconds among ``edges``."""
        bucket = sum((sa.case((JOBS.c.seconds > edge, 1), else_=0) for edge in edges), sa.literal(0))
        measured = sa.case((JOBS.c.seconds.is_(None), sa.null()), else_=bucket)
        jobs = sa.select(JOBS.c.kind, JOBS.c.state, JOBS.c.seconds, measured.label("bucket")).subquery()
        groups = (jobs.c.kind, jobs.c.state, jobs.c.bucket)
        seconds = sa.func.coalesce(sa.func.sum(jobs.c.seconds), 0.0)
        query = sa.select(*groups, sa.func.count().label("jobs"), seconds.label("seconds"))
        with self._database.reading() as connection:
            rows = connection.execute(query.group_by(*groups))
            return tuple(JobTally(**row._mapping) for row in rows)

    def tally_of_owners(self) -> Sequence[tuple[str, State, int]]:
        of_runs = sa.select(JOBS.c.owner, JOBS.c.state, sa.func.count()).where(JOBS.c.kind == Kind.RUN)
        groups = of_runs.where(JOBS.c.state.in_(ACTIVE)).group_by(JOBS.c.owner, JOBS.c.state)
        with self._database.reading() as connection:
            return [tuple(row) for row in connection.execute(groups.order_by(JOBS.c.owner, JOBS.c.state))]

    def attempts_by_cause(self) -> Mapping[Cause, int]:
        """Attempts that did not succeed, since the store was made."""
        with self._database.reading() as connection:
            return {row.cause: row.attempts for row in connection.execute(sa.select(CAUSES))}
