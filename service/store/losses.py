"""Runs whose registered results were lost or damaged: computed again for those that still want them."""

from collections.abc import Sequence
from datetime import datetime

import sqlalchemy as sa

from service.jobs import BUDGET, TERMINAL, Cause, Claim, State
from service.losses import Loss
from service.store import turns
from service.store.queries import batches, log_event, release_publications, revive
from service.store.tables import ARTIFACTS, JOBS, POINTS, SWEEPS

FAILURE = "ResultLost"
REASON = "its registered result was lost or damaged"

# Their rows, as long as they have the results that were found to be lost.
_FORGET = (
    JOBS.update()
    .where(JOBS.c.id == sa.bindparam("run"), JOBS.c.sha256 == sa.bindparam("was"))
    .where(sa.or_(*(JOBS.c.state == state for state in TERMINAL)))  # a list fits no many at once
    .values(state=State.FAILED, cause=Cause.ERROR, failure=FAILURE, reason=REASON)
    .values(dict.fromkeys(("path", "size", "sha256", "summary", "seconds"), sa.null()))
    .values(crashes=JOBS.c.crashes + 1, crash_step=None)
)
_IS_FORGOTTEN = JOBS.c.failure == FAILURE


def forget_results(
    connection: sa.Connection, moment: datetime, claim: Claim, losses: Sequence[Loss]
) -> None:
    """Take lost results out of the rows, and queue their runs for those that wait for them.

    The publication of ``claim`` waits again. A sweep that was cancelled is published without them; so is
    every other where a disk lost one result as often as a run may crash.
    """
    assert claim.sweep_id is not None
    ids = [one.run_id for one in losses]
    connection.execute(_FORGET, [{"run": one.run_id, "was": one.sha256} for one in losses])
    for batch in batches(ids):
        gone = JOBS.c.id.in_(batch) & _IS_FORGOTTEN
        files = sa.select(JOBS.c.id).where(gone)
        connection.execute(ARTIFACTS.delete().where(ARTIFACTS.c.job_id.in_(files)))
        _detach_from_cancelled(connection, batch)
        _queue(connection, moment, gone)
    revive(connection, len(ids))
    priority = connection.execute(
        sa.select(SWEEPS.c.priority).where(SWEEPS.c.id == claim.sweep_id)
    ).scalar_one()
    turns.take_turns(connection, claim.sweep_id, priority)
    turns.follow_urgency(connection, claim.sweep_id)
    release_publications(connection, moment, JOBS.c.id == claim.id)
    for id in ids:
        log_event(connection, moment, "lost", job_id=id, reason=REASON)


def _detach_from_cancelled(connection: sa.Connection, ids: Sequence[str]) -> None:
    cancelled = sa.select(SWEEPS.c.id).where(SWEEPS.c.cancelled.is_not(None))
    detach = POINTS.update().where(POINTS.c.run_id.in_(ids), POINTS.c.sweep_id.in_(cancelled))
    connection.execute(detach.values(detached=True))


def _queue(connection: sa.Connection, moment: datetime, which: sa.ColumnElement[bool]) -> None:
    most = BUDGET[Cause.CRASH]
    again = JOBS.update().where(which, turns.IS_WANTED, JOBS.c.crashes < most)
    fresh = dict.fromkeys(("cause", "failure", "reason", "fraction", "finished"), sa.null())
    connection.execute(
        again.values(
            state=State.QUEUED, queued=moment, priority=turns.URGENCY, turn=turns.LAST
        ).values(fresh)
    )
