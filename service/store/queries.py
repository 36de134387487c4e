"""Expressions and statements that several methods share, and rows turned into records."""

from collections import defaultdict
from collections.abc import Iterable, Mapping, Sequence
from datetime import UTC, datetime
from typing import Any

import sqlalchemy as sa
from sqlalchemy.dialects import postgresql, sqlite

from service.records.jobs import (
    ACTIVE,
    Cause,
    Claim,
    Keep,
    Kind,
    NotFound,
    RunRow,
    State,
    Stored,
    SweepRow,
    SweepState,
)
from service.store.rows import Row, sweep_record
from service.store.tables import ARTIFACTS, CAUSES, CONTROL, EVENTS, JOBS, POINTS, SWEEPS, words
from studies.values.errors import Finding, InvalidInput

ROWS_PER_STATEMENT = 1000  # SQLite takes 32 766 parameters in a statement

# --- expressions -------------------------------------------------------------------------------

RUN_COLUMNS = [JOBS.c[field] for field in RunRow.__dataclass_fields__]
CLAIM_COLUMNS = [JOBS.c[field] for field in Claim.__dataclass_fields__]
PUBLICATIONS = JOBS.alias("publications")


def _word(word: str) -> sa.ColumnClause[str]:
    """A word as a literal: PostgreSQL groups by an expression only if it has no parameters."""
    return sa.literal_column(f"'{word}'")


# Where a point stands for its sweep: cancelled once the sweep no longer waits for the run.
POINT_STATE = sa.type_coerce(
    sa.case(
        (POINTS.c.detached, _word(State.CANCELLED)), else_=sa.type_coerce(JOBS.c.state, sa.Text)
    ),
    words(State),
)

# One row of each sweep, and no EXISTS: PostgreSQL answers that for all sweeps of the store at once.
_IS_BEGUN = (
    sa.select(sa.true())
    .where(
        POINTS.c.sweep_id == SWEEPS.c.id, JOBS.c.id == POINTS.c.run_id, JOBS.c.state != State.QUEUED
    )
    .limit(1)
    .correlate(SWEEPS)
    .scalar_subquery()
    .is_not(None)
)

# Where a sweep stands, from its publication and its runs.
SWEEP_STATE = sa.type_coerce(
    sa.case(
        (PUBLICATIONS.c.state == State.FAILED, _word(SweepState.FAILED)),
        (PUBLICATIONS.c.state == State.CANCELLED, _word(SweepState.CANCELLED)),
        (
            sa.and_(PUBLICATIONS.c.state == State.SUCCEEDED, SWEEPS.c.cancelled.is_(None)),
            _word(SweepState.SUCCEEDED),
        ),
        (PUBLICATIONS.c.state == State.SUCCEEDED, _word(SweepState.CANCELLED)),
        (SWEEPS.c.cancelled.is_not(None), _word(SweepState.CANCELLING)),
        (PUBLICATIONS.c.state != State.WAITING, _word(SweepState.PUBLISHING)),
        (_IS_BEGUN, _word(SweepState.RUNNING)),
        else_=_word(SweepState.QUEUED),
    ),
    words(SweepState),
)

# A sweep with its state, without its document, which may be long.
SWEEP_ROWS = sa.select(
    *(SWEEPS.c[name] for name in ("number", "id", "name", "title", "scenario", "planned", "new")),
    *(SWEEPS.c[name] for name in ("owner", "priority", "keep", "created", "cancelled")),
    SWEEP_STATE.label("state"),
    *(PUBLICATIONS.c.reason, PUBLICATIONS.c.finished),
    sa.select(CONTROL.c.revivals).scalar_subquery().label("revivals"),
).join_from(SWEEPS, PUBLICATIONS, PUBLICATIONS.c.sweep_id == SWEEPS.c.id)


def _is_held(id: Any, attempt: Any, epoch: Any) -> sa.ColumnElement[bool]:
    return sa.and_(
        JOBS.c.id == id,
        JOBS.c.attempt == attempt,
        JOBS.c.epoch == epoch,
        # A list of states could not be given for many claims at once.
        sa.or_(JOBS.c.state == State.RUNNING, JOBS.c.state == State.CANCELLING),
    )


def is_held(claim: Claim) -> sa.ColumnElement[bool]:
    """The claim still counts: nobody claimed the job later, and it has not ended."""
    return _is_held(claim.id, claim.attempt, claim.epoch)


# The same for many claims at once, each with the words of ``held_by``.
IS_HELD = _is_held(*(sa.bindparam(f"held_{word}") for word in ("id", "attempt", "epoch")))


def held_by(claim: Claim) -> dict[str, Any]:
    """The words of IS_HELD."""
    return {"held_id": claim.id, "held_attempt": claim.attempt, "held_epoch": claim.epoch}


def ended_by_accident(*, verdicts: bool) -> sa.ColumnElement[bool]:
    """The run has no result although it ended, so that it is worth another try."""
    accident = sa.and_(JOBS.c.state == State.FAILED, JOBS.c.cause != Cause.VERDICT)
    ended = accident if not verdicts else JOBS.c.state == State.FAILED
    return sa.or_(JOBS.c.state == State.CANCELLED, ended)


# Also while it is computed again; a publication has none of its own.
HAS_RESULT = JOBS.c.path.is_not(None)


def given_up(otherwise: State) -> sa.Case[str]:
    """Where a job ends without a new result: at the one that it has, else ``otherwise``."""
    return sa.case(
        (sa.not_(HAS_RESULT), _word(otherwise)),
        (JOBS.c.cause.is_(None), _word(State.SUCCEEDED)),
        else_=_word(State.FAILED),
    )


def keep_of(is_given_up: sa.ColumnElement[bool]) -> sa.Case[Any]:
    """What a row keeps when a run goes back to its result: no more than what is there."""
    known = sa.and_(is_given_up, HAS_RESULT)
    return sa.case((known, sa.literal(Keep.NUMBERS, JOBS.c.keep.type)), else_=JOBS.c.keep)


def unless_result(**values: Any) -> dict[str, sa.ColumnElement[Any]]:
    """Values of a row for a job that has no result; one that has keeps what its row says."""
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


def insert_missing(connection: sa.Connection, rows: Sequence[Mapping[str, Any]]) -> int:
    """Insert the runs that are not there yet, and return their number."""
    insert = insert_into(connection, JOBS).on_conflict_do_nothing()
    counted = insert.execution_options(preserve_rowcount=True)
    return connection.execute(counted, rows).rowcount


def revive(connection: sa.Connection, points: int) -> None:
    """Note that so many points of sweeps had ended, and no longer have: see ``Tallies``."""
    connection.execute(CONTROL.update().values(revivals=CONTROL.c.revivals + points))


def count_attempt(connection: sa.Connection, cause: Cause) -> None:
    """Count an attempt that did not succeed."""
    insert = insert_into(connection, CAUSES).values(cause=cause, attempts=1)
    one_more = {"attempts": CAUSES.c.attempts + 1}
    connection.execute(insert.on_conflict_do_update(index_elements=["cause"], set_=one_more))


def register_files(connection: sa.Connection, job_id: str, files: Iterable[Stored]) -> None:
    """Files of a job, in place of those that have their names."""
    rows = [{**vars(file), "job_id": job_id} for file in files]
    if rows:
        names = [row["name"] for row in rows]
        same = ARTIFACTS.delete().where(ARTIFACTS.c.job_id == job_id)
        connection.execute(same.where(ARTIFACTS.c.name.in_(names)))
        connection.execute(ARTIFACTS.insert(), rows)


def release_publications(
    connection: sa.Connection, moment: datetime, which: sa.ColumnElement[bool]
) -> None:
    """Queue those waiting publications, among ``which``, whose sweeps wait for no run any more.

    Each waiting one knows a witness: a point that was unfinished when somebody last looked. While
    it still is, there is nothing to do; else all points are searched for another. So the end of a
    run costs the same however long its sweeps are.
    """
    waiting = (which, JOBS.c.state == State.WAITING)
    another = (
        _UNFINISHED.with_only_columns(POINTS.c.ordinal)
        .order_by(POINTS.c.ordinal.desc())  # runs are claimed in order: the last is unfinished long
        .limit(1)
        .scalar_subquery()
    )
    still = _UNFINISHED.where(POINTS.c.ordinal == JOBS.c.witness).exists()
    look = JOBS.update().where(*waiting, sa.not_(still)).values(witness=another)
    seen = connection.execute(look.returning(JOBS.c.id, JOBS.c.witness)).all()
    done = [row.id for row in seen if row.witness is None]
    if done:
        queue = JOBS.update().where(JOBS.c.id.in_(done))
        connection.execute(queue.values(state=State.QUEUED, queued=moment))


def hold_publications(connection: sa.Connection, which: sa.ColumnElement[bool]) -> None:
    """Let those queued publications, among ``which``, wait whose runs are no longer all done."""
    wait = JOBS.update().where(which, JOBS.c.kind == Kind.PUBLISH, JOBS.c.state == State.QUEUED)
    wait = wait.where(_UNFINISHED.exists())
    connection.execute(wait.values(state=State.WAITING, witness=sa.null()))


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
    connection.execute(
        EVENTS.insert().values(time=moment, kind=kind, sweep_id=sweep_id, job_id=job_id, body=body)
    )


def log_attempt(
    connection: sa.Connection, moment: datetime, kind: str, claim: Claim, **body: Any
) -> None:
    """Append an event of one attempt of a job."""
    log_attempts(connection, moment, kind, [claim], **body)


def log_attempts(
    connection: sa.Connection, moment: datetime, kind: str, claims: Sequence[Claim], **body: Any
) -> None:
    """Append the same event for attempts of several jobs."""
    rows = [
        {
            "time": moment,
            "kind": kind,
            "sweep_id": claim.sweep_id,
            "job_id": claim.id,
            "body": {"attempt": claim.attempt, **body},
        }
        for claim in claims
    ]
    connection.execute(EVENTS.insert(), rows)


def one_row(connection: sa.Connection, query: sa.Select[Any], kind: str, id: str) -> Row:
    """The single row of a query; raises NotFound."""
    row = connection.execute(query).first()
    if row is None:
        raise NotFound(kind, id)
    return row


def sweep_row(connection: sa.Connection, id: str) -> SweepRow:
    """One sweep with its counts; raises NotFound."""
    row = one_row(connection, SWEEP_ROWS.where(SWEEPS.c.id == id), "sweep", id)
    return sweep_rows(connection, [row])[0]


def sweep_rows(
    connection: sa.Connection,
    rows: Sequence[Row],
    tallies: Mapping[str, Sequence[Row]] | None = None,
) -> tuple[SweepRow, ...]:
    """Sweeps with their counts: one statement for all of them, or none if their tallies are given."""
    known = tallies_of(connection, [row.id for row in rows]) if tallies is None else tallies
    return tuple(sweep_record(row, known[row.id]) for row in rows)


def tallies_of(connection: sa.Connection, ids: Sequence[str]) -> Mapping[str, list[Row]]:
    """For each sweep and state: number of points, cost, cost done, seconds spent."""
    done = sa.func.coalesce(JOBS.c.fraction, 0.0) * JOBS.c.cost
    if not ids:
        return {}
    query = (
        sa.select(POINTS.c.sweep_id, POINT_STATE.label("point_state"))
        .add_columns(sa.func.count().label("points"), sa.func.sum(JOBS.c.cost).label("cost"))
        .add_columns(sa.func.sum(done).label("done"), sa.func.sum(JOBS.c.seconds).label("seconds"))
        .join_from(POINTS, JOBS, JOBS.c.id == POINTS.c.run_id)
        .where(POINTS.c.sweep_id.in_(ids))
        .group_by(POINTS.c.sweep_id, POINT_STATE)
    )
    tallies = defaultdict(list)
    for row in connection.execute(query):
        tallies[row.sweep_id].append(row)
    return tallies


# --- small things -------------------------------------------------------------------------------


def now() -> datetime:
    """The moment, for people; what is decided by it: whether a key has expired, a run may be forgotten."""
    return datetime.now(UTC)


def number_of(cursor: str) -> int:
    """The place that a cursor stands for."""
    if not cursor.isascii() or not cursor.isdigit() or len(cursor) > 18:
        limit = "a cursor that an earlier page gave"
        raise InvalidInput([Finding("cursor", repr(cursor[:40]), limit, "leave it out to begin")])
    return int(cursor)


def batches(items: Iterable[str]) -> Iterable[list[str]]:
    """Items in lists short enough for one statement."""
    whole = list(items)
    return (
        whole[begin : begin + ROWS_PER_STATEMENT]
        for begin in range(0, len(whole), ROWS_PER_STATEMENT)
    )
