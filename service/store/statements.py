"""Expressions, statements and records of rows that several parts of the store share."""

from collections.abc import Iterable
from datetime import UTC, datetime
from typing import Any

import sqlalchemy as sa
from sqlalchemy.dialects import postgresql, sqlite

from service.records.jobs import ACTIVE, Cause, Keep, Kind, Lease, NotFound, PointRow, RunRow, State, Stored
from service.store.tables import ARTIFACTS, CAUSES, CONTROL, EVENTS, JOBS, POINTS, enumeration
from studies.values.errors import Finding, InvalidInput

Row = sa.Row[*tuple[Any, ...]]  # a row of whatever columns

PUBLISH_PRIORITY = -1000  # a finished sweep is published before more runs begin
ROWS_PER_STATEMENT = 1000  # SQLite takes 32 766 parameters in a statement

# --- expressions -------------------------------------------------------------------------------

RUN_COLUMNS = [JOBS.c[field] for field in RunRow.__dataclass_fields__]
LEASE_COLUMNS = [JOBS.c[field] for field in Lease.__dataclass_fields__]
PUBLICATIONS = JOBS.alias("publications")


def literal(text: str) -> sa.ColumnClause[str]:
    """A text without a parameter: PostgreSQL groups by no expression that has parameters."""
    return sa.literal_column(f"'{text}'")


# Where a point stands for its sweep: cancelled once the sweep no longer waits for the run.
POINT_STATE = sa.type_coerce(
    sa.case((POINTS.c.detached, literal(State.CANCELLED)), else_=sa.type_coerce(JOBS.c.state, sa.Text)),
    enumeration(State),
)


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


def runs_of(sweep_id: str) -> sa.Select[tuple[str]]:
    """Ids of the runs of a sweep."""
    return sa.select(POINTS.c.run_id).where(POINTS.c.sweep_id == sweep_id)


def ended_by_accident(*, verdicts: bool) -> sa.ColumnElement[bool]:
    """The run ended without a result, so that another try is worth while."""
    accident = sa.and_(JOBS.c.state == State.FAILED, JOBS.c.cause != Cause.VERDICT)
    ended = accident if not verdicts else JOBS.c.state == State.FAILED
    return sa.or_(JOBS.c.state == State.CANCELLED, ended)


# Also true of a run that is computed again; never of a publication.
HAS_RESULT = JOBS.c.path.is_not(None)


def given_up(otherwise: State) -> sa.Case[str]:
    """State of a job that ends without a new result: that of its earlier result, else ``otherwise``."""
    return sa.case(
        (sa.not_(HAS_RESULT), literal(otherwise)),
        (JOBS.c.cause.is_(None), literal(State.SUCCEEDED)),
        else_=literal(State.FAILED),
    )


def retention_if(is_given_up: sa.ColumnElement[bool]) -> sa.Case[Any]:
    """Retention of a job: that of the files that are there, once it goes back to its earlier result."""
    goes_back = sa.and_(is_given_up, HAS_RESULT)
    return sa.case((goes_back, sa.literal(Keep.NUMBERS, JOBS.c.keep.type)), else_=JOBS.c.keep)


def unless_result(**values: Any) -> dict[str, sa.ColumnElement[Any]]:
    """Values for the row of a job without a result; the row of one with a result keeps its own."""
    return {
        name: sa.case((HAS_RESULT, JOBS.c[name]), else_=sa.literal(value, JOBS.c[name].type))
        for name, value in values.items()
    }


_RUNS = JOBS.alias("runs")

# The points that a publication waits for.
_UNFINISHED = (
    sa.select(POINTS)
    .join_from(POINTS, _RUNS, _RUNS.c.id == POINTS.c.run_id)
    .where(POINTS.c.sweep_id == JOBS.c.sweep_id, POINTS.c.detached.is_(False))
    .where(_RUNS.c.state.in_(ACTIVE))
    .correlate(JOBS)
)

# --- statements --------------------------------------------------------------------------------


def insert_into(connection: sa.Connection, table: sa.Table) -> sqlite.Insert | postgresql.Insert:
    """An insert that can say what to do with rows that are there already."""
    dialect = postgresql if connection.dialect.name == "postgresql" else sqlite
    return dialect.insert(table)


def invalidate_tallies(connection: sa.Connection, points: int) -> None:
    """Note that so many points that had ended are unfinished again: see ``sweep_queries.Tallies``."""
    generation = CONTROL.c.cache_generation
    connection.execute(CONTROL.update().values(cache_generation=generation + points))


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


def release_publications(connection: sa.Connection, moment: datetime, which: sa.ColumnElement[bool]) -> None:
    """Queue those waiting publications, among ``which``, whose sweeps wait for no run any more.

    The row of each names a point that was unfinished at the last check. While that point still is,
    nothing has to be done; else all points are searched for another. So the end of a run costs the
    same whatever the length of its sweeps.
    """
    waiting = (which, JOBS.c.state == State.WAITING)
    another = (
        _UNFINISHED.with_only_columns(POINTS.c.ordinal)
        .order_by(POINTS.c.ordinal.desc())  # runs are leased in order: the last is unfinished long
        .limit(1)
        .scalar_subquery()
    )
    is_unfinished = _UNFINISHED.where(POINTS.c.ordinal == JOBS.c.unfinished_point).exists()
    check = JOBS.update().where(*waiting, sa.not_(is_unfinished)).values(unfinished_point=another)
    checked = connection.execute(check.returning(JOBS.c.id, JOBS.c.unfinished_point)).all()
    done = [row.id for row in checked if row.unfinished_point is None]
    if done:
        queue = JOBS.update().where(JOBS.c.id.in_(done))
        connection.execute(queue.values(state=State.QUEUED, queued=moment))


def hold_publications(connection: sa.Connection, which: sa.ColumnElement[bool]) -> None:
    """Let those queued publications, among ``which``, wait again whose runs are no longer all done."""
    wait = JOBS.update().where(which, JOBS.c.kind == Kind.PUBLISH, JOBS.c.state == State.QUEUED)
    wait = wait.where(_UNFINISHED.exists())
    connection.execute(wait.values(state=State.WAITING, unfinished_point=sa.null()))


def log_event(
    connection: sa.Connection,
    moment: datetime,
    kind: str,
    *,
    sweep_id: str | None = None,
    job_id: str | None = None,
    **body: Any,
) -> None:
    """Append an event, in the transaction that makes it true."""
    connection.execute(EVENTS.insert().values(time=moment, kind=kind, sweep_id=sweep_id, job_id=job_id, body=body))


def log_attempts(connection: sa.Connection, moment: datetime, kind: str, *leases: Lease, **body: Any) -> None:
    """Append an event of each of these attempts."""
    rows = [
        {
            "time": moment,
            "kind": kind,
            "sweep_id": lease.sweep_id,
            "job_id": lease.id,
            "body": {"attempt": lease.attempt, **body},
        }
        for lease in leases
    ]
    connection.execute(EVENTS.insert(), rows)


def begins(column: sa.ColumnElement[str], prefix: str) -> sa.ColumnElement[bool]:
    """The id, of hexadecimal digits, begins so; by its index."""
    return sa.and_(column >= prefix, column < prefix + "g")


def one_row(connection: sa.Connection, query: sa.Select[Any], kind: str, id: str) -> Row:
    """The single row of a query; raises NotFound."""
    row = connection.execute(query).first()
    if row is None:
        raise NotFound(kind, id)
    return row


# --- records -----------------------------------------------------------------------------------


def lease_record(row: Row) -> Lease:
    """A lease from a row with LEASE_COLUMNS."""
    values = {field: row._mapping[JOBS.c[field]] for field in Lease.__dataclass_fields__}
    return Lease(**{**values, "spec": values["spec"] or {}})


def run_record(row: Row) -> RunRow:
    """A run from a row with RUN_COLUMNS."""
    return RunRow(**{field: row._mapping[JOBS.c[field]] for field in RunRow.__dataclass_fields__})


def point_record(row: Row) -> PointRow:
    """A point from a row with the columns of POINTS, RUN_COLUMNS and ``point_state``."""
    return PointRow(
        ordinal=row._mapping[POINTS.c.ordinal],
        index=tuple(row.axis_index),
        coordinates=row.coordinates,
        state=row.point_state,
        run=run_record(row),
    )


def stored_record(row: Row) -> Stored:
    """A file from a row of ARTIFACTS."""
    return Stored(name=row.name, path=row.path, size=row.size, sha256=row.sha256)


# --- moments, cursors, batches -------------------------------------------------------------------


def now() -> datetime:
    """This moment; it decides whether a key has expired and when an unused run is removed, nothing else."""
    return datetime.now(UTC)


def number_of(cursor: str) -> int:
    """The number in a cursor; raises InvalidInput."""
    if not cursor.isascii() or not cursor.isdigit() or len(cursor) > 18:
        limit = "the cursor of an earlier page"
        raise InvalidInput([Finding("cursor", repr(cursor[:40]), limit, "omit the cursor for the first page")])
    return int(cursor)


def batches(items: Iterable[str]) -> Iterable[list[str]]:
    """Items in lists short enough for one statement."""
    items = list(items)
    starts = range(0, len(items), ROWS_PER_STATEMENT)
    return (items[start : start + ROWS_PER_STATEMENT] for start in starts)
