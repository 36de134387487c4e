"""Queries about sweeps: where they stand, how far they are, their points and published files."""

from collections import defaultdict
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from datetime import datetime
from typing import Any

import sqlalchemy as sa

from service.records.jobs import (
    ACTIVE,
    RUN_STATES,
    STATE,
    MeasuredRun,
    Page,
    PointRow,
    PublishedRun,
    State,
    Stored,
    SweepState,
    SweepStatus,
)
from service.store.connection import Database, Part
from service.store.statements import (
    POINT_STATE,
    PUBLICATIONS,
    RUN_COLUMNS,
    Row,
    begins,
    literal,
    number_of,
    one_row,
    point_record,
    runs_of,
    stored_record,
)
from service.store.tables import ARTIFACTS, CONTROL, JOBS, POINTS, SWEEPS, enumeration

MOST_REMEMBERED = 10_000  # sweeps whose tallies are remembered

# A subquery of one row in place of EXISTS, which PostgreSQL would evaluate for all sweeps of the store.
_IS_BEGUN = (
    sa.select(sa.true())
    .where(POINTS.c.sweep_id == SWEEPS.c.id, JOBS.c.id == POINTS.c.run_id, JOBS.c.state != State.QUEUED)
    .limit(1)
    .correlate(SWEEPS)
    .scalar_subquery()
    .is_not(None)
)

# Where a sweep stands, from its publication and its runs.
SWEEP_STATE = sa.type_coerce(
    sa.case(
        (PUBLICATIONS.c.state == State.FAILED, literal(SweepState.FAILED)),
        (PUBLICATIONS.c.state == State.CANCELLED, literal(SweepState.CANCELLED)),
        (sa.and_(PUBLICATIONS.c.state == State.SUCCEEDED, SWEEPS.c.cancelled.is_(None)), literal(SweepState.SUCCEEDED)),
        (PUBLICATIONS.c.state == State.SUCCEEDED, literal(SweepState.CANCELLED)),
        (SWEEPS.c.cancelled.is_not(None), literal(SweepState.CANCELLING)),
        (PUBLICATIONS.c.state != State.WAITING, literal(SweepState.PUBLISHING)),
        (_IS_BEGUN, literal(SweepState.RUNNING)),
        else_=literal(SweepState.QUEUED),
    ),
    enumeration(SweepState),
)

# A sweep with its state, without its document, which may be long.
SWEEP_ROWS = sa.select(
    *(SWEEPS.c[name] for name in ("number", "id", "name", "title", "scenario", "planned", "new")),
    *(SWEEPS.c[name] for name in ("owner", "priority", "keep", "created", "cancelled")),
    SWEEP_STATE.label("state"),
    *(PUBLICATIONS.c.reason, PUBLICATIONS.c.finished),
    sa.select(CONTROL.c.cache_generation).scalar_subquery().label("cache_generation"),
).join_from(SWEEPS, PUBLICATIONS, PUBLICATIONS.c.sweep_id == SWEEPS.c.id)


# Names of the files that a sweep has published, separated by spaces; null: there are none.
FILE_NAMES = (
    sa.select(sa.func.aggregate_strings(ARTIFACTS.c.name, " "))
    .where(ARTIFACTS.c.job_id == PUBLICATIONS.c.id)
    .correlate(PUBLICATIONS)
    .scalar_subquery()
    .label("files")
)
SWEEPS_AND_FILES = SWEEP_ROWS.add_columns(FILE_NAMES)


@dataclass(frozen=True)
class SweepsWithFiles:
    """A page of sweeps with their files, and whether runs are begun."""

    sweeps: Page[SweepStatus]
    files: Mapping[str, Sequence[str]]  # names of the published ones, by sweep
    paused: datetime | None  # since when no run is begun
    blocked_reason: str | None  # why nothing is begun although there is work


class Tallies:
    """Tallies of sweeps; those without an unfinished point are remembered for one cache generation."""

    def __init__(self) -> None:
        self._remembered: dict[str, tuple[int, list[Row]]] = {}

    def of(self, connection: sa.Connection, rows: Sequence[Row]) -> Mapping[str, list[Row]]:
        """``tallies_of`` sweeps; their rows name the cache generation of the moment they were read."""
        tallies = {row.id: self._remembered_of(row) for row in rows}
        fresh = tallies_of(connection, [id for id, tally in tallies.items() if not tally])
        if len(self._remembered) + len(fresh) > MOST_REMEMBERED:
            self._remembered.clear()
        for row in rows:
            if row.id in fresh and all(part.point_state not in ACTIVE for part in fresh[row.id]):
                self._remembered[row.id] = row.cache_generation, fresh[row.id]
        return {**tallies, **fresh}

    def _remembered_of(self, row: Row) -> list[Row]:
        generation, tally = self._remembered.get(row.id, (row.cache_generation, []))
        return tally if generation == row.cache_generation else []


class SweepQueries(Part):
    """Each query is one read transaction, of a few statements whatever the size."""

    def __init__(self, database: Database):
        super().__init__(database)
        self._tallies = Tallies()

    def sweep(self, id: str) -> SweepStatus:
        """One sweep; raises NotFound."""
        with self._database.reading() as connection:
            row = one_row(connection, SWEEP_ROWS.where(SWEEPS.c.id == id), "sweep", id)
            return self._statuses(connection, [row])[0]

    def sweep_and_files(self, id: str) -> tuple[SweepStatus, Sequence[str]]:
        """One sweep, and the names of the files that it has published; raises NotFound."""
        query = SWEEPS_AND_FILES.where(SWEEPS.c.id == id)
        with self._database.reading() as connection:
            row = one_row(connection, query, "sweep", id)
            return self._statuses(connection, [row])[0], _names(row)

    def sweep_and_file(self, id: str, name: str) -> tuple[SweepStatus, Stored | None]:
        """One sweep, and the file of this name if it has published one; raises NotFound."""
        published = (ARTIFACTS.c.job_id == PUBLICATIONS.c.id) & (ARTIFACTS.c.name == name)
        query = SWEEP_ROWS.add_columns(ARTIFACTS.c.path, ARTIFACTS.c.size, ARTIFACTS.c.sha256)
        query = query.outerjoin(ARTIFACTS, published).where(SWEEPS.c.id == id)
        with self._database.reading() as connection:
            row = one_row(connection, query, "sweep", id)
            status = self._statuses(connection, [row])[0]
        file = None if row.path is None else Stored(name, row.path, row.size, row.sha256)
        return status, file

    def sweeps(
        self, *, state: SweepState | None = None, prefix: str = "", cursor: str | None = None, limit: int = 50
    ) -> Page[SweepStatus]:
        """Sweeps whose ids begin so, the youngest first: two statements, whatever the number of runs."""
        query = _youngest(SWEEP_ROWS, cursor, limit).where(begins(SWEEPS.c.id, prefix))
        if state is not None:
            query = query.where(SWEEP_STATE.in_([state]))
        with self._database.reading() as connection:
            return self._page(connection, connection.execute(query).all(), limit)

    def sweeps_with_files(self, *, cursor: str | None = None, limit: int = 50) -> SweepsWithFiles:
        """Sweeps with their files, the youngest first, and the state of the queue: two statements."""
        page = _youngest(SWEEPS_AND_FILES, cursor, limit).subquery()
        query = (
            sa.select(CONTROL.c.paused, CONTROL.c.blocked_reason, page)
            .select_from(CONTROL.outerjoin(page, sa.true()))  # the table has exactly one row
            .order_by(page.c.number.desc())
        )
        with self._database.reading() as connection:
            rows = connection.execute(query).all()
            of_sweeps = [row for row in rows if row.id is not None]
            sweeps = self._page(connection, of_sweeps, limit)
        files = {row.id: _names(row) for row in of_sweeps}
        return SweepsWithFiles(sweeps, files, rows[0].paused, rows[0].blocked_reason)

    def sweep_document(self, id: str) -> Mapping[str, Any]:
        """The document of a sweep, canonical; raises NotFound."""
        query = sa.select(SWEEPS.c.document).where(SWEEPS.c.id == id)
        with self._database.reading() as connection:
            return one_row(connection, query, "sweep", id).document

    def find_sweep(self, digest: str) -> SweepStatus | None:
        """The youngest sweep with this ``digest_of``: the same document for the same physics."""
        query = SWEEP_ROWS.where(SWEEPS.c.digest == digest).order_by(SWEEPS.c.number.desc())
        with self._database.reading() as connection:
            rows = connection.execute(query.limit(1)).all()
            return self._statuses(connection, rows)[0] if rows else None

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
            _check_sweep(connection, id)
            rows = connection.execute(query).all()
        items = tuple(point_record(row) for row in rows[:limit])
        return Page(items, str(items[-1].ordinal) if len(rows) > limit else None)

    def measured_runs(self, sweep_id: str) -> tuple[MeasuredRun, ...]:
        """The runs of a sweep, each once, with what they measured and their final state; raises NotFound."""
        kept = (ARTIFACTS.c.job_id == JOBS.c.id) & (ARTIFACTS.c.name == STATE)
        query = (
            sa.select(JOBS.c.id.label("run_id"), JOBS.c.scenario, JOBS.c.state, JOBS.c.summary)
            .add_columns(ARTIFACTS.c.name, ARTIFACTS.c.path, ARTIFACTS.c.size, ARTIFACTS.c.sha256)
            .join_from(JOBS, ARTIFACTS, kept, isouter=True)
            .where(JOBS.c.id.in_(runs_of(sweep_id)))
            .order_by(JOBS.c.id)
        )
        with self._database.reading() as connection:
            _check_sweep(connection, sweep_id)
            rows = connection.execute(query).all()
        return tuple(
            MeasuredRun(
                id=row.run_id,
                scenario=row.scenario,
                state=row.state,
                summary=row.summary,
                kept=None if row.path is None else stored_record(row),
            )
            for row in rows
        )

    def publication_inputs(self, sweep_id: str) -> tuple[Mapping[str, Any], tuple[PublishedRun, ...]]:
        """The document of a sweep, and how each of its points ended; raises NotFound."""
        document = sa.select(SWEEPS.c.document).where(SWEEPS.c.id == sweep_id)
        outcomes = (
            sa.select(POINTS.c.run_id, POINT_STATE.label("state"))
            .add_columns(JOBS.c.reason, JOBS.c.path, JOBS.c.sha256)
            .join_from(POINTS, JOBS, JOBS.c.id == POINTS.c.run_id)
            .where(POINTS.c.sweep_id == sweep_id)
            .order_by(POINTS.c.ordinal)
        )
        with self._database.reading() as connection:
            inputs = one_row(connection, document, "sweep", sweep_id).document
            rows = connection.execute(outcomes)
            return inputs, tuple(PublishedRun(**row._mapping) for row in rows)

    def artifacts(self, sweep_id: str) -> tuple[Stored, ...]:
        """The published files of a sweep; none before its publication."""
        query = sa.select(ARTIFACTS).join(JOBS, JOBS.c.id == ARTIFACTS.c.job_id)
        query = query.where(JOBS.c.sweep_id == sweep_id).order_by(ARTIFACTS.c.name)
        with self._database.reading() as connection:
            return tuple(stored_record(row) for row in connection.execute(query))

    def _page(self, connection: sa.Connection, rows: Sequence[Row], limit: int) -> Page[SweepStatus]:
        """The first ``limit`` sweeps, and the cursor of the next page."""
        items = self._statuses(connection, rows[:limit])
        return Page(items, str(rows[limit - 1].number) if len(rows) > limit else None)

    def _statuses(self, connection: sa.Connection, rows: Sequence[Row]) -> tuple[SweepStatus, ...]:
        tallies = self._tallies.of(connection, rows)
        return tuple(_status(row, tallies[row.id]) for row in rows)


def sweep_status(connection: sa.Connection, id: str) -> SweepStatus:
    """One sweep within a transaction; raises NotFound."""
    row = one_row(connection, SWEEP_ROWS.where(SWEEPS.c.id == id), "sweep", id)
    return _status(row, tallies_of(connection, [id])[id])


def tallies_of(connection: sa.Connection, ids: Sequence[str]) -> Mapping[str, list[Row]]:
    """For each sweep and state of its points: their number, cost, computed cost and measured seconds."""
    done = sa.func.coalesce(JOBS.c.fraction, 0.0) * JOBS.c.cost
    if not ids:
        return {}
    query = (
        sa.select(POINTS.c.sweep_id, POINT_STATE.label("point_state"))
        .add_columns(sa.func.count().label("points"), sa.func.sum(JOBS.c.cost).label("cost"))
        # A run that succeeded has a reason where it lost an answer.
        .add_columns(sa.func.count(JOBS.c.reason).label("reasons"))
        .add_columns(sa.func.sum(done).label("done"), sa.func.sum(JOBS.c.seconds).label("seconds"))
        .join_from(POINTS, JOBS, JOBS.c.id == POINTS.c.run_id)
        .where(POINTS.c.sweep_id.in_(ids))
        .group_by(POINTS.c.sweep_id, POINT_STATE)
    )
    tallies = defaultdict(list)
    for row in connection.execute(query):
        tallies[row.sweep_id].append(row)
    return tallies


def _status(row: Row, tally: Sequence[Row]) -> SweepStatus:
    """A sweep from its row and its tally."""
    counts = dict.fromkeys((state.value for state in RUN_STATES), 0)
    counts |= {part.point_state.value: part.points for part in tally}
    remaining = sum(part.cost - part.done for part in tally if part.point_state in ACTIVE)
    total, done = sum(part.cost for part in tally), sum(part.done for part in tally)
    rate = sum(part.seconds or 0.0 for part in tally) / done if done else None
    return SweepStatus(
        **{name: getattr(row, name) for name in _STORED},
        reused=row.planned - row.new,
        counts=counts,
        lost_answers=sum(part.reasons for part in tally if part.point_state is State.SUCCEEDED),
        progress=sum(map(_computed, tally)) / total if total else 1.0,
        eta_seconds=_eta(remaining, rate, side_by_side=counts[State.RUNNING]),
    )


_COUNTED = frozenset({"reused", "counts", "lost_answers", "progress", "eta_seconds"})
_STORED = frozenset(SweepStatus.__dataclass_fields__) - _COUNTED


def _computed(part: Row) -> float:
    """Computed cost of the points in a state; cancelled ones count nothing."""
    if part.point_state is State.CANCELLED:
        return 0.0
    return part.done if part.point_state in ACTIVE else part.cost


def _eta(remaining: float, rate: float | None, *, side_by_side: int) -> float | None:
    """Seconds to go for ``remaining`` estimated core seconds; ``rate``: measured seconds for each."""
    if not remaining:
        return 0.0
    return None if rate is None else remaining * rate / max(1, side_by_side)


def _check_sweep(connection: sa.Connection, id: str) -> None:
    """Raise NotFound for an unknown sweep."""
    one_row(connection, sa.select(SWEEPS.c.id).where(SWEEPS.c.id == id), "sweep", id)


def _youngest(query: sa.Select[Any], cursor: str | None, limit: int) -> sa.Select[Any]:
    """The youngest sweeps behind a cursor, and one more to know whether there is another page."""
    query = query.order_by(SWEEPS.c.number.desc()).limit(limit + 1)
    return query if cursor is None else query.where(SWEEPS.c.number < number_of(cursor))


def _names(row: Row) -> Sequence[str]:
    """The file names of a row with FILE_NAMES."""
    return tuple(sorted((row.files or "").split()))
