"""The queue as a whole: paused or not, jobs by state, its leader, why nothing begins."""

import math
import threading
import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from datetime import datetime

import sqlalchemy as sa

from service.records.jobs import Cause, Kind, QueueHead, QueueRow, RunTally, State
from service.store import leadership
from service.store.connection import Database
from service.store.events import log_event
from service.store.tables import CAUSES, CONTROL, EVENTS, IS_ACTIVE, IS_QUEUED, JOBS, RESULTS, TERMS, literal, now

# Counts of jobs are reused for so many seconds, while no event is logged: any client may ask for them, and with 120 000
# jobs they take 10 ms (2026-11).
REUSE_SECONDS = 0.5

_IS_RUN = JOBS.c.kind == literal(Kind.RUN)


@dataclass(frozen=True)
class _Counts:
    """Jobs by kind and state, and since when the oldest queued run waits, after an event."""

    event: int
    time: float  # monotonic, of the end of counting
    jobs: Mapping[tuple[Kind, State], int]
    oldest: datetime | None


class Queue:
    """Each query is one read transaction, of a few statements whatever the size; each command is one transaction."""

    def __init__(self, database: Database):
        self._database = database
        self._counts = _Counts(-1, -math.inf, {}, None)
        self._counting = threading.Lock()

    def pause(self) -> QueueRow:
        """Begin no more runs; those under way go on, and finished sweeps are published."""
        return self._set_paused(now(), CONTROL.c.paused.is_(None), "paused")

    def resume(self) -> QueueRow:
        """Begin runs again."""
        return self._set_paused(None, CONTROL.c.paused.is_not(None), "resumed")

    def _set_paused(self, paused: datetime | None, is_other: sa.ColumnElement[bool], event: str) -> QueueRow:
        with self._database.commanding() as connection:
            if connection.execute(CONTROL.update().where(is_other).values(paused=paused)).rowcount:
                log_event(connection, now(), event)
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
        with self._database.reading() as connection:
            head, event = self._head(connection)
            counts = self._counted(connection, event)
        return QueueRow(**vars(head), jobs=counts.jobs, oldest_queued=counts.oldest)

    def head(self) -> QueueHead:
        """The queue at this moment without its jobs, at the same cost however many there are."""
        with self._database.reading() as connection:
            return self._head(connection)[0]

    def _head(self, connection: sa.Connection) -> tuple[QueueHead, int]:
        """The queue without its jobs, and the number of the last event."""
        youngest = sa.select(sa.func.coalesce(sa.func.max(TERMS.c.term), 0)).scalar_subquery()
        event = sa.select(sa.func.coalesce(sa.func.max(EVENTS.c.number), 0)).scalar_subquery()
        leader = leadership.leader(self._database).scalar_subquery()
        kept = CONTROL.c.clock["paused"].as_string()
        query = sa.select(CONTROL.c.paused, CONTROL.c.blocked_reason, kept, youngest.label("term"))
        *head, event = connection.execute(query.add_columns(leader.label("leader"), event)).one()
        return QueueHead(*head), event

    def _counted(self, connection: sa.Connection, event: int) -> _Counts:
        """The counts after an event; one thread counts at a time."""
        with self._counting:
            known = self._counts
            if known.event < event or time.monotonic() - known.time > REUSE_SECONDS:
                groups = (JOBS.c.kind, JOBS.c.state)
                oldest = sa.select(sa.func.min(JOBS.c.queued)).where(IS_ACTIVE, IS_QUEUED, _IS_RUN).correlate(None)
                counts = sa.select(*groups, sa.func.count().label("jobs"), oldest.scalar_subquery().label("oldest"))
                rows = connection.execute(counts.group_by(*groups)).all()
                jobs = {(Kind(row.kind), State(row.state)): row.jobs for row in rows}
                first = rows[0].oldest if rows else None
                known = self._counts = _Counts(event, time.monotonic(), jobs, first)
            return known

    def tally(self) -> tuple[RunTally, ...]:
        """Attempts that succeeded since the store was made, by their measured seconds."""
        sums = (sa.func.sum(RESULTS.c[name]).label(name) for name in ("attempts", "seconds"))
        query = sa.select(RESULTS.c.bucket, *sums).where(RESULTS.c.succeeded).group_by(RESULTS.c.bucket)
        return tuple(RunTally(row.bucket, int(row.attempts), row.seconds) for row in self._database.rows(query))

    def tally_of_owners(self) -> Sequence[tuple[str, State, int]]:
        """The number of runs that have not ended, by owner and state."""
        groups = (JOBS.c.owner, JOBS.c.state)
        query = sa.select(*groups, sa.func.count()).where(IS_ACTIVE, _IS_RUN).group_by(*groups).order_by(*groups)
        return [tuple(row) for row in self._database.rows(query)]

    def attempts_by_cause(self) -> Mapping[Cause, int]:
        """Attempts that did not succeed, since the store was made."""
        return {row.cause: row.attempts for row in self._database.rows(sa.select(CAUSES))}
