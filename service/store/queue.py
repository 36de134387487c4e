"""The queue as a whole: paused or not, jobs by state, its leader, why nothing begins."""

from collections.abc import Mapping, Sequence
from datetime import datetime

import sqlalchemy as sa

from service.records.jobs import UNSUCCESSFUL, Cause, Kind, QueueHead, QueueRow, RunTally, State
from service.store import leadership
from service.store.connection import Repository
from service.store.events import log_event
from service.store.tables import CAUSES, CONTROL, IS_ACTIVE, IS_QUEUED, JOBS, RESULTS, TERMS, literal, now

_IS_RUN = JOBS.c.kind == literal(Kind.RUN)


class Queue(Repository):
    """The state of the queue, and the commands that pause it or note why it stands."""

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
        """The queue at this moment; what succeeded costs nothing, however much it is."""
        groups = (JOBS.c.kind, JOBS.c.state)
        oldest = sa.select(sa.func.min(JOBS.c.queued)).where(IS_ACTIVE, IS_QUEUED, _IS_RUN).correlate(None)
        counts = sa.select(*groups, sa.func.count().label("jobs"), oldest.scalar_subquery().label("oldest"))
        counts = counts.where(JOBS.c.state.in_([literal(state) for state in UNSUCCESSFUL])).group_by(*groups)
        with self._database.reading() as connection:
            head, rows = self._head(connection), connection.execute(counts).all()
        jobs = {(Kind(row.kind), State(row.state)): row.jobs for row in rows}
        return QueueRow(**vars(head), jobs=jobs, oldest_queued=rows[0].oldest if rows else None)

    def head(self) -> QueueHead:
        """The queue at this moment without its jobs, at the same cost however many there are."""
        with self._database.reading() as connection:
            return self._head(connection)

    def _head(self, connection: sa.Connection) -> QueueHead:
        youngest = sa.select(sa.func.coalesce(sa.func.max(TERMS.c.term), 0)).scalar_subquery()
        leader = leadership.leader(self._database).scalar_subquery()
        kept = CONTROL.c.clock["paused"].as_string()
        query = sa.select(CONTROL.c.paused, CONTROL.c.blocked_reason, kept, youngest.label("term"))
        return QueueHead(*connection.execute(query.add_columns(leader.label("leader"))).one())

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
