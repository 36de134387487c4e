"""Expressions and statements that several methods share, and rows turned into records."""

from collections import defaultdict
from collections.abc import Iterable, Mapping, Sequence
from datetime import UTC, datetime
from typing import TYPE_CHECKING, Any

import sqlalchemy as sa
from sqlalchemy.dialects import postgresql, sqlite

from service.jobs import (
    ACTIVE,
    Cause,
    Claim,
    NotFound,
    RunRow,
    State,
    SweepRow,
    SweepState,
)
from service.store.rows import Row, sweep_record
from service.store.tables import EVENTS, JOBS, POINTS, SWEEPS, words
from studies.errors import Finding, InvalidInput

if TYPE_CHECKING:
    pass

ROWS_PER_STATEMENT = 1000  # SQLite takes 32 766 parameters in a statement

# --- expressions -------------------------------------------------------------------------------

RUN_COLUMNS = [JOBS.c[field] for field in RunRow.__dataclass_fields__]
CLAIM_COLUMNS = [JOBS.c[field] for field in Claim.__dataclass_fields__]
TURN = [JOBS.c.priority, JOBS.c.queued, JOBS.c.ordinal]
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

_IS_BEGUN = sa.exists().where(
    POINTS.c.sweep_id == SWEEPS.c.id, JOBS.c.id == POINTS.c.run_id, JOBS.c.state != State.QUEUED
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
    *(SWEEPS.c.created, SWEEPS.c.cancelled, SWEEP_STATE.label("state")),
    *(PUBLICATIONS.c.reason, PUBLICATIONS.c.finished),
).join_from(SWEEPS, PUBLICATIONS, PUBLICATIONS.c.sweep_id == SWEEPS.c.id)

# Some sweep still waits for this run; one that is being published, or is done, does not.
IS_WANTED = sa.exists().where(
    POINTS.c.run_id == JOBS.c.id,
    POINTS.c.detached.is_(False),
    PUBLICATIONS.c.sweep_id == POINTS.c.sweep_id,
    PUBLICATIONS.c.state == State.WAITING,
)


def is_held(claim: Claim) -> sa.ColumnElement[bool]:
    """The claim still counts: nobody claimed the job later, and it has not ended."""
    return sa.and_(
        JOBS.c.id == claim.id,
        JOBS.c.attempt == claim.attempt,
        JOBS.c.epoch == claim.epoch,
        JOBS.c.state.in_([State.RUNNING, State.CANCELLING]),
    )


def ended_by_accident(*, verdicts: bool) -> sa.ColumnElement[bool]:
    """The run has no result although it ended, so that it is worth another try."""
    accident = sa.and_(JOBS.c.state == State.FAILED, JOBS.c.cause != Cause.VERDICT)
    ended = accident if not verdicts else JOBS.c.state == State.FAILED
    return sa.or_(JOBS.c.state == State.CANCELLED, ended)


# --- statements --------------------------------------------------------------------------------


def insert_missing(connection: sa.Connection, rows: Sequence[Mapping[str, Any]]) -> set[str]:
    """Insert the runs that are not there yet, and return their ids."""
    dialect = postgresql if connection.dialect.name == "postgresql" else sqlite
    insert = dialect.insert(JOBS).on_conflict_do_nothing().returning(JOBS.c.id)
    return set(connection.execute(insert, rows).scalars())


def queue_again(
    connection: sa.Connection, sweep_id: str, moment: datetime, *, verdicts: bool
) -> set[str]:
    """Queue the runs of a sweep that ended by accident, with fresh budgets; return their ids."""
    own = sa.select(POINTS.c.run_id).where(POINTS.c.sweep_id == sweep_id)
    nothing = dict.fromkeys(
        ("cause", "failure", "reason", "summary", "path", "size", "sha256", "finished"), sa.null()
    )
    again = (
        JOBS.update()
        .where(JOBS.c.id.in_(own), ended_by_accident(verdicts=verdicts))
        .values(state=State.QUEUED, queued=moment, crashes=0, **nothing)
        .returning(JOBS.c.id)
    )
    return set(connection.execute(again).scalars())


def release_publications(
    connection: sa.Connection, moment: datetime, which: sa.ColumnElement[bool]
) -> None:
    """Queue those waiting publications, among ``which``, whose sweeps wait for no run any more."""
    runs = JOBS.alias("runs")
    # Runs are claimed in order, so an unfinished one is found at once from the end.
    unfinished = (
        sa.select(POINTS.c.ordinal)
        .join_from(POINTS, runs, runs.c.id == POINTS.c.run_id)
        .where(POINTS.c.sweep_id == JOBS.c.sweep_id, POINTS.c.detached.is_(False))
        .where(runs.c.state.in_(ACTIVE))
        .order_by(POINTS.c.ordinal.desc())
        .limit(1)
        .correlate(JOBS)
        .scalar_subquery()
    )
    connection.execute(
        JOBS.update()
        .where(which, JOBS.c.state == State.WAITING, unfinished.is_(None))
        .values(state=State.QUEUED, queued=moment)
    )


def settle_cancelled_publication(
    connection: sa.Connection, sweep_id: str, moment: datetime
) -> None:
    """After a cancel: publish what was computed, or end at once if there is nothing."""
    results = (
        sa.select(POINTS.c.ordinal)
        .join_from(POINTS, JOBS, JOBS.c.id == POINTS.c.run_id)
        .where(POINTS.c.sweep_id == sweep_id, POINTS.c.detached.is_(False))
        .limit(1)
    )
    if connection.execute(results).first() is not None:
        release_publications(connection, moment, JOBS.c.sweep_id == sweep_id)
        return
    connection.execute(
        JOBS.update()
        .where(JOBS.c.sweep_id == sweep_id, JOBS.c.state == State.WAITING)
        .values(state=State.CANCELLED, finished=moment)
    )


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
    ids = {"sweep_id": claim.sweep_id, "job_id": claim.id}
    log_event(connection, moment, kind, **ids, attempt=claim.attempt, **body)


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


def sweep_rows(connection: sa.Connection, rows: Sequence[Row]) -> tuple[SweepRow, ...]:
    """Sweeps with their counts: one statement for all of them."""
    tallies = _tallies(connection, [row.id for row in rows])
    return tuple(sweep_record(row, tallies[row.id]) for row in rows)


def _tallies(connection: sa.Connection, ids: Sequence[str]) -> Mapping[str, list[Row]]:
    """For each sweep and state: number of points, cost, cost done, seconds spent."""
    done = sa.func.coalesce(JOBS.c.fraction, 0.0) * JOBS.c.cost
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
    """The moment, for people: no decision depends on it."""
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
