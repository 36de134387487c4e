"""Queries about the queue as a whole: jobs by state, its leader, measured costs."""

from collections.abc import Mapping, Sequence

import sqlalchemy as sa

from service.records.jobs import TERMINAL, Cause, JobTally, Kind, QueueRow, State
from service.store import leadership
from service.store.connection import Part
from service.store.tables import CAUSES, CONTROL, JOBS, TERMS


class QueueQueries(Part):
    """Each query is one read transaction, of a few statements whatever the size."""

    def queue(self) -> QueueRow:
        """The queue at this moment."""
        oldest = sa.select(sa.func.min(JOBS.c.queued)).where(
            JOBS.c.state == State.QUEUED, JOBS.c.kind == Kind.RUN
        )
        youngest = sa.select(sa.func.coalesce(sa.func.max(TERMS.c.term), 0))
        jobs = sa.func.count().label("jobs")
        states = sa.select(JOBS.c.state, jobs).group_by(JOBS.c.state).subquery()
        query = sa.select(
            *(CONTROL.c.paused, CONTROL.c.blocked_reason, states),
            *(oldest.scalar_subquery().label("oldest"), youngest.scalar_subquery().label("term")),
        ).select_from(
            CONTROL.outerjoin(states, sa.true())  # the one row of ``control`` is always there
        )
        with self._database.reading() as connection:
            rows = connection.execute(query).all()
            return QueueRow(
                paused=rows[0].paused,
                blocked_reason=rows[0].blocked_reason,
                states={row.state: row.jobs for row in rows if row.state is not None},
                oldest_queued=rows[0].oldest,
                term=rows[0].term,
                leader=leadership.leader(self._database, connection),
            )

    def tally(self, edges: Sequence[float]) -> tuple[JobTally, ...]:
        """Jobs by kind, state and place of their measured seconds among ``edges``."""
        bucket = sum(
            (sa.case((JOBS.c.seconds > edge, 1), else_=0) for edge in edges), sa.literal(0)
        )
        measured = sa.case((JOBS.c.seconds.is_(None), sa.null()), else_=bucket)
        jobs = sa.select(
            JOBS.c.kind, JOBS.c.state, JOBS.c.seconds, measured.label("bucket")
        ).subquery()
        groups = (jobs.c.kind, jobs.c.state, jobs.c.bucket)
        seconds = sa.func.coalesce(sa.func.sum(jobs.c.seconds), 0.0)
        query = sa.select(*groups, sa.func.count().label("jobs"), seconds.label("seconds"))
        with self._database.reading() as connection:
            rows = connection.execute(query.group_by(*groups))
            return tuple(JobTally(**row._mapping) for row in rows)

    def attempts_by_cause(self) -> Mapping[Cause, int]:
        """Attempts that did not succeed, since the store was made."""
        with self._database.reading() as connection:
            attempts = {row.cause: row.attempts for row in connection.execute(sa.select(CAUSES))}
        return {cause: attempts.get(cause, 0) for cause in Cause}

    def measured_rate(self, scenario: str | None = None) -> float | None:
        """Measured seconds for each estimated core second, over all results; None without results."""
        query = sa.select(sa.func.sum(JOBS.c.seconds), sa.func.sum(JOBS.c.cost)).where(
            JOBS.c.kind == Kind.RUN, JOBS.c.state.in_(TERMINAL), JOBS.c.path.is_not(None)
        )
        # Unknown after a failed attempt to add a file.
        query = query.where(JOBS.c.seconds.is_not(None))
        if scenario is not None:
            query = query.where(JOBS.c.scenario == scenario)
        with self._database.reading() as connection:
            seconds, cost = connection.execute(query).one()
        return seconds / cost if cost else None
