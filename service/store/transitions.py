"""The moves of a job from state to state: a function each, within the transaction of its caller.

``service.records.jobs`` draws what may follow what. A function moves those jobs only that are in a state which its
first line names. A move of a leased job names job, attempt and term too, and has no effect unless they are
the last ones of the job: an attempt that was given up cannot overwrite the work of its successor.

A run that has a result may be computed again, for a file that was not kept or a verdict on request. Its result stays
until it is replaced, and the run goes back to it if the new attempt fails or is cancelled.
"""

import secrets
from collections.abc import Mapping, Sequence
from datetime import datetime

import sqlalchemy as sa

from service.records.jobs import (
    ACTIVE,
    KEPT_BY,
    TERMINAL,
    AttemptProgress,
    Cause,
    CrashCount,
    Keep,
    Kind,
    Lease,
    Result,
    State,
    at_least,
)
from service.store.events import log_event
from service.store.fair_queueing import IS_WANTED, LAST, MOVED
from service.store.tables import (
    ARTIFACTS,
    HAS_RESULT,
    JOBS,
    POINTS,
    SWEEPS,
    StatementRow,
    invalidate_tallies,
    literal,
    now,
    runs_of,
)
from studies.quantities.files import FILM
from studies.runs.results import OTHER_PHYSICS

LEASE_COLUMNS = [JOBS.c[field] for field in Lease.__dataclass_fields__]
# Columns of a job that say how far its attempt is.
NO_PROGRESS = dict.fromkeys(("fraction", "progress", "seconds"), sa.null())
RESULT_LOST = "ResultLost"  # failure of a run
LOST_REASON = "its registered result was lost or damaged"

# The lease is the last one of its job, and the attempt has not ended; with the parameters of ``_held``.
_IS_HELD = sa.and_(
    *(JOBS.c[name] == sa.bindparam(f"held_{name}") for name in ("id", "attempt", "term")),
    # Not IN: a list of states cannot be executed for many leases at once.
    sa.or_(JOBS.c.state == State.RUNNING, JOBS.c.state == State.CANCELLING),
)


def _held(lease: Lease) -> dict[str, str | int]:
    return {"held_id": lease.id, "held_attempt": lease.attempt, "held_term": lease.term}


# --- attempts ------------------------------------------------------------------------------------


def claim(connection: sa.Connection, ids: Sequence[str], term: int) -> list[Lease]:
    """Queued to running: begin an attempt of each of these jobs."""
    begin = JOBS.update().where(JOBS.c.id.in_(ids)).values(state=State.RUNNING, attempt=JOBS.c.attempt + 1, term=term)
    begin = begin.values(token=secrets.token_hex(4), started=now(), **NO_PROGRESS)
    return [lease_record(row) for row in connection.execute(begin.returning(*LEASE_COLUMNS))]


def renew_lease(connection: sa.Connection, lease: Lease, term: int) -> Lease | None:
    """Running or cancelling stays: the attempt goes on in a later term. None: it no longer counts."""
    update = JOBS.update().where(_IS_HELD).values(term=term)
    row = connection.execute(update.returning(*LEASE_COLUMNS), _held(lease)).first()
    return None if row is None else lease_record(row)


def note_progress(connection: sa.Connection, news: Sequence[tuple[Lease, AttemptProgress]]) -> None:
    """Running or cancelling stays: note the last message of each attempt, and the step of its last checkpoint."""
    progress = {name: sa.bindparam(f"new_{name}", type_=JOBS.c[name].type) for name in NO_PROGRESS}
    rows = [
        {
            **_held(lease),
            "new_fraction": message.get("fraction", 0.0),
            "new_seconds": message["seconds"],
            "new_progress": message,
        }
        for lease, message in news
    ]
    saved = [{**_held(lease), "step": message["checkpoint"]} for lease, message in news if "checkpoint" in message]
    if rows:
        connection.execute(JOBS.update().where(_IS_HELD).values(progress), rows)
    if saved:
        connection.execute(JOBS.update().where(_IS_HELD).values(checkpoint=sa.bindparam("step")), saved)


def finish(connection: sa.Connection, lease: Lease, result: Result, moment: datetime) -> StatementRow | None:
    """Running or cancelling to succeeded, or to failed by the solver's verdict; None: the attempt no longer counts.

    Returns the scenario and the cost of the run.
    """
    end = JOBS.update().values(
        state=State.SUCCEEDED if result.succeeded else State.FAILED,
        cause=None if result.succeeded else Cause.VERDICT,
        failure=result.failure,
        reason=result.reason,
        summary=result.summary,
        path=result.answer.path,
        size=result.answer.size,
        sha256=result.answer.sha256,
        seconds=result.seconds,
        fraction=1.0,
        checkpoint=None,
    )
    return _end(connection, lease, moment, end)


def fail(
    connection: sa.Connection, lease: Lease, moment: datetime, crashes: CrashCount | None, why: Mapping[str, str]
) -> StatementRow | None:
    """Running or cancelling to failed, or back to an earlier result; None: the attempt no longer counts.

    ``why`` has cause, failure and reason. Returns the path of the result that is there. The checkpoint stays, for a
    retry.
    """
    end = JOBS.update().values(_counted(crashes) | _unless_result(**why))
    end = end.values(state=sa.type_coerce(_given_up(State.FAILED), JOBS.c.state.type), keep=_retention_if(sa.true()))
    return _end(connection, lease, moment, end)


def requeue(connection: sa.Connection, lease: Lease, moment: datetime, crashes: CrashCount | None) -> State | None:
    """Running or cancelling to queued; to cancelled, or back to an earlier result, if no sweep waits for the run.

    Returns the new state; None: the attempt no longer counts.
    """
    ends = sa.and_(JOBS.c.kind == Kind.RUN, sa.not_(IS_WANTED))
    state = sa.case((ends, _given_up(State.CANCELLED)), else_=State.QUEUED.value)
    put_back = (
        JOBS.update()
        .where(_IS_HELD)
        .values(state=sa.type_coerce(state, JOBS.c.state.type), keep=_retention_if(ends))
        .values(finished=sa.case((ends, moment), else_=sa.null()))
        .values(NO_PROGRESS | _counted(crashes))
    )
    outcome: State | None = connection.execute(put_back.returning(JOBS.c.state), _held(lease)).scalar()
    if outcome is State.QUEUED:
        hold_publications(connection, JOBS.c.id == lease.id)
    return outcome


def publish(connection: sa.Connection, lease: Lease, moment: datetime, seconds: float, headline: str) -> bool:
    """Running to succeeded, of a publication; False: the attempt no longer counts."""
    summary = {"headline": headline} if headline else None
    end = {"state": State.SUCCEEDED, "seconds": seconds, "finished": moment, "summary": summary}
    return connection.execute(JOBS.update().where(_IS_HELD).values(end), _held(lease)).rowcount > 0


def wait_again(connection: sa.Connection, lease: Lease, *conditions: sa.ColumnElement[bool]) -> bool:
    """Running to waiting, of a publication whose sweep has runs to do again; False: the attempt no longer counts."""
    wait = JOBS.update().where(_IS_HELD, *conditions).values(NO_PROGRESS)
    wait = wait.values(state=State.WAITING, unfinished_point=sa.null(), finished=sa.null())
    return connection.execute(wait, _held(lease)).rowcount > 0


def lease_record(row: StatementRow) -> Lease:
    """A lease from a row with LEASE_COLUMNS."""
    return Lease(**{field: row._mapping[JOBS.c[field]] for field in Lease.__dataclass_fields__})


def _end(connection: sa.Connection, lease: Lease, moment: datetime, end: sa.Update) -> StatementRow | None:
    end = end.where(_IS_HELD).values(finished=moment)
    return connection.execute(end.returning(JOBS.c.path, JOBS.c.scenario, JOBS.c.cost), _held(lease)).first()


def _counted(crashes: CrashCount | None) -> dict[str, int]:
    """The columns of the crashes of a job; none where no crash is counted."""
    return {} if crashes is None else {"crashes": crashes.crashes, "crash_step": crashes.step}


# --- runs that are computed again ----------------------------------------------------------------


def ended_by_accident(*, verdicts: bool = False) -> sa.ColumnElement[bool]:
    """The run ended without a result (``verdicts``: or with the solver's), so that another try is worth while."""
    is_accident = (JOBS.c.cause != Cause.VERDICT) | (JOBS.c.failure == OTHER_PHYSICS)
    failed = JOBS.c.state == State.FAILED
    return sa.or_(JOBS.c.state == State.CANCELLED, failed if verdicts else sa.and_(failed, is_accident))


def may_be_retried(keep: Keep, *, verdicts: bool = False) -> sa.ColumnElement[bool]:
    """The run ended by accident, or has a result and lacks a file of this retention."""
    is_less = JOBS.c.state.in_([State.SUCCEEDED]) & JOBS.c.keep.not_in(at_least(keep))
    names = [name for name, least in KEPT_BY.items() if keep in at_least(least)]
    there = sa.select(sa.func.count()).where(ARTIFACTS.c.job_id == JOBS.c.id, ARTIFACTS.c.name.in_(names))
    lacks_a_file = is_less & (there.correlate(JOBS).scalar_subquery() < len(names))
    return sa.or_(ended_by_accident(verdicts=verdicts), lacks_a_file)


def retry(
    connection: sa.Connection, sweep_id: str, moment: datetime, *, verdicts: bool, among: Sequence[str] | None = None
) -> int:
    """Ended to queued, with fresh budgets: the runs of a sweep that ``may_be_retried``; return their number.

    ``among`` are the ids of those that are looked at, by default all. A result, or a verdict, stays until it is
    replaced: other sweeps may have it. ``fair_queueing.schedule`` gives the runs their virtual times.
    """
    own = runs_of(sweep_id)
    if among is not None:
        own = own.where(POINTS.c.run_id.in_(among))
    row = sa.select(SWEEPS.c.priority, SWEEPS.c.owner, SWEEPS.c.keep).where(SWEEPS.c.id == sweep_id)
    priority, owner, keep = connection.execute(row).one()
    again = JOBS.c.id.in_(own) & may_be_retried(keep, verdicts=verdicts)
    without_result = sa.select(JOBS.c.id).where(again, sa.not_(HAS_RESULT))
    connection.execute(ARTIFACTS.delete().where(ARTIFACTS.c.job_id.in_(without_result)))
    queue = _queued(JOBS.update().where(again), moment).values(crashes=0, crash_step=None)
    queue = queue.values(bytes=sa.case((HAS_RESULT, JOBS.c.bytes), else_=0))
    count = connection.execute(queue.values(priority=priority, owner=owner, virtual_time=LAST)).rowcount
    invalidate_tallies(connection, count)
    less = JOBS.update().where(JOBS.c.id.in_(own), JOBS.c.keep.not_in(at_least(keep)))
    connection.execute(less.values(keep=keep))
    using = sa.select(POINTS.c.sweep_id).where(POINTS.c.run_id.in_(own))
    hold_publications(connection, JOBS.c.sweep_id.in_(using))
    return count


def queue_for_film(connection: sa.Connection, lease: Lease, moment: datetime) -> None:
    """Succeeded to queued: a run that has just got its result, if a sweep that joined it asked for a film."""
    if lease.keep is not Keep.FILM:
        is_wanted = JOBS.c.keep.in_([Keep.FILM]) & JOBS.c.state.in_([State.SUCCEEDED]) & IS_WANTED
        film = sa.exists().where(ARTIFACTS.c.job_id == JOBS.c.id, ARTIFACTS.c.name == FILM)
        again = JOBS.update().where(JOBS.c.id == lease.id, is_wanted, sa.not_(film))
        connection.execute(_queued(again, moment).values(crashes=0, crash_step=None))


# Only rows that still have the results that were found to be lost.
_FORGET = (
    JOBS.update()
    .where(JOBS.c.id == sa.bindparam("run"), JOBS.c.sha256 == sa.bindparam("was"))
    # Not IN: the statement runs for many at once.
    .where(sa.or_(*(JOBS.c.state == state for state in TERMINAL)))
    .values(state=State.FAILED, cause=Cause.ERROR, failure=RESULT_LOST, reason=LOST_REASON)
    .values(dict.fromkeys(("path", "size", "sha256", "summary", "seconds"), sa.null()))
    .values(crashes=JOBS.c.crashes + 1, crash_step=None, bytes=0)
)


def forget_results(connection: sa.Connection, results: Mapping[str, str]) -> None:
    """Ended to failed: take lost results out of the rows of these runs, each with the digest that it had."""
    connection.execute(_FORGET, [{"run": id, "was": digest} for id, digest in results.items()])


def compute_again(connection: sa.Connection, moment: datetime, which: sa.ColumnElement[bool]) -> int:
    """Ended to queued: those runs, among ``which``, that sweeps wait for; return their number."""
    again = _queued(JOBS.update().where(which, IS_WANTED), moment)
    return connection.execute(again.values({**MOVED, "virtual_time": LAST})).rowcount


def _queued(update: sa.Update, moment: datetime) -> sa.Update:
    """Let runs be computed again; one with a result keeps what is said of it."""
    update = update.values(state=State.QUEUED, queued=moment, fraction=None, finished=None)
    return update.values(_unless_result(cause=None, failure=None, reason=None))


# --- cancel --------------------------------------------------------------------------------------


def detach(connection: sa.Connection, sweep_id: str) -> int:
    """Let a sweep that waits for runs wait no longer for those that are not done; return their number."""
    unfinished = sa.select(JOBS.c.id).where(JOBS.c.id.in_(runs_of(sweep_id)), JOBS.c.state.in_(ACTIVE))
    waits = sa.exists().where(JOBS.c.sweep_id == sweep_id, JOBS.c.state == State.WAITING)
    points = POINTS.update().where(POINTS.c.sweep_id == sweep_id, POINTS.c.detached.is_(False))
    return connection.execute(points.where(POINTS.c.run_id.in_(unfinished), waits).values(detached=True)).rowcount


def cancel(connection: sa.Connection, sweep_id: str, moment: datetime) -> None:
    """Move the detached runs of a sweep and its waiting publication, in one statement.

    A run goes on for other sweeps, in the queue of the most urgent of them. Else queued to cancelled, or back to an
    earlier result, and running to cancelling. Waiting to queued where there are results to publish, else to cancelled.
    """
    is_run = JOBS.c.kind == Kind.RUN
    has_results = sa.exists().where(POINTS.c.sweep_id == sweep_id, POINTS.c.detached.is_(False))
    goes_on = is_run & IS_WANTED
    ends = sa.or_(is_run & (JOBS.c.state == State.QUEUED), sa.not_(is_run) & sa.not_(has_results))
    state = sa.case(
        (goes_on, sa.type_coerce(JOBS.c.state, sa.Text)),
        (ends, _given_up(State.CANCELLED)),
        (is_run, State.CANCELLING.value),
        else_=State.QUEUED.value,
    )
    publication = (JOBS.c.sweep_id == sweep_id) & (JOBS.c.state == State.WAITING)
    connection.execute(
        JOBS.update()
        .where(sa.or_(publication, JOBS.c.id.in_(runs_of(sweep_id)) & JOBS.c.state.in_(ACTIVE)))
        .values(state=sa.type_coerce(state, JOBS.c.state.type))
        .values(finished=sa.case((sa.not_(goes_on) & ends, moment), else_=JOBS.c.finished))
        .values(queued=sa.case((is_run, JOBS.c.queued), else_=moment))
        .values(keep=_retention_if(sa.not_(goes_on) & ends))
        .values({name: sa.case((goes_on, place), else_=JOBS.c[name]) for name, place in MOVED.items()})
    )


def _given_up(otherwise: State) -> sa.Case[str]:
    """State of a job that ends without a new result: that of its earlier result, else ``otherwise``."""
    return sa.case(
        (sa.not_(HAS_RESULT), literal(otherwise)),
        (JOBS.c.cause.is_(None), literal(State.SUCCEEDED)),
        else_=literal(State.FAILED),
    )


def _retention_if(is_given_up: sa.ColumnElement[bool]) -> sa.Case[Keep]:
    """Retention of a job: that of the files that are there, once it goes back to its earlier result."""
    goes_back = sa.and_(is_given_up, HAS_RESULT)
    return sa.case((goes_back, sa.literal(Keep.NUMBERS, JOBS.c.keep.type)), else_=JOBS.c.keep)


def _unless_result(**values: str | None) -> dict[str, sa.Case[str | None]]:
    """Values for the row of a job without a result; the row of one with a result keeps its own."""
    return {
        name: sa.case((HAS_RESULT, JOBS.c[name]), else_=sa.literal(value, JOBS.c[name].type))
        for name, value in values.items()
    }


def leave_runs(connection: sa.Connection, sweep_id: str, moment: datetime) -> None:
    """Let the runs of a sweep that is deleted belong to the owner of another sweep that has them, or to nobody."""
    others = (
        sa.select(SWEEPS.c.owner)
        .join_from(POINTS, SWEEPS, SWEEPS.c.id == POINTS.c.sweep_id)
        .where(POINTS.c.run_id == JOBS.c.id, POINTS.c.sweep_id != sweep_id)
        .correlate(JOBS)
    )
    stays = others.where(SWEEPS.c.owner == JOBS.c.owner).exists()
    next_owner = others.order_by(SWEEPS.c.number).limit(1).scalar_subquery()
    connection.execute(
        JOBS.update()
        .where(JOBS.c.id.in_(runs_of(sweep_id)))
        .values(owner=sa.case((stays, JOBS.c.owner), else_=sa.func.coalesce(next_owner, JOBS.c.owner)))
        .values(abandoned=sa.case((others.exists(), sa.null()), else_=moment))
    )


# --- publications --------------------------------------------------------------------------------

_RUNS = JOBS.alias("runs")

# The points that a publication waits for.
_UNFINISHED = (
    sa.select(POINTS)
    .join_from(POINTS, _RUNS, _RUNS.c.id == POINTS.c.run_id)
    .where(POINTS.c.sweep_id == JOBS.c.sweep_id, POINTS.c.detached.is_(False))
    .where(_RUNS.c.state.in_(ACTIVE))
    .correlate(JOBS)
)


def release_publications(connection: sa.Connection, moment: datetime, which: sa.ColumnElement[bool]) -> None:
    """Waiting to queued: those publications, among ``which``, whose sweeps wait for no run any more.

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
        connection.execute(JOBS.update().where(JOBS.c.id.in_(done)).values(state=State.QUEUED, queued=moment))


def hold_publications(connection: sa.Connection, which: sa.ColumnElement[bool]) -> None:
    """Queued to waiting: those publications, among ``which``, whose runs are no longer all done."""
    wait = JOBS.update().where(which, JOBS.c.kind == Kind.PUBLISH, JOBS.c.state == State.QUEUED)
    wait = wait.where(_UNFINISHED.exists())
    connection.execute(wait.values(state=State.WAITING, unfinished_point=sa.null()))


def outdate_publications(connection: sa.Connection, moment: datetime, which: sa.ColumnElement[bool]) -> tuple[str, ...]:
    """Succeeded, running or queued to waiting: those publications, among ``which``; return their sweeps."""
    stale = JOBS.update().where(which, JOBS.c.state.in_([State.SUCCEEDED, State.RUNNING, State.QUEUED]))
    stale = stale.values(state=State.WAITING, crashes=0)
    sweep_ids = tuple(connection.scalars(stale.returning(JOBS.c.sweep_id)))
    for sweep_id in sweep_ids:
        log_event(connection, moment, "outdated", sweep_id=sweep_id)
    return sweep_ids


def publish_again(connection: sa.Connection, sweep_id: str) -> None:
    """Ended, queued or waiting to waiting: the publication of a sweep, as at the begin."""
    is_idle = JOBS.c.state.not_in([State.RUNNING, State.CANCELLING])
    of_last_end = dict.fromkeys(("cause", "failure", "reason", "finished", "crash_step", "unfinished_point"), sa.null())
    wait = JOBS.update().where(JOBS.c.sweep_id == sweep_id, is_idle)
    connection.execute(wait.values(state=State.WAITING, crashes=0, **of_last_end))


def refuse(connection: sa.Connection, sweep_id: str, moment: datetime, *, failure: str, reason: str) -> None:
    """Any state to failed: the publication of a sweep; the runs that it waits for alone leave the queue."""
    detach(connection, sweep_id)
    cancel(connection, sweep_id, moment)
    end = {"state": State.FAILED, "cause": Cause.ERROR, "failure": failure, "reason": reason, "finished": moment}
    connection.execute(JOBS.update().where(JOBS.c.sweep_id == sweep_id).values(end))
