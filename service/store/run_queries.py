"""Queries about runs, and the events of runs and sweeps."""

from collections import defaultdict
from collections.abc import Iterable, Mapping
from typing import Any

import sqlalchemy as sa

from service.records.jobs import Event, Kind, NotFound, RunRow, State, Stored
from service.store.connection import Part
from service.store.statements import (
    RUN_COLUMNS,
    batches,
    begins,
    ended_by_accident,
    one_row,
    run_record,
    runs_of,
    stored_record,
)
from service.store.tables import ARTIFACTS, EVENTS, JOBS, POINTS


class RunQueries(Part):
    """Each query is one read transaction, of a few statements whatever the size."""

    def run(self, id: str) -> RunRow:
        """One run; raises NotFound."""
        query = sa.select(*RUN_COLUMNS).where(JOBS.c.id == id, JOBS.c.kind == Kind.RUN)
        with self._database.reading() as connection:
            return run_record(one_row(connection, query, "run", id))

    def runs(self, prefix: str, limit: int) -> tuple[RunRow, ...]:
        """Runs whose ids begin so, in the order of their ids."""
        query = sa.select(*RUN_COLUMNS).where(JOBS.c.kind == Kind.RUN, begins(JOBS.c.id, prefix))
        with self._database.reading() as connection:
            rows = connection.execute(query.order_by(JOBS.c.id).limit(limit))
            return tuple(run_record(row) for row in rows)

    def run_spec(self, id: str) -> Mapping[str, Any]:
        """A run as it is computed, complete (``Run.as_json``); raises NotFound."""
        query = sa.select(JOBS.c.spec).where(JOBS.c.id == id, JOBS.c.kind == Kind.RUN)
        with self._database.reading() as connection:
            return one_row(connection, query, "run", id).spec

    def known_runs(self, ids: Iterable[str]) -> set[str]:
        """Those of these runs that are finished or under way, so that a sweep of them computes nothing new."""
        query = sa.select(JOBS.c.id).where(sa.not_(ended_by_accident(verdicts=False)))
        with self._database.reading() as connection:
            return {id for batch in batches(ids) for id in connection.scalars(query.where(JOBS.c.id.in_(batch)))}

    def under_way(self) -> tuple[tuple[RunRow, tuple[str, ...]], ...]:
        """Runs that are running or being stopped, each with the sweeps that wait for it."""
        held = sa.and_(JOBS.c.kind == Kind.RUN, JOBS.c.state.in_([State.RUNNING, State.CANCELLING]))
        waiting = (
            sa.select(POINTS.c.run_id, POINTS.c.sweep_id)
            .join_from(POINTS, JOBS, JOBS.c.id == POINTS.c.run_id)
            .where(held, POINTS.c.detached.is_(False))
            .distinct()
            .order_by(POINTS.c.sweep_id)
        )
        sweeps = defaultdict(list)
        with self._database.reading() as connection:
            rows = connection.execute(sa.select(*RUN_COLUMNS).where(held))
            runs = [run_record(row) for row in rows]
            for row in connection.execute(waiting):
                sweeps[row.run_id].append(row.sweep_id)
        return tuple((run, tuple(sweeps[run.id])) for run in runs)

    # --- files -----------------------------------------------------------------------------------

    def run_file(self, id: str, name: str) -> Stored:
        """A file of a run; raises NotFound, also when it was not kept."""
        for file in self.run_files(id):
            if file.name == name:
                return file
        raise NotFound("file", f"{id}/{name}")

    def run_files(self, id: str) -> tuple[Stored, ...]:
        """The files of a run that has ended; raises NotFound for an unknown run."""
        query = (
            sa.select(ARTIFACTS)
            .join_from(JOBS, ARTIFACTS, ARTIFACTS.c.job_id == JOBS.c.id, isouter=True)
            .where(JOBS.c.id == id, JOBS.c.kind == Kind.RUN)
            .order_by(ARTIFACTS.c.name)
        )
        with self._database.reading() as connection:
            rows = connection.execute(query).all()
        if not rows:
            raise NotFound("run", id)
        return tuple(stored_record(row) for row in rows if row.name is not None)

    # --- events ----------------------------------------------------------------------------------

    def events(self, sweep_id: str, *, after: int = 0, limit: int = 1000) -> tuple[Event, ...]:
        """Events of a sweep and its runs since it was accepted, oldest first."""
        of_sweep = EVENTS.c.sweep_id == sweep_id
        first = sa.select(sa.func.min(EVENTS.c.number)).where(of_sweep).scalar_subquery()
        which = sa.or_(of_sweep, EVENTS.c.job_id.in_(runs_of(sweep_id)))
        return self._events(sa.and_(which, EVENTS.c.number >= first), after, limit)

    def run_events(self, run_id: str, *, after: int = 0, limit: int = 1000) -> tuple[Event, ...]:
        """Events of a run, oldest first."""
        return self._events(EVENTS.c.job_id == run_id, after, limit)

    def all_events(self, *, after: int = 0, limit: int = 1000) -> tuple[Event, ...]:
        """Every event, oldest first."""
        return self._events(sa.true(), after, limit)

    def last_event(self) -> int:
        """Number of the youngest event; 0: nothing has happened yet."""
        query = sa.select(sa.func.coalesce(sa.func.max(EVENTS.c.number), 0))
        with self._database.reading() as connection:
            return connection.execute(query).scalar_one()

    def _events(self, which: sa.ColumnElement[bool], after: int, limit: int) -> tuple[Event, ...]:
        query = sa.select(EVENTS).where(EVENTS.c.number > after, which)
        with self._database.reading() as connection:
            rows = connection.execute(query.order_by(EVENTS.c.number).limit(limit))
            return tuple(Event(**row._mapping) for row in rows)
