"""What the dispatcher does with the queue: claim, and say how each attempt ended.

Every update names job, attempt and epoch, and has no effect (it returns False) when they no longer
are the ones that count: an attempt that was given up cannot overwrite the work of its successor.
"""

import secrets
from collections.abc import Mapping, Sequence
from typing import Any

import sqlalchemy as sa

from service.jobs import Cause, Claim, Kind, Outcome, Result, State, Stored, before
from service.store.connection import Database
from service.store.queries import (
    CLAIM_COLUMNS,
    IS_WANTED,
    POINT_STATE,
    TURN,
    batches,
    is_held,
    log_attempt,
    now,
    one_row,
    release_publications,
)
from service.store.rows import claim_record
from service.store.tables import ARTIFACTS, DISPATCHERS, JOBS, POINTS, SWEEPS


class Queue:
    """Jobs in the order of their turn."""

    def __init__(self, database: Database):
        self._database = database

    def begin_epoch(self, owner: str) -> int:
        """Number of a new reign of a dispatcher; claims of earlier ones are foreign to it."""
        begin = DISPATCHERS.insert().values(owner=owner, started=now())
        with self._database.writing() as connection:
            return connection.execute(begin.returning(DISPATCHERS.c.epoch)).scalar_one()

    def claim(self, limit: int, epoch: int) -> tuple[Claim, ...]:
        """Take up to ``limit`` queued jobs: publications first, then in the order of asking."""
        moment = now()
        head = (
            sa.select(JOBS.c.id)
            .where(JOBS.c.state == State.QUEUED)
            .order_by(*TURN)
            .limit(limit)
            .with_for_update(skip_locked=True)
        )
        take = (
            JOBS.update()
            .where(JOBS.c.id.in_(head))
            .values(state=State.RUNNING, attempt=JOBS.c.attempt + 1, epoch=epoch)
            .values(token=secrets.token_hex(4), started=moment)
            .values(fraction=sa.null(), progress=sa.null(), seconds=sa.null())
            .returning(*CLAIM_COLUMNS, *TURN)
        )
        with self._database.writing() as connection:
            rows = connection.execute(take).all()
            rows = sorted(rows, key=lambda row: (row.priority, row.queued, row.ordinal))
            claims = tuple(claim_record(row) for row in rows)
            for claim in claims:
                log_attempt(connection, moment, "started", claim)
        return claims

    def claimed(self) -> tuple[Claim, ...]:
        """Every job that is running or being stopped, whoever claimed it."""
        held = JOBS.c.state.in_([State.RUNNING, State.CANCELLING])
        with self._database.reading() as connection:
            rows = connection.execute(sa.select(*CLAIM_COLUMNS).where(held))
            return tuple(claim_record(row) for row in rows)

    def question(self, sweep_id: str) -> tuple[Mapping[str, Any], tuple[Outcome, ...]]:
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
            return text, tuple(Outcome(**row._mapping) for row in connection.execute(outcomes))

    def forgotten(self, sweep_ids: Sequence[str]) -> set[str]:
        """Those of these ids that no sweep has."""
        with self._database.reading() as connection:
            known: set[str] = set()
            for batch in batches(sweep_ids):
                query = sa.select(SWEEPS.c.id).where(SWEEPS.c.id.in_(batch))
                known.update(connection.execute(query).scalars())
        return set(sweep_ids) - known

    def progress(self, news: Sequence[tuple[Claim, float, float, Mapping[str, Any]]]) -> None:
        """Note how far attempts are: claim, fraction, seconds so far, the solver's own words."""
        with self._database.writing() as connection:
            for claim, fraction, seconds, words in news:
                connection.execute(
                    JOBS.update()
                    .where(is_held(claim))
                    .values(fraction=fraction, seconds=seconds, progress=dict(words))
                )

    def finish(self, claim: Claim, result: Result) -> bool:
        """Register the result of a run: a success, or the solver's verdict."""
        return self._end(
            claim,
            state=State.SUCCEEDED if result.succeeded else State.FAILED,
            cause=None if result.succeeded else Cause.VERDICT,
            failure=result.failure,
            reason=result.reason,
            summary=dict(result.summary),
            path=result.file.path,
            size=result.file.size,
            sha256=result.file.sha256,
            seconds=result.seconds,
            fraction=1.0,
        )

    def fail(self, claim: Claim, cause: Cause, *, failure: str, reason: str) -> bool:
        """End a job for good without a result."""
        crashes = JOBS.c.crashes + int(cause is Cause.CRASH)
        words = {"cause": cause, "failure": failure, "reason": reason}
        return self._end(claim, state=State.FAILED, crashes=crashes, **words)

    def requeue(self, claim: Claim, cause: Cause, *, reason: str) -> bool:
        """Put an attempt without result back into the queue, or to rest if nobody waits for it."""
        moment = now()
        to_rest = sa.and_(JOBS.c.kind == Kind.RUN, sa.not_(IS_WANTED))
        state = sa.case((to_rest, State.CANCELLED.value), else_=State.QUEUED.value)
        put_back = (
            JOBS.update()
            .where(is_held(claim))
            .values(state=sa.type_coerce(state, JOBS.c.state.type))
            .values(crashes=JOBS.c.crashes + int(cause is Cause.CRASH))
            .values(fraction=sa.null(), progress=sa.null(), seconds=sa.null())
            .returning(JOBS.c.state)
        )
        with self._database.writing() as connection:
            outcome = connection.execute(put_back).scalar()
            if outcome is State.CANCELLED:
                log_attempt(connection, moment, "cancelled", claim)
            elif outcome is State.QUEUED:
                log_attempt(connection, moment, "requeued", claim, cause=cause, reason=reason)
        return outcome is not None

    def publish(self, claim: Claim, files: Sequence[Stored], *, seconds: float) -> bool:
        """Register the files of a publication, in place of earlier ones, all at once."""
        moment = now()
        end = {"state": State.SUCCEEDED, "seconds": seconds, "finished": moment}
        with self._database.writing() as connection:
            if not connection.execute(JOBS.update().where(is_held(claim)).values(end)).rowcount:
                return False
            own = {"sweep_id": claim.sweep_id}
            connection.execute(ARTIFACTS.delete().where(ARTIFACTS.c.sweep_id == claim.sweep_id))
            connection.execute(ARTIFACTS.insert(), [{**vars(file), **own} for file in files])
            names = [file.name for file in files]
            log_attempt(connection, moment, "published", claim, files=names)
        return True

    def _end(self, claim: Claim, *, state: State, **values: Any) -> bool:
        """End a held job, and queue the publications that waited for it alone."""
        moment = now()
        end = JOBS.update().where(is_held(claim), JOBS.c.state.in_(before(state)))
        with self._database.writing() as connection:
            values |= {"state": state, "finished": moment}
            if not connection.execute(end.values(values)).rowcount:
                return False
            waiting = sa.select(POINTS.c.sweep_id).where(POINTS.c.run_id == claim.id)
            release_publications(connection, moment, JOBS.c.sweep_id.in_(waiting))
            told = {key: values[key] for key in ("cause", "reason") if values[key] is not None}
            log_attempt(connection, moment, state, claim, **told)
        return True
