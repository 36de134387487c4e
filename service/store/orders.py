"""What people order: accept, cancel, retry and delete sweeps; pause the queue, set priorities."""

from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any

import sqlalchemy as sa

from service.records.fault_points import point
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
    SweepRow,
    before,
)
from service.store import turns
from service.store.connection import Database
from service.store.overview import Overview
from service.store.queries import (
    given_up,
    insert_missing,
    keep_of,
    log_event,
    now,
    one_row,
    release_publications,
    revive,
    sweep_row,
)
from service.store.rows import Acceptance, acceptance_of
from service.store.tables import ARTIFACTS, CONTROL, IDEMPOTENCY, JOBS, POINTS, SWEEPS
from service.store.turns import IS_WANTED, MOVED_TURN, URGENCY
from studies.values.files import RESULT

if TYPE_CHECKING:
    from studies.runs.run import Run
    from studies.sweeps.sweep import Sweep


# What a publication says of its last end.
_ENDED = ("cause", "failure", "reason", "finished", "crash_step")


class Orders(Overview):
    """Each order is one transaction."""

    def __init__(self, database: Database, *, cost: Callable[["Run"], float]):
        super().__init__(database)
        self._cost = cost
        self._listeners: list[Callable[[], object]] = []

    def on_order(self, listener: Callable[[], object]) -> None:
        """Call ``listener`` after each order given here; it is told nothing and must be quick."""
        self._listeners.append(listener)

    @contextmanager
    def _ordering(self) -> Iterator[sa.Connection]:
        """A transaction that gives the dispatcher something to do."""
        with self._database.writing() as connection:
            yield connection
        for listener in self._listeners:
            listener()

    # --- the queue -------------------------------------------------------------------------------

    def pause(self) -> QueueRow:
        """Begin no run any more; those that are running go on, and what is done is published."""
        moment = now()
        pause = CONTROL.update().where(CONTROL.c.paused.is_(None)).values(paused=moment)
        with self._ordering() as connection:
            if connection.execute(pause).rowcount:
                log_event(connection, moment, "paused")
        return self.queue()

    def resume(self) -> QueueRow:
        """Begin runs again."""
        resume = CONTROL.update().where(CONTROL.c.paused.is_not(None)).values(paused=None)
        with self._ordering() as connection:
            if connection.execute(resume).rowcount:
                log_event(connection, now(), "resumed")
        return self.queue()

    def allow_forgetting(self, results: int) -> None:
        """Let so many lost results be forgotten beyond the limits, once: their runs are computed again."""
        with self._ordering() as connection:
            connection.execute(CONTROL.update().values(forgettable=results))

    # --- sweeps ----------------------------------------------------------------------------------

    def create_sweep(
        self,
        sweep: "Sweep",
        *,
        owner: str = "",
        priority: int = 0,
        keep: Keep = Keep.FINAL,
        idempotency: tuple[str, str] | None = None,
    ) -> SweepRow:
        """Accept a sweep: its row, runs, points and publication, or nothing at all.

        A run that is finished is linked, one that is under way is joined, one that an accident or a
        cancel ended is queued again. ``idempotency`` is a key of the owner's choice and the SHA-256
        of the body: the second time it is the sweep of the first, with another body KeyReused.
        """
        asked = Submission(sweep, owner, priority, keep, idempotency)
        if idempotency is not None:
            with self._database.reading() as connection:
                known = _accepted_before(connection, asked)
            if known is not None:
                return known
        rows = acceptance_of(asked, cost=self._cost, moment=now())
        with self._ordering() as connection:
            accepted = _accepted_before(connection, asked) or _accept(connection, asked, rows)
            point("submission-before-commit")
        point("submission-after-commit")
        return accepted

    def cancel_sweep(self, id: str) -> SweepRow:
        """Stop waiting for runs that are not done; what was computed until now is published.

        Runs that no other sweep waits for leave the queue, or are to be stopped; the others take
        the priority of those that wait. A sweep that is being published, or is done, stays as it is.
        """
        moment = now()
        with self._ordering() as connection:
            detached = connection.execute(_detach(id)).rowcount
            if detached:
                cancel = SWEEPS.update().where(SWEEPS.c.id == id).values(cancelled=moment)
                connection.execute(cancel)
                connection.execute(_give_up(id, moment))
                log_event(connection, moment, "cancelled", sweep_id=id, points=detached)
            return sweep_row(connection, id)

    def retry_sweep(self, id: str, *, verdicts: bool = False) -> SweepRow:
        """Queue again what an accident or a cancel ended (on request: verdicts), then publish."""
        moment = now()
        publication = (
            sa.select(JOBS.c.state, SWEEPS.c.priority)
            .join_from(JOBS, SWEEPS, SWEEPS.c.id == JOBS.c.sweep_id)
            .where(SWEEPS.c.id == id)
        )
        take_up = SWEEPS.update().where(SWEEPS.c.id == id).values(cancelled=sa.null())
        attach = POINTS.update().where(POINTS.c.sweep_id == id).values(detached=False)
        with self._ordering() as connection:
            known = one_row(connection, publication, "sweep", id)
            if known.state is State.RUNNING:
                raise Conflict("the sweep is being published; retry it when that is done")
            connection.execute(take_up)
            revive(connection, connection.execute(attach).rowcount)
            connection.execute(_publish_again(id))
            again = turns.queue_again(connection, id, moment, verdicts=verdicts)
            turns.take_turns(connection, id, known.priority)
            turns.follow_urgency(connection, id)
            release_publications(connection, moment, JOBS.c.sweep_id == id)
            log_event(connection, moment, "retried", sweep_id=id, runs=again)
            return sweep_row(connection, id)

    def replace_result(
        self, id: str, was: str, answer: Stored, summary: Mapping[str, Any]
    ) -> tuple[str, ...]:
        """Give a run another result in place of the one with the SHA-256 ``was``; else nothing happens.

        Sweeps that were published with the earlier one, or are being published, are published again: their ids.
        """
        moment = now()
        file = {"path": answer.path, "size": answer.size, "sha256": answer.sha256}
        run = JOBS.update().where(JOBS.c.id == id, JOBS.c.sha256 == was)
        registered = ARTIFACTS.update().where(ARTIFACTS.c.job_id == id, ARTIFACTS.c.name == RESULT)
        using = sa.select(POINTS.c.sweep_id).where(POINTS.c.run_id == id, ~POINTS.c.detached)
        publication = JOBS.c.sweep_id.in_(using)
        stale = JOBS.update().where(publication, JOBS.c.state.in_([State.SUCCEEDED, State.RUNNING]))
        mark = stale.values(state=State.WAITING, crashes=0).returning(JOBS.c.sweep_id)
        with self._ordering() as connection:
            if not connection.execute(run.values(**file, summary=dict(summary))).rowcount:
                return ()
            connection.execute(registered.values(file))
            log_event(connection, moment, "remeasured", job_id=id, was=was, sha256=answer.sha256)
            marked = connection.scalars(mark).all()
            release_publications(connection, moment, publication)
            for sweep_id in marked:
                log_event(connection, moment, "outdated", sweep_id=sweep_id)
        return tuple(marked)

    def set_priority(self, id: str, priority: int) -> SweepRow:
        """Let a sweep's runs come sooner or later; a shared run follows the most urgent sweep."""
        with self._ordering() as connection:
            known = sweep_row(connection, id)
            if known.state in SWEEP_TERMINAL:
                raise Conflict(f"the sweep has ended; it is {known.state}")
            turns.open_lane(connection, priority)
            update = SWEEPS.update().where(SWEEPS.c.id == id)
            connection.execute(update.values(priority=priority))
            turns.follow_urgency(connection, id)
            log_event(connection, now(), "prioritised", sweep_id=id, priority=priority)
            return sweep_row(connection, id)

    def delete_sweep(self, id: str) -> None:
        """Forget a sweep that has ended; its runs stay for a while: other sweeps may ask for them."""
        own = sa.select(JOBS.c.id).where(JOBS.c.sweep_id == id)
        moment = now()
        let_go = JOBS.update().where(JOBS.c.id.in_(_runs_of(id))).values(abandoned=moment)
        with self._ordering() as connection:
            state = sweep_row(connection, id).state
            if state not in SWEEP_TERMINAL:
                raise Conflict(f"the sweep is {state}; cancel it, then delete it")
            connection.execute(let_go)
            connection.execute(ARTIFACTS.delete().where(ARTIFACTS.c.job_id.in_(own)))
            for table in (IDEMPOTENCY, POINTS, JOBS):
                connection.execute(table.delete().where(table.c.sweep_id == id))
            connection.execute(SWEEPS.delete().where(SWEEPS.c.id == id))
            log_event(connection, moment, "deleted", sweep_id=id)


def _publish_again(id: str) -> sa.Update:
    """Let a publication that has ended, or not begun, wait for its runs again."""
    wait = JOBS.update().where(JOBS.c.sweep_id == id, JOBS.c.state.in_(before(State.WAITING)))
    fresh = dict.fromkeys((*_ENDED, "witness"), sa.null())
    return wait.values(state=State.WAITING, crashes=0, **fresh)


# --- acceptance --------------------------------------------------------------------------------


def _accepted_before(connection: sa.Connection, asked: Submission) -> SweepRow | None:
    """The sweep that this idempotency key stands for already; raises KeyReused."""
    if asked.idempotency is None:
        return None
    key, digest = asked.idempotency
    query = sa.select(IDEMPOTENCY.c.digest, IDEMPOTENCY.c.sweep_id).where(
        IDEMPOTENCY.c.owner == asked.owner, IDEMPOTENCY.c.key == key
    )
    known = connection.execute(query).first()
    if known is None:
        return None
    if known.digest != digest:
        raise KeyReused(f"the key {key!r} was used for another body; take a new one")
    return sweep_row(connection, known.sweep_id)


def _accept(connection: sa.Connection, asked: Submission, rows: Acceptance) -> SweepRow:
    """Write the rows of a sweep, and join them to what is there."""
    id, moment = rows.sweep["id"], rows.sweep["created"]
    begin = turns.open_lane(connection, asked.priority)
    for job in rows.jobs:
        job["turn"] += begin
    inserted = insert_missing(connection, rows.jobs)
    connection.execute(SWEEPS.insert().values(rows.sweep))
    connection.execute(JOBS.insert().values(rows.publication))
    connection.execute(POINTS.insert(), rows.points)
    again = _join(connection, asked, id) if inserted < len(rows.jobs) else 0
    new = inserted + again
    connection.execute(SWEEPS.update().where(SWEEPS.c.id == id).values(new=new))
    release_publications(connection, moment, JOBS.c.sweep_id == id)
    if asked.idempotency is not None:
        key, digest = asked.idempotency
        noted = {"owner": asked.owner, "key": key, "digest": digest, "sweep_id": id}
        connection.execute(IDEMPOTENCY.insert().values(noted))
    planned = rows.sweep["planned"]
    log_event(connection, moment, "accepted", sweep_id=id, planned=planned, new=new)
    return sweep_row(connection, id)


def _join(connection: sa.Connection, asked: Submission, id: str) -> int:
    """Have the runs that were there before do what this sweep needs; return those queued again."""
    again = turns.queue_again(connection, id, now(), verdicts=False)
    turns.take_turns(connection, id, asked.priority)
    turns.follow_urgency(connection, id)
    return again


# --- cancel ------------------------------------------------------------------------------------


def _runs_of(id: str) -> sa.Select[tuple[str]]:
    return sa.select(POINTS.c.run_id).where(POINTS.c.sweep_id == id)


def _detach(id: str) -> sa.Update:
    """Let a sweep wait no longer for what is not done; nothing, unless it is waiting."""
    unfinished = sa.select(JOBS.c.id).where(JOBS.c.id.in_(_runs_of(id)), JOBS.c.state.in_(ACTIVE))
    waits = sa.exists().where(JOBS.c.sweep_id == id, JOBS.c.state == State.WAITING)
    return (
        POINTS.update()
        .where(POINTS.c.sweep_id == id, POINTS.c.detached.is_(False))
        .where(POINTS.c.run_id.in_(unfinished), waits)
        .values(detached=True)
    )


def _give_up(id: str, moment: object) -> sa.Update:
    """After the detachment, in one statement: what each run does, and the publication.

    A run goes on for others, or leaves the queue, or is to be stopped. Results are published; a
    sweep that has none has ended.
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
        .where(sa.or_(publication, JOBS.c.id.in_(_runs_of(id)) & JOBS.c.state.in_(ACTIVE)))
        .values(state=sa.type_coerce(state, JOBS.c.state.type))
        .values(finished=sa.case((sa.not_(goes_on) & ends, moment), else_=JOBS.c.finished))
        .values(queued=sa.case((is_run, JOBS.c.queued), else_=moment))
        .values(keep=keep_of(sa.not_(goes_on) & ends))
        .values(priority=sa.case((goes_on, URGENCY), else_=JOBS.c.priority))
        .values(turn=sa.case((goes_on, MOVED_TURN), else_=JOBS.c.turn))
    )
