"""Commands of people: accept, cancel, retry and delete sweeps; pause the queue, set priorities."""

import uuid
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from datetime import datetime
from typing import TYPE_CHECKING, Any

import sqlalchemy as sa

from service.records.expansion import ExpandedPoint, ExpandedSweep, expand
from service.records.fault_points import fault_point
from service.records.jobs import (
    ACTIVE,
    SWEEP_TERMINAL,
    Conflict,
    Keep,
    KeyReused,
    Kind,
    QueueRow,
    State,
    Stored,
    Submission,
    SweepState,
    SweepStatus,
    before,
)
from service.store import fair_queueing
from service.store.connection import Database, JsonText
from service.store.fair_queueing import IS_WANTED, MOVED_TIME, URGENCY
from service.store.queue_queries import QueueQueries
from service.store.statements import (
    PUBLISH_PRIORITY,
    given_up,
    insert_into,
    invalidate_tallies,
    log_event,
    now,
    one_row,
    release_publications,
    retention_if,
    runs_of,
)
from service.store.sweep_queries import sweep_status
from service.store.tables import ARTIFACTS, CONTROL, IDEMPOTENCY, JOBS, POINTS, SWEEPS
from studies.values.files import RESULT

if TYPE_CHECKING:
    from studies.runs.run import Run
    from studies.sweeps.sweep import Sweep

BATCH = 1000  # rows inserted by one statement; the specification of a run takes 3 kB


class Commands(QueueQueries):
    """Each command is one transaction."""

    def __init__(self, database: Database, *, cost: Callable[["Run"], float]):
        super().__init__(database)
        self._cost = cost
        self._listeners: list[Callable[[], object]] = []

    def on_command(self, listener: Callable[[], object]) -> None:
        """Call ``listener`` after each command given here; it must be quick."""
        self._listeners.append(listener)

    @contextmanager
    def _commanding(self) -> Iterator[sa.Connection]:
        """A transaction that gives the dispatcher something to do."""
        with self._database.writing() as connection:
            yield connection
        for listener in self._listeners:
            listener()

    # --- the queue -------------------------------------------------------------------------------

    def pause(self) -> QueueRow:
        """Begin no more runs; those under way go on, and finished sweeps are published."""
        moment = now()
        pause = CONTROL.update().where(CONTROL.c.paused.is_(None)).values(paused=moment)
        with self._commanding() as connection:
            if connection.execute(pause).rowcount:
                log_event(connection, moment, "paused")
        return self.queue()

    def resume(self) -> QueueRow:
        """Begin runs again."""
        resume = CONTROL.update().where(CONTROL.c.paused.is_not(None)).values(paused=None)
        with self._commanding() as connection:
            if connection.execute(resume).rowcount:
                log_event(connection, now(), "resumed")
        return self.queue()

    def allow_forgetting(self, results: int) -> None:
        """Let this many lost results be forgotten beyond the limits, once: their runs are computed again."""
        with self._commanding() as connection:
            connection.execute(CONTROL.update().values(forgettable=results))

    # --- sweeps ----------------------------------------------------------------------------------

    def create_sweep(self, submission: Submission) -> SweepStatus:
        """Accept a sweep: its row, runs, points and publication, or nothing at all.

        A run that is finished is linked, one that is under way is joined, one that an accident or a
        cancel ended is queued again. A submission with the idempotency key and body of an earlier one
        is the earlier sweep; with another body it raises KeyReused.
        """
        if submission.idempotency is not None:
            with self._database.reading() as connection:
                earlier = _accepted_before(connection, submission)
            if earlier is not None:
                return earlier
        sweep = submission.sweep
        if not isinstance(sweep, ExpandedSweep):
            sweep = expand(sweep, self._cost)
        rows = _rows_of(submission, sweep, now())
        with self._commanding() as connection:
            earlier = _accepted_before(connection, submission)
            accepted = earlier or _accept(connection, submission, rows)
            fault_point("submission-before-commit")
        fault_point("submission-after-commit")
        return accepted

    def cancel_sweep(self, id: str) -> SweepStatus:
        """Stop waiting for runs that are not done; results so far are published.

        Runs that no other sweep waits for leave the queue, or are to be stopped; the others take
        the priority of those that wait. A sweep that is being published, or is done, stays as it is.
        """
        moment = now()
        with self._commanding() as connection:
            detached = connection.execute(_detach(id)).rowcount
            if detached:
                cancel = SWEEPS.update().where(SWEEPS.c.id == id).values(cancelled=moment)
                connection.execute(cancel)
                connection.execute(_give_up(id, moment))
                log_event(connection, moment, "cancelled", sweep_id=id, points=detached)
            return sweep_status(connection, id)

    def retry_sweep(self, id: str, *, verdicts: bool = False) -> SweepStatus:
        """Queue again what an accident or a cancel ended (``verdicts``: the solver's too), then publish."""
        moment = now()
        publication = (
            sa.select(JOBS.c.state, SWEEPS.c.priority)
            .join_from(JOBS, SWEEPS, SWEEPS.c.id == JOBS.c.sweep_id)
            .where(SWEEPS.c.id == id)
        )
        resume = SWEEPS.update().where(SWEEPS.c.id == id).values(cancelled=sa.null())
        attach = POINTS.update().where(POINTS.c.sweep_id == id).values(detached=False)
        with self._commanding() as connection:
            row = one_row(connection, publication, "sweep", id)
            if row.state is State.RUNNING:
                raise Conflict("the sweep is being published; retry it afterwards")
            connection.execute(resume)
            invalidate_tallies(connection, connection.execute(attach).rowcount)
            connection.execute(_publish_again(id))
            again = fair_queueing.queue_again(connection, id, moment, verdicts=verdicts)
            fair_queueing.schedule(connection, id, row.priority)
            release_publications(connection, moment, JOBS.c.sweep_id == id)
            log_event(connection, moment, "retried", sweep_id=id, runs=again)
            return sweep_status(connection, id)

    def replace_result(self, id: str, was: str, answer: Stored, summary: Mapping[str, Any]) -> tuple[str, ...]:
        """Replace the result of a run, if its SHA-256 is ``was``; return the sweeps to be published again.

        Those are the ones that were published with the earlier result, or are being published.
        """
        moment = now()
        file = {"path": answer.path, "size": answer.size, "sha256": answer.sha256}
        run = JOBS.update().where(JOBS.c.id == id, JOBS.c.sha256 == was)
        registered = ARTIFACTS.update().where(ARTIFACTS.c.job_id == id, ARTIFACTS.c.name == RESULT)
        using = sa.select(POINTS.c.sweep_id).where(POINTS.c.run_id == id, ~POINTS.c.detached)
        publication = JOBS.c.sweep_id.in_(using)
        stale = JOBS.update().where(publication, JOBS.c.state.in_([State.SUCCEEDED, State.RUNNING]))
        mark = stale.values(state=State.WAITING, crashes=0).returning(JOBS.c.sweep_id)
        with self._commanding() as connection:
            if not connection.execute(run.values(**file, summary=dict(summary))).rowcount:
                return ()
            connection.execute(registered.values(file))
            log_event(connection, moment, "remeasured", job_id=id, was=was, sha256=answer.sha256)
            marked = connection.scalars(mark).all()
            release_publications(connection, moment, publication)
            for sweep_id in marked:
                log_event(connection, moment, "outdated", sweep_id=sweep_id)
        return tuple(marked)

    def set_priority(self, id: str, priority: int) -> SweepStatus:
        """Let a sweep's runs come sooner or later; a shared run follows the most urgent sweep."""
        with self._commanding() as connection:
            state = sweep_status(connection, id).state
            if state in SWEEP_TERMINAL:
                raise Conflict(f"the sweep has ended; it is {state}")
            fair_queueing.open_class(connection, priority)
            update = SWEEPS.update().where(SWEEPS.c.id == id)
            connection.execute(update.values(priority=priority))
            fair_queueing.follow_urgency(connection, id)
            log_event(connection, now(), "prioritised", sweep_id=id, priority=priority)
            return sweep_status(connection, id)

    def delete_sweep(self, id: str) -> None:
        """Delete a sweep that has ended; its runs stay for a while, since other sweeps may need them."""
        own = sa.select(JOBS.c.id).where(JOBS.c.sweep_id == id)
        moment = now()
        abandon = JOBS.update().where(JOBS.c.id.in_(runs_of(id))).values(abandoned=moment)
        with self._commanding() as connection:
            state = sweep_status(connection, id).state
            if state not in SWEEP_TERMINAL:
                stopping = state is SweepState.CANCELLING
                cure = "delete it once it is cancelled" if stopping else "cancel it, then delete it"
                raise Conflict(f"the sweep is {state}; {cure}")
            connection.execute(abandon)
            connection.execute(ARTIFACTS.delete().where(ARTIFACTS.c.job_id.in_(own)))
            for table in (IDEMPOTENCY, POINTS, JOBS):
                connection.execute(table.delete().where(table.c.sweep_id == id))
            connection.execute(SWEEPS.delete().where(SWEEPS.c.id == id))
            log_event(connection, moment, "deleted", sweep_id=id)


def _publish_again(id: str) -> sa.Update:
    """Let a publication that has ended, or not begun, wait for its runs again."""
    wait = JOBS.update().where(JOBS.c.sweep_id == id, JOBS.c.state.in_(before(State.WAITING)))
    of_last_end = ("cause", "failure", "reason", "finished", "crash_step", "unfinished_point")
    return wait.values(state=State.WAITING, crashes=0, **dict.fromkeys(of_last_end, sa.null()))


# --- acceptance --------------------------------------------------------------------------------


@dataclass(frozen=True)
class _Rows:
    """The rows of a sweep, by table."""

    sweep: dict[str, Any]
    runs: list[dict[str, Any]]  # each once
    points: Sequence[ExpandedPoint]
    publication: dict[str, Any]


def digest_of(sweep: "Sweep") -> str:
    """Digest of a sweep's document and of its runs: the same document for the same physics."""
    return expand(sweep, cost=lambda _run: 0.0).digest


def _rows_of(submission: Submission, sweep: ExpandedSweep, moment: datetime) -> _Rows:
    """The rows of a sweep that is accepted now.

    The virtual times of its runs are those in an empty queue, if all of them are new.
    """
    id = uuid.uuid4().hex
    return _Rows(
        sweep={
            "id": id,
            "name": sweep.name,
            "title": sweep.title,
            "scenario": sweep.scenario,
            "document": sweep.document,
            "digest": sweep.digest,
            "owner": submission.owner,
            "priority": submission.priority,
            "keep": submission.keep,
            "planned": len(sweep.points),
            "new": 0,
            "created": moment,
        },
        runs=run_rows(sweep.points, priority=submission.priority, keep=submission.keep, moment=moment),
        points=sweep.points,
        publication={
            "id": uuid.uuid4().hex,
            "kind": Kind.PUBLISH,
            "sweep_id": id,
            "state": State.WAITING,
            "priority": PUBLISH_PRIORITY,
            "virtual_time": 0.0,
            "ordinal": 0,
            "keep": Keep.NUMBERS,
            "cost": 1.0,
            **_unbegun(moment),
        },
    )


def _unbegun(moment: datetime) -> dict[str, Any]:
    return {"attempt": 0, "term": 0, "crashes": 0, "created": moment, "queued": moment}


def run_rows(
    points: Sequence[ExpandedPoint], *, priority: int, keep: Keep, moment: datetime, first: int = 0
) -> list[dict[str, Any]]:
    """The rows of the runs of points, each once; ``first`` is the ordinal of the first point."""
    runs: list[dict[str, Any]] = []
    virtual_time = 0.0
    for ordinal, point in enumerate(points, first):
        if point.parameters is not None:
            runs.append(
                {
                    "id": point.run_id,
                    "kind": Kind.RUN,
                    "scenario": point.scenario,
                    "spec": point,
                    "state": State.QUEUED,
                    "priority": priority,
                    "virtual_time": virtual_time,
                    "ordinal": ordinal,
                    "keep": keep,
                    "cost": point.cost,
                    **_unbegun(moment),
                }
            )
            virtual_time += point.cost
    return runs


def insert_points(connection: sa.Connection, sweep_id: str, points: Sequence[ExpandedPoint], first: int = 0) -> None:
    """Insert the points of a sweep; ``first`` is the ordinal of the first one."""
    for begin in range(0, len(points), BATCH):
        batch = [
            {
                "sweep_id": sweep_id,
                "ordinal": ordinal,
                "run_id": point.run_id,
                "axis_index": JsonText(point.axis_index),
                "coordinates": JsonText(point.coordinates),
                "detached": False,
            }
            for ordinal, point in enumerate(points[begin : begin + BATCH], first + begin)
        ]
        connection.execute(POINTS.insert(), batch)


def _accepted_before(connection: sa.Connection, submission: Submission) -> SweepStatus | None:
    """The sweep of an earlier submission with this idempotency key; raises KeyReused."""
    if submission.idempotency is None:
        return None
    key, digest = submission.idempotency
    query = sa.select(IDEMPOTENCY.c.digest, IDEMPOTENCY.c.sweep_id).where(
        IDEMPOTENCY.c.owner == submission.owner, IDEMPOTENCY.c.key == key
    )
    row = connection.execute(query).first()
    if row is None:
        return None
    if row.digest != digest:
        raise KeyReused(f"the key {key!r} was used for another body; take a new one")
    return sweep_status(connection, row.sweep_id)


def _accept(connection: sa.Connection, submission: Submission, rows: _Rows) -> SweepStatus:
    """Write the rows of a sweep, and join it to runs that are there already."""
    id, moment = rows.sweep["id"], rows.sweep["created"]
    begin = fair_queueing.open_class(connection, submission.priority)
    new = insert_new_runs(connection, rows.runs, begin)
    connection.execute(SWEEPS.insert().values(rows.sweep))
    connection.execute(JOBS.insert().values(rows.publication))
    insert_points(connection, id, rows.points)
    if new < len(rows.runs):
        new += fair_queueing.queue_again(connection, id, moment, verdicts=False)
        fair_queueing.schedule(connection, id, submission.priority)
    connection.execute(SWEEPS.update().where(SWEEPS.c.id == id).values(new=new))
    release_publications(connection, moment, JOBS.c.sweep_id == id)
    if submission.idempotency is not None:
        key, digest = submission.idempotency
        row = {"owner": submission.owner, "key": key, "digest": digest, "sweep_id": id}
        connection.execute(IDEMPOTENCY.insert().values(row))
    planned = rows.sweep["planned"]
    log_event(connection, moment, "accepted", sweep_id=id, planned=planned, new=new)
    return sweep_status(connection, id)


def insert_new_runs(connection: sa.Connection, rows: Sequence[dict[str, Any]], begin: float) -> int:
    """Insert those runs that no sweep has brought yet, from a virtual time on; return their number."""
    insert = insert_into(connection, JOBS).on_conflict_do_nothing()
    counted = insert.execution_options(preserve_rowcount=True)
    new = 0
    for first in range(0, len(rows), BATCH):
        batch = [
            {**row, "virtual_time": row["virtual_time"] + begin, "spec": JsonText(row["spec"].spec)}
            for row in rows[first : first + BATCH]
        ]
        new += connection.execute(counted, batch).rowcount
    return new


# --- cancel ------------------------------------------------------------------------------------


def _detach(id: str) -> sa.Update:
    """Let a sweep that waits for runs wait no longer for those that are not done."""
    unfinished = sa.select(JOBS.c.id).where(JOBS.c.id.in_(runs_of(id)), JOBS.c.state.in_(ACTIVE))
    waits = sa.exists().where(JOBS.c.sweep_id == id, JOBS.c.state == State.WAITING)
    return (
        POINTS.update()
        .where(POINTS.c.sweep_id == id, POINTS.c.detached.is_(False))
        .where(POINTS.c.run_id.in_(unfinished), waits)
        .values(detached=True)
    )


def _give_up(id: str, moment: datetime) -> sa.Update:
    """Move the detached runs of a sweep and its publication, in one statement.

    A run goes on for others, or leaves the queue, or is to be stopped. Results are published; a
    sweep without results has ended.
    """
    is_run = JOBS.c.kind == Kind.RUN
    has_results = sa.exists().where(POINTS.c.sweep_id == id, POINTS.c.detached.is_(False))
    goes_on = is_run & IS_WANTED
    ends = sa.or_(is_run & (JOBS.c.state == State.QUEUED), sa.not_(is_run) & sa.not_(has_results))
    state = sa.case(
        (goes_on, sa.type_coerce(JOBS.c.state, sa.Text)),
        (ends, given_up(State.CANCELLED)),
        (is_run, State.CANCELLING.value),
        else_=State.QUEUED.value,
    )
    publication = (JOBS.c.sweep_id == id) & (JOBS.c.state == State.WAITING)
    return (
        JOBS.update()
        .where(sa.or_(publication, JOBS.c.id.in_(runs_of(id)) & JOBS.c.state.in_(ACTIVE)))
        .values(state=sa.type_coerce(state, JOBS.c.state.type))
        .values(finished=sa.case((sa.not_(goes_on) & ends, moment), else_=JOBS.c.finished))
        .values(queued=sa.case((is_run, JOBS.c.queued), else_=moment))
        .values(keep=retention_if(sa.not_(goes_on) & ends))
        .values(priority=sa.case((goes_on, URGENCY), else_=JOBS.c.priority))
        .values(virtual_time=sa.case((goes_on, MOVED_TIME), else_=JOBS.c.virtual_time))
    )
