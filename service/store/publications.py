"""Publications: the cube and the report of a sweep, from the results of its runs.

A result that a publication finds lost or damaged is computed again for the sweeps that want it. Only a few at a time:
many lost results at once are a sign that part of the disk is not mounted.
"""

from collections.abc import Mapping, Sequence
from datetime import datetime, timedelta
from pathlib import Path
from typing import TYPE_CHECKING

import sqlalchemy as sa

from service.files.lost_results import Loss, TooManyLost, first_runs
from service.records.jobs import TERMINAL, Cause, Kind, Lease, Outcome, State, Stored
from service.store import fair_queueing, transitions
from service.store.connection import Repository
from service.store.events import log_attempts, log_event
from service.store.leases import count_attempt
from service.store.tables import (
    ARTIFACTS,
    CONTROL,
    EVENTS,
    HAS_RESULT,
    JOBS,
    POINT_STATE,
    POINTS,
    SWEEPS,
    StatementRow,
    batches,
    count,
    invalidate_tallies,
    now,
    one_row,
    runs_of,
    stored_record,
    sweeps_waiting_for,
)

if TYPE_CHECKING:
    from pydantic import JsonValue

LOST = "lost"  # kind of the event of a forgotten result
MOST_AT_ONCE, AT_ONCE = 5, timedelta(minutes=1)  # results that may be forgotten within this time
MOST_OF_ALL, LATELY = 0.01, timedelta(days=1)  # share of all registered ones; MOST_AT_ONCE at least

SweepIds = Sequence[str] | sa.Select[str]  # themselves, or a query of them


class Publications(Repository):
    """What a publication needs, what it has published, and the results that it found lost."""

    def inputs(self, sweep_id: str, root: Path) -> "tuple[Mapping[str, JsonValue], list[Outcome]]":
        """The document of a sweep, and how each of its points ended, with files below ``root``; raises NotFound."""
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
            rows = connection.execute(outcomes).all()
        return inputs, [_outcome(row, root) for row in rows]

    def files(self, sweep_id: str) -> tuple[Stored, ...]:
        """The published files of a sweep; none before its publication."""
        query = sa.select(ARTIFACTS).join(JOBS, JOBS.c.id == ARTIFACTS.c.job_id)
        query = query.where(JOBS.c.sweep_id == sweep_id).order_by(ARTIFACTS.c.name)
        return tuple(map(stored_record, self._database.rows(query)))

    def archived(self, sweep_id: str) -> dict[str, Stored]:
        """The published files of a sweep and those of its runs, by their paths in an archive of them all."""
        query = sa.select(ARTIFACTS, JOBS.c.kind).join(JOBS, JOBS.c.id == ARTIFACTS.c.job_id)
        query = query.where((JOBS.c.sweep_id == sweep_id) | JOBS.c.id.in_(runs_of(sweep_id)))
        rows = self._database.rows(query.order_by(JOBS.c.kind, JOBS.c.id, ARTIFACTS.c.name))
        return {
            f"runs/{row.job_id}/{row.name}" if row.kind == Kind.RUN else row.name: stored_record(row) for row in rows
        }

    def lose_results(self, lease: Lease, losses: Sequence[Loss], *, most: int) -> bool:
        """End a publication that found results of its runs lost: it waits until they are computed again.

        A run whose result was lost ``most`` times stays failed. Raises TooManyLost, and changes nothing, beyond the
        limits for all results.
        """
        moment = now()
        reason = f"results of {len(losses)} runs are lost"
        with self._database.writing() as connection:
            if not transitions.wait_again(connection, lease):
                return False
            _check_limits(connection, moment, losses)
            _forget_results(connection, moment, losses, most)
            count_attempt(connection, Cause.LOST)
            log_attempts(connection, moment, "requeued", lease, cause=Cause.LOST, reason=reason)
        return True

    def mend(self, damaged: Stored, *, most: int) -> bool:
        """Have a damaged file made again, and the sweeps that show it published again; False: no row names it.

        A result is forgotten like a lost one. A run of which another file is damaged is computed again, and its result
        stays until then. A job that is under way already is left alone, and so is what no sweep wants. Raises
        TooManyLost, and changes nothing, beyond the limits for all results.
        """
        moment = now()
        columns = [JOBS.c[name] for name in ("id", "kind", "state", "sweep_id", "path")]
        registered = (ARTIFACTS.c.path == damaged.path) & (ARTIFACTS.c.sha256 == damaged.sha256)
        with self._database.commanding() as connection:
            job = connection.execute(sa.select(*columns).join(ARTIFACTS).where(registered)).first()
            if job is None or job.state not in TERMINAL:
                return job is not None
            own: SweepIds = [job.sweep_id] if job.kind is Kind.PUBLISH else []
            if job.path:
                own = sweeps_waiting_for(job.id)
            marked = transitions.outdate_publications(connection, moment, JOBS.c.sweep_id.in_(own))
            losses = [Loss(job.id, damaged.path, damaged.sha256)]
            if job.path == damaged.path:
                _check_limits(connection, moment, losses)
                _forget_results(connection, moment, losses, most)
            elif _compute_again(connection, moment, own, JOBS.c.id == job.id) or marked:
                _check_limits(connection, moment, losses)
                log_event(connection, moment, LOST, job_id=job.id, reason=f"{damaged.name} was lost or damaged")
        return True


def _outcome(row: StatementRow, root: Path) -> Outcome:
    path = str(root / row.path) if row.path and row.state in (State.SUCCEEDED, State.FAILED) else None
    return {"run_id": row.run_id, "state": row.state, "reason": row.reason, "path": path, "sha256": row.sha256}


def _forget_results(connection: sa.Connection, moment: datetime, losses: Sequence[Loss], most: int) -> None:
    """Take lost results out of the rows, and queue their runs for the sweeps that have them and are not published yet.

    A cancelled sweep is published without them, and so is every sweep with a result that was lost ``most`` times.
    """
    ids = [loss.run_id for loss in losses]
    transitions.forget_results(connection, {loss.run_id: loss.sha256 for loss in losses})
    cancelled = sa.select(SWEEPS.c.id).where(SWEEPS.c.cancelled.is_not(None))
    for batch in batches(ids):
        gone = JOBS.c.id.in_(batch) & (JOBS.c.failure == transitions.RESULT_LOST)
        files = sa.select(JOBS.c.id).where(gone)
        connection.execute(ARTIFACTS.delete().where(ARTIFACTS.c.job_id.in_(files)))
        of_cancelled = POINTS.update().where(POINTS.c.run_id.in_(batch), POINTS.c.sweep_id.in_(cancelled))
        connection.execute(of_cancelled.values(detached=True))
        sharing = sa.select(POINTS.c.sweep_id).where(POINTS.c.run_id.in_(batch))
        due = JOBS.c.sweep_id.in_(sharing.where(~POINTS.c.detached)) & (JOBS.c.state != State.SUCCEEDED)
        transitions.outdate_publications(connection, moment, due)
        _compute_again(connection, moment, sharing, gone & (JOBS.c.crashes < most))
    for id in ids:
        log_event(connection, moment, LOST, job_id=id, reason=transitions.LOST_REASON)


def _check_limits(connection: sa.Connection, moment: datetime, losses: Sequence[Loss]) -> None:
    """Raise TooManyLost beyond the limits, unless ``whipple doctor --forget-lost`` has allowed it."""
    lost = len(losses)
    allow = CONTROL.update().where(CONTROL.c.forgettable >= lost)
    if connection.execute(allow.values(forgettable=CONTROL.c.forgettable - lost)).rowcount:
        return
    results = count(connection, HAS_RESULT)
    most_lately = max(MOST_AT_ONCE, int(MOST_OF_ALL * results))
    forgotten = EVENTS.c.kind == LOST
    at_once = lost + count(connection, forgotten, EVENTS.c.time > moment - AT_ONCE)
    lately = lost + count(connection, forgotten, EVENTS.c.time > moment - LATELY)
    if at_once > MOST_AT_ONCE or lately > most_lately:
        raise TooManyLost(
            f"{lost} of {results} registered results are lost or damaged ({first_runs(losses)}), and no more than "
            f"{MOST_AT_ONCE} a minute and {most_lately} a day are forgotten; restore their files, or have "
            f"the results computed again: `whipple doctor --forget-lost {lost}`"
        )


def _compute_again(connection: sa.Connection, moment: datetime, sweeps: SweepIds, which: sa.ColumnElement[bool]) -> int:
    """Queue those runs, among ``which``, that sweeps wait for, and return their number.

    Of ``sweeps`` those that wait for no run are published.
    """
    queued = transitions.compute_again(connection, moment, which)
    invalidate_tallies(connection, 1)
    waiting = JOBS.c.sweep_id.in_(sweeps) & (JOBS.c.state == State.WAITING)
    for id in connection.scalars(sa.select(JOBS.c.sweep_id).where(waiting)).all():
        fair_queueing.schedule(connection, id)
    transitions.release_publications(connection, moment, waiting)
    return queued
