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

from service.records.jobs import ACTIVE, KEPT_BY, Claim, Keep, Kind, State, at_least
from service.store.queries import (
    HAS_RESULT,
    PUBLICATIONS,
    ended_by_accident,
    hold_publications,
    insert_into,
    revive,
    unless_result,
)
from service.store.tables import ARTIFACTS, JOBS, LANES, POINTS, SWEEPS
from studies.values.files import FILM

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

    So are those that succeeded and lack a file that the sweep keeps. A result, or a verdict, stays
    until there is another: other sweeps may have it. They have no turn yet: ``take_turns`` gives
    them one.
    """
    own = sa.select(POINTS.c.run_id).where(POINTS.c.sweep_id == sweep_id)
    asked = sa.select(SWEEPS.c.priority, SWEEPS.c.keep).where(SWEEPS.c.id == sweep_id)
    priority, keep = connection.execute(asked).one()
    again = JOBS.c.id.in_(own) & sa.or_(ended_by_accident(verdicts=verdicts), _lacks_a_file(keep))
    ended = sa.select(JOBS.c.id).where(again, sa.not_(HAS_RESULT))
    connection.execute(ARTIFACTS.delete().where(ARTIFACTS.c.job_id.in_(ended)))
    queue = JOBS.update().where(again).values(state=State.QUEUED, queued=moment, crashes=0)
    queue = queue.values(priority=priority, turn=LAST, crash_step=None)
    queue = queue.values(fraction=None, finished=None)
    queue = queue.values(unless_result(cause=None, failure=None, reason=None))
    count = connection.execute(queue).rowcount
    revive(connection, count)
    less = JOBS.update().where(JOBS.c.id.in_(own), JOBS.c.keep.not_in(at_least(keep)))
    connection.execute(less.values(keep=keep))
    using = sa.select(POINTS.c.sweep_id).where(POINTS.c.run_id.in_(own))
    hold_publications(connection, JOBS.c.sweep_id.in_(using))
    return count


def _lacks_a_file(keep: Keep) -> sa.ColumnElement[bool]:
    """The run has a result, but was told to keep less than this, and did or lost the rest."""
    is_less = JOBS.c.state.in_([State.SUCCEEDED]) & JOBS.c.keep.not_in(at_least(keep))
    names = [name for name, least in KEPT_BY.items() if keep in at_least(least)]
    there = sa.select(sa.func.count()).where(
        ARTIFACTS.c.job_id == JOBS.c.id, ARTIFACTS.c.name.in_(names)
    )
    return is_less & (there.correlate(JOBS).scalar_subquery() < len(names))


def queue_for_film(connection: sa.Connection, claim: Claim, moment: datetime) -> None:
    """Queue a run that has just got its result again, if a sweep that joined it asked for a film."""
    if claim.keep is not Keep.FILM:
        is_wanted = JOBS.c.keep.in_([Keep.FILM]) & JOBS.c.state.in_([State.SUCCEEDED]) & IS_WANTED
        film = sa.exists().where(ARTIFACTS.c.job_id == JOBS.c.id, ARTIFACTS.c.name == FILM)
        again = JOBS.update().where(JOBS.c.id == claim.id, is_wanted, sa.not_(film))
        fresh = {"crashes": 0, "crash_step": None, "fraction": None, "finished": None}
        connection.execute(again.values(state=State.QUEUED, queued=moment, **fresh))


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
