"""What the dispatcher does with the queue: claim, and say how each attempt ended.

Every update names job, attempt and epoch, and has no effect (it returns False, or None) when they no
longer are the ones that count: an attempt that was given up cannot overwrite the work of its successor.
"""

import secrets
from collections.abc import Collection, Mapping, Sequence
from dataclasses import replace
from typing import Any

import sqlalchemy as sa

from service.files.lost_results import Loss
from service.records.fault_points import point
from service.records.jobs import (
    Cause,
    Claim,
    Keep,
    Kind,
    PublishedRun,
    Result,
    State,
    Stored,
    before,
    crashes_before,
)
from service.store import leadership
from service.store.connection import Part
from service.store.leadership import Leadership
from service.store.losses import forget_results
from service.store.queries import (
    CLAIM_COLUMNS,
    IS_HELD,
    POINT_STATE,
    count_attempt,
    given_up,
    held_by,
    hold_publications,
    is_held,
    keep_of,
    log_attempt,
    log_attempts,
    now,
    one_row,
    register_files,
    release_publications,
    unless_result,
)
from service.store.rows import PUBLISH_PRIORITY, Row, claim_record
from service.store.tables import ARTIFACTS, CONTROL, DISPATCHERS, JOBS, POINTS, SWEEPS
from service.store.turns import IS_WANTED, TURN, advance_lanes, queue_for_film


class Queue(Part):
    """Jobs in the order of their turn."""

    # --- reigns ----------------------------------------------------------------------------------

    def lead(self, owner: str) -> Leadership | None:
        """Become the one who works through the queue; None: another service is."""
        return leadership.lead(self._database, owner)

    def begin_epoch(self, owner: str) -> int:
        """Number of a new reign of a dispatcher; earlier ones can claim nothing any more."""
        begin = DISPATCHERS.insert().values(owner=owner, started=now())
        with self._database.writing() as connection:
            return connection.execute(begin.returning(DISPATCHERS.c.epoch)).scalar_one()

    def hinder(self, reason: str | None, epoch: int | None = None) -> None:
        """Say why nothing is begun although there is work, or that nothing hinders any more.

        Without effect for an epoch that has ended; None: there is none yet.
        """
        say = CONTROL.update().values(hindrance=reason)
        if epoch is not None:
            say = say.where(sa.not_(sa.exists().where(DISPATCHERS.c.epoch > epoch)))
        with self._database.writing() as connection:
            connection.execute(say)

    # --- claims ----------------------------------------------------------------------------------

    def claim(
        self,
        limit: int,
        epoch: int,
        *,
        publications_only: bool = False,
        resting: Collection[str] = (),
    ) -> tuple[Claim, ...]:
        """Take up to ``limit`` queued jobs: publications first, then runs by priority and turn.

        Nothing for a reign that has ended; publications only while the queue is paused, or on request;
        none of those that are ``resting``.
        """
        moment = now()
        head = sa.select(JOBS.c.id).where(JOBS.c.state == State.QUEUED).order_by(*TURN).limit(limit)
        with self._database.writing() as connection:
            paused, has_ended = connection.execute(_standing(epoch)).one()
            if has_ended:
                return ()
            if paused is not None or publications_only:
                head = head.where(JOBS.c.priority == PUBLISH_PRIORITY)
            if resting:
                head = head.where(JOBS.c.id.not_in(resting))
            rows = connection.execute(_take(head, epoch)).all()
            if not rows:
                return ()
            taken = sorted(rows, key=lambda row: (row.priority, row.turn, row.ordinal))
            claims = tuple(claim_record(row) for row in taken)
            # In order, so that the last turn of each priority is the one that stays.
            advance_lanes(connection, {row.priority: row.turn for row in taken})
            log_attempts(connection, moment, "started", claims)
        return claims

    def adopt(self, claim: Claim, epoch: int) -> Claim | None:
        """Carry an attempt of an earlier reign on under this one; None: it no longer counts."""
        with self._database.writing() as connection:
            if connection.execute(_standing(epoch)).one().has_ended:
                return None
            update = JOBS.update().where(is_held(claim)).values(epoch=epoch)
            row = connection.execute(update.returning(*CLAIM_COLUMNS)).first()
            if row is None:
                return None
            log_attempt(connection, now(), "adopted", claim)
        return _found(row)

    def claimed(self) -> tuple[Claim, ...]:
        """Every job that is running or being stopped, whoever claimed it."""
        held = JOBS.c.state.in_([State.RUNNING, State.CANCELLING])
        with self._database.reading() as connection:
            rows = connection.execute(sa.select(*CLAIM_COLUMNS).where(held))
            return tuple(_found(row) for row in rows)

    def question(self, sweep_id: str) -> tuple[Mapping[str, Any], tuple[PublishedRun, ...]]:
        """What a publication works on: the sweep's document, and how each of its points ended."""
        document = sa.select(SWEEPS.c.document).where(SWEEPS.c.id == sweep_id)
        outcomes = (
            sa.select(POINTS.c.run_id, POINT_STATE.label("state"))
            .add_columns(JOBS.c.reason, JOBS.c.path, JOBS.c.sha256)
            .join_from(POINTS, JOBS, JOBS.c.id == POINTS.c.run_id)
            .where(POINTS.c.sweep_id == sweep_id)
            .order_by(POINTS.c.ordinal)
        )
        with self._database.reading() as connection:
            text = one_row(connection, document, "sweep", sweep_id).document
            return text, tuple(PublishedRun(**row._mapping) for row in connection.execute(outcomes))

    # --- news of attempts ------------------------------------------------------------------------

    def progress(self, news: Sequence[tuple[Claim, float, float, Mapping[str, Any]]]) -> None:
        """Note how far attempts are: claim, fraction, seconds so far, the solver's own words."""
        rows = [
            {**held_by(claim), "now_at": fraction, "spent": seconds, "said": dict(words)}
            for claim, fraction, seconds, words in news
        ]
        self._note(rows, fraction="now_at", seconds="spent", progress="said")

    def checkpointed(self, news: Sequence[tuple[Claim, int]]) -> None:
        """Note the step of the last checkpoint of attempts."""
        rows = [{**held_by(claim), "saved": step} for claim, step in news]
        self._note(rows, checkpoint="saved")

    def _note(self, rows: Sequence[Mapping[str, Any]], **columns: str) -> None:
        """Write news of attempts that still count; ``columns`` says which word goes where."""
        values = {
            name: sa.bindparam(word, type_=JOBS.c[name].type) for name, word in columns.items()
        }
        if rows:
            with self._database.writing() as connection:
                connection.execute(JOBS.update().where(IS_HELD).values(values), rows)

    # --- ends ------------------------------------------------------------------------------------

    def finish(self, claim: Claim, result: Result) -> bool:
        """Register the result of a run: a success, or the solver's verdict."""
        end: dict[str, Any] = {
            "state": State.SUCCEEDED if result.succeeded else State.FAILED,
            "cause": None if result.succeeded else Cause.VERDICT,
            "failure": result.failure,
            "reason": result.reason,
            "summary": dict(result.summary),
            "path": result.answer.path,
            "size": result.answer.size,
            "sha256": result.answer.sha256,
            "seconds": result.seconds,
            "fraction": 1.0,
            "checkpoint": None,
        }
        told = {name: end[name] for name in ("cause", "reason") if end[name] is not None}
        return self._end(claim, end["state"], end, files=result.files, told=told)

    def fail(
        self,
        claim: Claim,
        cause: Cause,
        *,
        failure: str,
        reason: str,
        crash_step: int | None = None,
        files: Sequence[Stored] = (),
    ) -> bool:
        """End a job without a new result, for good; ``files`` say more about it, as its log does.

        A run that had a result before goes back to it. Its checkpoint stays, for a retry.
        """
        words = unless_result(cause=cause, failure=failure, reason=reason)
        state = sa.type_coerce(given_up(State.FAILED), JOBS.c.state.type)
        end = {
            "state": state,
            "keep": keep_of(sa.true()),
            **words,
            **_charged(claim, cause, crash_step),
        }
        told = {"cause": cause, "reason": reason}
        return self._end(claim, State.FAILED, end, files=files, told=told)

    def requeue(
        self, claim: Claim, cause: Cause, *, reason: str, crash_step: int | None = None
    ) -> State | None:
        """Put an attempt without result back into the queue, or end its job if nobody waits for it.

        Returns the state that the job has then; None: the attempt no longer counts. ``crash_step`` is
        the step of the last checkpoint of an attempt that crashed.
        """
        moment = now()
        to_rest = sa.and_(JOBS.c.kind == Kind.RUN, sa.not_(IS_WANTED))
        state = sa.case((to_rest, given_up(State.CANCELLED)), else_=State.QUEUED.value)
        put_back = (
            JOBS.update()
            .where(is_held(claim))
            .values(state=sa.type_coerce(state, JOBS.c.state.type))
            .values(finished=sa.case((to_rest, moment), else_=sa.null()))
            .values(fraction=sa.null(), progress=sa.null(), seconds=sa.null())
            .values(keep=keep_of(to_rest))
            .values(_charged(claim, cause, crash_step))
            .returning(JOBS.c.state)
        )
        with self._database.writing() as connection:
            outcome: State | None = connection.execute(put_back).scalar()
            if outcome is State.QUEUED:
                hold_publications(connection, JOBS.c.id == claim.id)
                count_attempt(connection, cause)
                log_attempt(connection, moment, "requeued", claim, cause=cause, reason=reason)
            elif outcome is not None:
                log_attempt(connection, moment, "cancelled", claim)
        return outcome

    def lose_results(self, claim: Claim, losses: Sequence[Loss]) -> bool:
        """End a publication that found results of its runs lost: it waits until they are computed again.

        Raises TooManyLost, and changes nothing, where these are more than a disk loses now and then.
        """
        moment = now()
        wait = JOBS.update().where(is_held(claim)).values(state=State.WAITING, witness=sa.null())
        wait = wait.values(fraction=sa.null(), progress=sa.null(), seconds=sa.null())
        with self._database.writing() as connection:
            if not connection.execute(wait).rowcount:
                return False
            forget_results(connection, moment, claim, losses)
            count_attempt(connection, Cause.LOST)
            told = {"cause": Cause.LOST, "reason": f"results of {len(losses)} runs are lost"}
            log_attempt(connection, moment, "requeued", claim, **told)
        return True

    def publish(self, claim: Claim, files: Sequence[Stored], *, seconds: float) -> bool:
        """Register the files of a publication, in place of earlier ones, all at once."""
        moment = now()
        end = {"state": State.SUCCEEDED, "seconds": seconds, "finished": moment}
        with self._database.writing() as connection:
            if not connection.execute(JOBS.update().where(is_held(claim)).values(end)).rowcount:
                return False
            connection.execute(ARTIFACTS.delete().where(ARTIFACTS.c.job_id == claim.id))
            register_files(connection, claim.id, files)
            names = [file.name for file in files]
            log_attempt(connection, moment, "published", claim, files=names)
            point("publication-before-commit")
        return True

    def _end(
        self,
        claim: Claim,
        state: State,
        values: Mapping[str, Any],
        *,
        files: Sequence[Stored],
        told: Mapping[str, Any],
    ) -> bool:
        """End a held job, and queue the publications that waited for it alone."""
        moment = now()
        end = JOBS.update().where(is_held(claim), JOBS.c.state.in_(before(state)))
        with self._database.writing() as connection:
            end = end.values(**values, finished=moment).returning(JOBS.c.path)
            row = connection.execute(end).first()
            if row is None:
                return False
            if row.path == values.get("path"):  # else it went back to an earlier result
                register_files(connection, claim.id, files)
            queue_for_film(connection, claim, moment)
            waiting = sa.select(POINTS.c.sweep_id).where(POINTS.c.run_id == claim.id)
            release_publications(connection, moment, JOBS.c.sweep_id.in_(waiting))
            log_attempt(connection, moment, state, claim, **told)
            if "cause" in told:
                count_attempt(connection, told["cause"])
            point("result-before-commit")
        return True


def _found(row: Row) -> Claim:
    """The claim of an attempt that has begun: what it was told to keep may be less than its row says now."""
    return replace(claim_record(row), keep=Keep.NUMBERS)


def _standing(epoch: int) -> sa.Select[Any]:
    """Whether the queue is paused, and whether a younger reign has ended this one."""
    younger = sa.exists().where(DISPATCHERS.c.epoch > epoch)
    return sa.select(CONTROL.c.paused, younger.label("has_ended"))


def _take(head: sa.Select[Any], epoch: int) -> sa.Update:
    """Give each of these jobs a new attempt."""
    return (
        JOBS.update()
        .where(JOBS.c.id.in_(head))
        .values(state=State.RUNNING, attempt=JOBS.c.attempt + 1, epoch=epoch)
        .values(token=secrets.token_hex(4), started=now())
        .values(fraction=sa.null(), progress=sa.null(), seconds=sa.null())
        .returning(*CLAIM_COLUMNS, JOBS.c.turn, JOBS.c.ordinal)
    )


def _charged(claim: Claim, cause: Cause, step: int | None) -> dict[str, Any]:
    """What a row says of crashes after one more attempt; only a crash changes it."""
    if cause is not Cause.CRASH:
        return {}
    furthest = max(step or 0, claim.crash_step or 0)
    return {"crashes": crashes_before(claim, step) + 1, "crash_step": furthest}
