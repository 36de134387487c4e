"""Whose turn it is: fairness between sweeps, and the priority of runs that sweeps share.

Start-time fair queueing (Goyal, Vin, Cheng 1996) by estimated cost. The runs of one priority are a
lane, and the lane's time is the turn of the run claimed last. A sweep that is accepted takes its
turns from there: each run comes as much later as the sweep's unfinished runs before it cost. So two
sweeps get equal shares of the cores while both have work, however long the older one is. Lanes have
times of their own, because an urgent sweep that passes all others must not leave its long way to
those who come later. A run that goes to another lane keeps its distance from the lane's time.
"""

from datetime import datetime
from typing import Any

import sqlalchemy as sa

from service.jobs import ACTIVE, Kind, State
from service.store.queries import PUBLICATIONS, ended_by_accident, insert_into
from service.store.tables import ARTIFACTS, JOBS, LANES, POINTS, SWEEPS

LAST = 1e300  # a turn after every other
TURN = [JOBS.c.priority, JOBS.c.turn, JOBS.c.ordinal]

# The priority of a run: that of the most urgent sweep that waits for it. NULL: none does, for one
# that is being published, or is done, does not.
URGENCY = (
    sa.select(sa.func.min(SWEEPS.c.priority))
    .join_from(POINTS, SWEEPS, SWEEPS.c.id == POINTS.c.sweep_id)
    .join(PUBLICATIONS, PUBLICATIONS.c.sweep_id == POINTS.c.sweep_id)
    .where(POINTS.c.run_id == JOBS.c.id, POINTS.c.detached.is_(False))
    .where(PUBLICATIONS.c.state == State.WAITING)
    .correlate(JOBS)
    .scalar_subquery()
)
IS_WANTED = URGENCY.is_not(None)


def _time_of(priority: sa.ColumnElement[Any]) -> sa.ColumnElement[float]:
    """How far a lane has come."""
    query = sa.select(LANES.c.turn).where(LANES.c.priority == priority)
    return sa.func.coalesce(query.correlate(JOBS).scalar_subquery(), 0.0)


# The turn of a run that goes into the lane of its urgency.
MOVED_TURN = JOBS.c.turn - _time_of(JOBS.c.priority) + _time_of(URGENCY)


def open_lane(connection: sa.Connection, priority: int) -> float:
    """How far the lane of a priority has come; there is one afterwards."""
    new = insert_into(connection, LANES).values(priority=priority, turn=0.0)
    connection.execute(new.on_conflict_do_nothing())
    query = sa.select(LANES.c.turn).where(LANES.c.priority == priority)
    return connection.execute(query).scalar_one()


def advance_lanes(connection: sa.Connection, turns: dict[int, float]) -> None:
    """Note the turns claimed last, by priority."""
    advance = LANES.update().where(
        LANES.c.priority == sa.bindparam("lane"), LANES.c.turn < sa.bindparam("reached")
    )
    connection.execute(
        advance.values(turn=sa.bindparam("reached")),
        [{"lane": priority, "reached": turn} for priority, turn in turns.items()],
    )


def queue_again(
    connection: sa.Connection, sweep_id: str, moment: datetime, *, verdicts: bool
) -> int:
    """Queue the runs of a sweep that ended by accident, with fresh budgets; return their number.

    They have no turn yet: ``take_turns`` gives them one.
    """
    own = sa.select(POINTS.c.run_id).where(POINTS.c.sweep_id == sweep_id)
    again = JOBS.c.id.in_(own) & ended_by_accident(verdicts=verdicts)
    priority = sa.select(SWEEPS.c.priority).where(SWEEPS.c.id == sweep_id).scalar_subquery()
    words = ("cause", "failure", "reason", "summary", "path", "size", "sha256", "finished")
    nothing = dict.fromkeys((*words, "crash_step"), sa.null())
    ended = sa.select(JOBS.c.id).where(again)
    connection.execute(ARTIFACTS.delete().where(ARTIFACTS.c.job_id.in_(ended)))
    queue = JOBS.update().where(again).values(state=State.QUEUED, queued=moment, crashes=0)
    queue = queue.values(priority=priority, turn=LAST, **nothing)
    return connection.execute(queue).rowcount


def take_turns(connection: sa.Connection, sweep_id: str, priority: int) -> None:
    """Let the queued runs of a sweep come as early as it may ask for; joined ones come no later."""
    begin = open_lane(connection, priority)
    runs = JOBS.alias("runs")
    queued = (
        sa.select(runs.c.id, runs.c.cost, sa.func.min(POINTS.c.ordinal).label("place"))
        .join_from(POINTS, runs, runs.c.id == POINTS.c.run_id)
        .where(POINTS.c.sweep_id == sweep_id, runs.c.state == State.QUEUED)
        .group_by(runs.c.id, runs.c.cost)
        .subquery()
    )
    ahead = sa.func.sum(queued.c.cost).over(order_by=queued.c.place) - queued.c.cost
    asked = sa.select(queued.c.id, (begin + ahead).label("turn")).subquery()
    is_sooner = (JOBS.c.priority == priority) & (JOBS.c.turn > asked.c.turn)
    connection.execute(
        JOBS.update()
        .where(JOBS.c.id == asked.c.id, is_sooner | (JOBS.c.priority > priority))
        .values(priority=priority, turn=asked.c.turn)
    )


def follow_urgency(connection: sa.Connection, sweep_id: str) -> None:
    """Move the unfinished runs of a sweep into the lanes of those that wait for them."""
    own = sa.select(POINTS.c.run_id).where(POINTS.c.sweep_id == sweep_id)
    connection.execute(
        JOBS.update()
        .where(JOBS.c.id.in_(own), JOBS.c.kind == Kind.RUN, JOBS.c.state.in_(ACTIVE))
        .where(JOBS.c.priority != URGENCY)
        .values(priority=URGENCY, turn=MOVED_TURN)
    )
