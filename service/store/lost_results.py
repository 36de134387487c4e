"""Runs whose registered results were lost or damaged: computed again for the sweeps that want them.

Only a few at a time: many lost results at once are a sign that part of the disk is not mounted.
"""

from collections.abc import Sequence
from datetime import datetime, timedelta

import sqlalchemy as sa

from service.files.lost_results import Loss, TooManyLost, first_runs
from service.records.jobs import BUDGET, TERMINAL, Cause, Kind, Lease, State
from service.store import fair_queueing
from service.store.statements import batches, invalidate_tallies, log_event, release_publications
from service.store.tables import ARTIFACTS, CONTROL, EVENTS, JOBS, POINTS, SWEEPS

FAILURE = "ResultLost"
REASON = "its registered result was lost or damaged"
LOST = "lost"  # kind of the event of a forgotten result
MOST_AT_ONCE, AT_ONCE = 5, timedelta(minutes=1)  # results that may be forgotten within this time
MOST_OF_ALL, LATELY = 0.01, timedelta(days=1)  # share of all registered ones; MOST_AT_ONCE at least

# Only rows that still have the results that were found to be lost.
_FORGET = (
    JOBS.update()
    .where(JOBS.c.id == sa.bindparam("run"), JOBS.c.sha256 == sa.bindparam("was"))
    # Not IN: the statement runs for many at once.
    .where(sa.or_(*(JOBS.c.state == state for state in TERMINAL)))
    .values(state=State.FAILED, cause=Cause.ERROR, failure=FAILURE, reason=REASON)
    .values(dict.fromkeys(("path", "size", "sha256", "summary", "seconds"), sa.null()))
    .values(crashes=JOBS.c.crashes + 1, crash_step=None)
)
_IS_FORGOTTEN = JOBS.c.failure == FAILURE


def forget_results(connection: sa.Connection, moment: datetime, lease: Lease, losses: Sequence[Loss]) -> None:
    """Take lost results out of the rows, and queue their runs for those that wait for them.

    The publication of ``lease`` waits again. A cancelled sweep is published without them, and so is
    every sweep with a result that was lost as often as a run may crash. Raises TooManyLost.
    """
    assert lease.sweep_id is not None
    _check_limits(connection, moment, losses)
    ids = [loss.run_id for loss in losses]
    connection.execute(_FORGET, [{"run": loss.run_id, "was": loss.sha256} for loss in losses])
    for batch in batches(ids):
        gone = JOBS.c.id.in_(batch) & _IS_FORGOTTEN
        files = sa.select(JOBS.c.id).where(gone)
        connection.execute(ARTIFACTS.delete().where(ARTIFACTS.c.job_id.in_(files)))
        _detach_from_cancelled(connection, batch)
        _queue(connection, moment, gone)
    invalidate_tallies(connection, len(ids))
    priority = connection.execute(sa.select(SWEEPS.c.priority).where(SWEEPS.c.id == lease.sweep_id)).scalar_one()
    fair_queueing.schedule(connection, lease.sweep_id, priority)
    release_publications(connection, moment, JOBS.c.id == lease.id)
    for id in ids:
        log_event(connection, moment, LOST, job_id=id, reason=REASON)


def _check_limits(connection: sa.Connection, moment: datetime, losses: Sequence[Loss]) -> None:
    """Raise TooManyLost beyond the limits, unless ``whipple forget-lost`` has allowed it."""
    count = len(losses)
    allow = CONTROL.update().where(CONTROL.c.forgettable >= count)
    if connection.execute(allow.values(forgettable=CONTROL.c.forgettable - count)).rowcount:
        return
    is_registered = (JOBS.c.kind == Kind.RUN) & JOBS.c.path.is_not(None)
    results = connection.execute(sa.select(sa.func.count()).where(is_registered)).scalar_one()
    most_lately = max(MOST_AT_ONCE, int(MOST_OF_ALL * results))
    at_once = count + _forgotten(connection, moment - AT_ONCE)
    lately = count + _forgotten(connection, moment - LATELY)
    if at_once > MOST_AT_ONCE or lately > most_lately:
        raise TooManyLost(
            f"{count} of {results} registered results are lost or damaged ({first_runs(losses)}), and no more than "
            f"{MOST_AT_ONCE} a minute and {most_lately} a day are forgotten; restore their files, or have "
            f"the results computed again: `whipple forget-lost {count}`"
        )


def _forgotten(connection: sa.Connection, since: datetime) -> int:
    """Number of results forgotten since a moment."""
    count = sa.select(sa.func.count()).where(EVENTS.c.kind == LOST, EVENTS.c.time > since)
    return connection.execute(count).scalar_one()


def _detach_from_cancelled(connection: sa.Connection, ids: Sequence[str]) -> None:
    cancelled = sa.select(SWEEPS.c.id).where(SWEEPS.c.cancelled.is_not(None))
    detach = POINTS.update().where(POINTS.c.run_id.in_(ids), POINTS.c.sweep_id.in_(cancelled))
    connection.execute(detach.values(detached=True))


def _queue(connection: sa.Connection, moment: datetime, which: sa.ColumnElement[bool]) -> None:
    most = BUDGET[Cause.CRASH]
    again = JOBS.update().where(which, fair_queueing.IS_WANTED, JOBS.c.crashes < most)
    fresh = dict.fromkeys(("cause", "failure", "reason", "fraction", "finished"), sa.null())
    connection.execute(
        again.values(
            state=State.QUEUED, queued=moment, priority=fair_queueing.URGENCY, virtual_time=fair_queueing.LAST
        ).values(fresh)
    )
