"""What people ask of sweeps and runs: how far they are, their files, what happened to them."""

from collections import defaultdict
from collections.abc import Iterable, Mapping, Sequence, Set
from dataclasses import dataclass
from datetime import datetime
from typing import Any

import sqlalchemy as sa

from service.records.jobs import (
    STATE,
    Event,
    Kind,
    MeasuredRun,
    NotFound,
    Page,
    PointRow,
    RunRow,
    State,
    Stored,
    SweepRow,
    SweepState,
)
from service.store import queries
from service.store.connection import Database, Part
from service.store.queries import (
    POINT_STATE,
    PUBLICATIONS,
    RUN_COLUMNS,
    SWEEP_ROWS,
    SWEEP_STATE,
    number_of,
    one_row,
)
from service.store.rows import Row, measured_record, point_record, run_record, stored_record
from service.store.tables import ARTIFACTS, CONTROL, EVENTS, JOBS, POINTS, SWEEPS
from service.store.tallies import Tallies

# Names of the files that a sweep has published, one after the other; null: there are none.
FILE_NAMES = (
    sa.select(sa.func.aggregate_strings(ARTIFACTS.c.name, " "))
    .where(ARTIFACTS.c.job_id == PUBLICATIONS.c.id)
    .correlate(PUBLICATIONS)
    .scalar_subquery()
    .label("files")
)
SWEEPS_AND_FILES = SWEEP_ROWS.add_columns(FILE_NAMES)


@dataclass(frozen=True)
class SweepsPage:
    """A page of sweeps as people see it: with their files, and whether runs are begun."""

    sweeps: Page[SweepRow]
    files: Mapping[str, Sequence[str]]  # names of those that are published, by sweep
    paused: datetime | None  # since when no run is begun
    hindrance: str | None  # why nothing is begun although there is work


class Questions(Part):
    """Each question is one read transaction, of a few statements whatever the size."""

    def __init__(self, database: Database):
        super().__init__(database)
        self._tallies = Tallies()

    # --- sweeps ----------------------------------------------------------------------------------

    def sweep(self, id: str) -> SweepRow:
        """One sweep; raises NotFound."""
        with self._database.reading() as connection:
            row = one_row(connection, SWEEP_ROWS.where(SWEEPS.c.id == id), "sweep", id)
            return self._sweep_rows(connection, [row])[0]

    def sweep_and_files(self, id: str) -> tuple[SweepRow, Sequence[str]]:
        """One sweep, and the names of the files that it has published; raises NotFound."""
        query = SWEEPS_AND_FILES.where(SWEEPS.c.id == id)
        with self._database.reading() as connection:
            row = one_row(connection, query, "sweep", id)
            return self._sweep_rows(connection, [row])[0], _names(row)

    def sweep_and_file(self, id: str, name: str) -> tuple[SweepRow, Stored | None]:
        """One sweep, and the file of this name if it has published one; raises NotFound."""
        published = (ARTIFACTS.c.job_id == PUBLICATIONS.c.id) & (ARTIFACTS.c.name == name)
        query = SWEEP_ROWS.add_columns(ARTIFACTS.c.path, ARTIFACTS.c.size, ARTIFACTS.c.sha256)
        query = query.outerjoin(ARTIFACTS, published).where(SWEEPS.c.id == id)
        with self._database.reading() as connection:
            row = one_row(connection, query, "sweep", id)
            sweep = self._sweep_rows(connection, [row])[0]
        file = None if row.path is None else Stored(name, row.path, row.size, row.sha256)
        return sweep, file

    def sweeps(
        self, *, state: SweepState | None = None, cursor: str | None = None, limit: int = 50
    ) -> Page[SweepRow]:
        """Sweeps, the youngest first: two statements, whatever the number of runs."""
        query = _youngest(SWEEP_ROWS, cursor, limit)
        if state is not None:
            query = query.where(SWEEP_STATE.in_([state]))
        with self._database.reading() as connection:
            return self._page(connection, connection.execute(query).all(), limit)

    def front(self, *, cursor: str | None = None, limit: int = 50) -> SweepsPage:
        """Sweeps with their files, the youngest first, and what the queue does: two statements."""
        page = _youngest(SWEEPS_AND_FILES, cursor, limit).subquery()
        query = (
            sa.select(CONTROL.c.paused, CONTROL.c.hindrance, page)
            .select_from(CONTROL.outerjoin(page, sa.true()))  # whose one row is always there
            .order_by(page.c.number.desc())
        )
        with self._database.reading() as connection:
            rows = connection.execute(query).all()
            found = [row for row in rows if row.id is not None]
            sweeps = self._page(connection, found, limit)
        files = {row.id: _names(row) for row in found}
        return SweepsPage(sweeps, files, rows[0].paused, rows[0].hindrance)

    def sweep_document(self, id: str) -> Mapping[str, Any]:
        """The document of a sweep, canonical; raises NotFound."""
        query = sa.select(SWEEPS.c.document).where(SWEEPS.c.id == id)
        with self._database.reading() as connection:
            return one_row(connection, query, "sweep", id).document

    def find_sweep(self, digest: str) -> SweepRow | None:
        """The youngest sweep with this ``digest_of``: the same question, asked before."""
        query = SWEEP_ROWS.where(SWEEPS.c.digest == digest).order_by(SWEEPS.c.number.desc())
        with self._database.reading() as connection:
            rows = connection.execute(query.limit(1)).all()
            return self._sweep_rows(connection, rows)[0] if rows else None

    def _page(self, connection: sa.Connection, rows: Sequence[Row], limit: int) -> Page[SweepRow]:
        """The first ``limit`` sweeps, and the way to the rest."""
        items = self._sweep_rows(connection, rows[:limit])
        return Page(items, str(rows[limit - 1].number) if len(rows) > limit else None)

    def _sweep_rows(self, connection: sa.Connection, rows: Sequence[Row]) -> tuple[SweepRow, ...]:
        return queries.sweep_rows(connection, rows, self._tallies.of(connection, rows))

    def sweep_runs(
        self, id: str, *, state: State | None = None, cursor: str | None = None, limit: int = 100
    ) -> Page[PointRow]:
        """Points of a sweep in its own order, each with its run; raises NotFound."""
        query = (
            sa.select(*RUN_COLUMNS, POINTS, POINT_STATE.label("point_state"))
            .join_from(POINTS, JOBS, JOBS.c.id == POINTS.c.run_id)
            .where(POINTS.c.sweep_id == id)
            .order_by(POINTS.c.ordinal)
            .limit(limit + 1)
        )
        if state is not None:
            query = query.where(POINT_STATE.in_([state]))
        if cursor is not None:
            query = query.where(POINTS.c.ordinal > number_of(cursor))
        with self._database.reading() as connection:
            one_row(connection, sa.select(SWEEPS.c.id).where(SWEEPS.c.id == id), "sweep", id)
            rows = connection.execute(query).all()
        items = tuple(point_record(row) for row in rows[:limit])
        return Page(items, str(items[-1].ordinal) if len(rows) > limit else None)

    # --- runs ------------------------------------------------------------------------------------

    def run(self, id: str) -> RunRow:
        """One run; raises NotFound."""
        query = sa.select(*RUN_COLUMNS).where(JOBS.c.id == id, JOBS.c.kind == Kind.RUN)
        with self._database.reading() as connection:
            return run_record(one_row(connection, query, "run", id))

    def run_spec(self, id: str) -> Mapping[str, Any]:
        """The question of a run, complete (``Run.as_json``); raises NotFound."""
        query = sa.select(JOBS.c.spec).where(JOBS.c.id == id, JOBS.c.kind == Kind.RUN)
        with self._database.reading() as connection:
            return one_row(connection, query, "run", id).spec

    def known_runs(self, ids: Iterable[str]) -> set[str]:
        """Which of these runs are finished or under way, so that asking computes nothing new."""
        known = sa.not_(queries.ended_by_accident(verdicts=False))
        found = sa.select(JOBS.c.id).where(known)
        with self._database.reading() as connection:
            return {
                id
                for batch in queries.batches(ids)
                for id in connection.scalars(found.where(JOBS.c.id.in_(batch)))
            }

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
            runs = [
                run_record(row) for row in connection.execute(sa.select(*RUN_COLUMNS).where(held))
            ]
            for row in connection.execute(waiting):
                sweeps[row.run_id].append(row.sweep_id)
        return tuple((run, tuple(sweeps[run.id])) for run in runs)

    def measured_runs(self, sweep_id: str) -> tuple[MeasuredRun, ...]:
        """The runs of a sweep, each once, with what they measured and their final state; raises NotFound."""
        kept = (ARTIFACTS.c.job_id == JOBS.c.id) & (ARTIFACTS.c.name == STATE)
        own = sa.select(POINTS.c.run_id).where(POINTS.c.sweep_id == sweep_id)
        query = (
            sa.select(JOBS.c.id.label("run_id"), JOBS.c.scenario, JOBS.c.state, JOBS.c.summary)
            .add_columns(ARTIFACTS.c.name, ARTIFACTS.c.path, ARTIFACTS.c.size, ARTIFACTS.c.sha256)
            .join_from(JOBS, ARTIFACTS, kept, isouter=True)
            .where(JOBS.c.id.in_(own))
            .order_by(JOBS.c.id)
        )
        known = sa.select(SWEEPS.c.id).where(SWEEPS.c.id == sweep_id)
        with self._database.reading() as connection:
            one_row(connection, known, "sweep", sweep_id)
            return tuple(measured_record(row) for row in connection.execute(query))

    # --- files -----------------------------------------------------------------------------------

    def artifacts(self, sweep_id: str) -> tuple[Stored, ...]:
        """The published files of a sweep; none before its publication."""
        with self._database.reading() as connection:
            return _files(connection, JOBS.c.sweep_id == sweep_id)

    def run_file(self, id: str, name: str) -> Stored:
        """A file of a run; raises NotFound, also when it was not kept."""
        for file in self.run_files(id):
            if file.name == name:
                return file
        raise NotFound("file", f"{id}/{name}")

    def run_files(self, id: str) -> tuple[Stored, ...]:
        """The files of a run that has ended; raises NotFound if there is no such run."""
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

    # --- what happened ---------------------------------------------------------------------------

    def events(self, sweep_id: str, *, after: int = 0, limit: int = 1000) -> tuple[Event, ...]:
        """What happened to a sweep and its runs since it was accepted, oldest first."""
        of_sweep = EVENTS.c.sweep_id == sweep_id
        first = sa.select(sa.func.min(EVENTS.c.number)).where(of_sweep).scalar_subquery()
        own = sa.select(POINTS.c.run_id).where(POINTS.c.sweep_id == sweep_id)
        mine = sa.or_(of_sweep, EVENTS.c.job_id.in_(own))
        return self._events(sa.and_(mine, EVENTS.c.number >= first), after, limit)

    def run_events(self, run_id: str, *, after: int = 0, limit: int = 1000) -> tuple[Event, ...]:
        """What happened to a run, oldest first."""
        return self._events(EVENTS.c.job_id == run_id, after, limit)

    def all_events(self, *, after: int = 0, limit: int = 1000) -> tuple[Event, ...]:
        """What happened to anything, oldest first."""
        return self._events(sa.true(), after, limit)

    def news(self, *, after: int, limit: int) -> tuple[tuple[Event, Set[str]], ...]:
        """What happened to anything, oldest first, each with the sweeps that have its run."""
        query = sa.select(EVENTS).where(EVENTS.c.number > after).order_by(EVENTS.c.number)
        using = sa.select(POINTS.c.run_id, POINTS.c.sweep_id).distinct()
        sweeps = defaultdict(set)
        with self._database.reading() as connection:
            rows = connection.execute(query.limit(limit))
            events = [Event(**row._mapping) for row in rows]
            jobs = {event.job_id for event in events if event.job_id is not None}
            for batch in queries.batches(sorted(jobs)):
                for row in connection.execute(using.where(POINTS.c.run_id.in_(batch))):
                    sweeps[row.run_id].add(row.sweep_id)
        return tuple((event, sweeps.get(event.job_id or "", frozenset())) for event in events)

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


def _youngest(query: sa.Select[Any], cursor: str | None, limit: int) -> sa.Select[Any]:
    """The youngest sweeps behind a cursor, and one more to know whether there is another page."""
    query = query.order_by(SWEEPS.c.number.desc()).limit(limit + 1)
    return query if cursor is None else query.where(SWEEPS.c.number < number_of(cursor))


def _names(row: Row) -> Sequence[str]:
    """The files of a row that has FILE_NAMES."""
    return tuple(sorted((row.files or "").split()))


def _files(connection: sa.Connection, job: sa.ColumnElement[bool]) -> tuple[Stored, ...]:
    query = sa.select(ARTIFACTS).join(JOBS, JOBS.c.id == ARTIFACTS.c.job_id).where(job)
    rows = connection.execute(query.order_by(ARTIFACTS.c.name))
    return tuple(stored_record(row) for row in rows)
