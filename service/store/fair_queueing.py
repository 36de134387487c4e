"""Fairness between sweeps, and the priority of runs that sweeps share.

Start-time fair queueing (Goyal, Vin, Cheng 1996) by estimated cost, within each priority class. The virtual time of a
class is that of the run leased last. A sweep that is accepted begins there: the virtual time of each of its runs is
later by the cost of the sweep's unfinished runs before it. So two sweeps get equal shares of the cores while both have
work, however long the older one is. Classes have virtual times of their own, so that an urgent sweep that passes all
others leaves theirs as it was. A run that changes its class keeps its distance from the virtual time of the class.
"""

from collections.abc import Sequence
from datetime import datetime
from typing import Any

import sqlalchemy as sa

from service.records.jobs import ACTIVE, KEPT_BY, Keep, Kind, Lease, State, at_least
from service.store.tables import (
    ARTIFACTS,
    HAS_RESULT,
    JOBS,
    POINTS,
    PRIORITY_CLASSES,
    PUBLICATIONS,
    SWEEPS,
    ended_by_accident,
    hold_publications,
    insert_into,
    invalidate_tallies,
    runs_of,
    unless_result,
)
from studies.quantities.files import FILM

LAST = 1e300  # a virtual time after every other
QUEUE_ORDER = [JOBS.c.priority, JOBS.c.virtual_time, JOBS.c.ordinal]

# The priority of a run: that of the most urgent sweep that waits for it. NULL: no sweep waits, for
# those that have the run are being published, or are done.
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
    """Virtual time of a priority class."""
    time = sa.select(PRIORITY_CLASSES.c.virtual_time).where(PRIORITY_CLASSES.c.priority == priority)
    return sa.func.coalesce(time.correlate(JOBS).scalar_subquery(), 0.0)


# The virtual time of a run that moves to the class of its urgency.
MOVED_TIME = JOBS.c.virtual_time - _time_of(JOBS.c.priority) + _time_of(URGENCY)


def open_class(connection: sa.Connection, priority: int) -> float:
    """Virtual time of a priority class, which is made where it is missing."""
    new = insert_into(connection, PRIORITY_CLASSES).values(priority=priority, virtual_time=0.0)
    connection.execute(new.on_conflict_do_nothing())
    time = sa.select(PRIORITY_CLASSES.c.virtual_time).where(PRIORITY_CLASSES.c.priority == priority)
    return connection.execute(time).scalar_one()


def advance_classes(connection: sa.Connection, times: dict[int, float]) -> None:
    """Note the virtual times of the runs leased last, by priority."""
    reached: sa.BindParameter[float] = sa.bindparam("reached")
    of_class = PRIORITY_CLASSES.c.priority == sa.bindparam("class")
    advance = PRIORITY_CLASSES.update().where(of_class, PRIORITY_CLASSES.c.virtual_time < reached)
    connection.execute(
        advance.values(virtual_time=reached), [{"class": priority, "reached": time} for priority, time in times.items()]
    )


def queue_again(
    connection: sa.Connection, sweep_id: str, moment: datetime, *, verdicts: bool, among: Sequence[str] | None = None
) -> int:
    """Queue the runs of a sweep that ended by accident, with fresh budgets; return their number.

    ``among`` are the ids of those that are looked at, by default all.

    The same happens to those that succeeded and lack a file that the sweep keeps. A result, or a verdict, stays until
    it is replaced: other sweeps may have it. ``schedule`` gives the runs their virtual times.
    """
    own = runs_of(sweep_id)
    if among is not None:
        own = own.where(POINTS.c.run_id.in_(among))
    row = sa.select(SWEEPS.c.priority, SWEEPS.c.keep).where(SWEEPS.c.id == sweep_id)
    priority, keep = connection.execute(row).one()
    again = JOBS.c.id.in_(own) & sa.or_(ended_by_accident(verdicts=verdicts), _lacks_a_file(keep))
    without_result = sa.select(JOBS.c.id).where(again, sa.not_(HAS_RESULT))
    connection.execute(ARTIFACTS.delete().where(ARTIFACTS.c.job_id.in_(without_result)))
    queue = JOBS.update().where(again).values(state=State.QUEUED, queued=moment, crashes=0)
    queue = queue.values(priority=priority, virtual_time=LAST, crash_step=None)
    queue = queue.values(fraction=None, finished=None)
    queue = queue.values(unless_result(cause=None, failure=None, reason=None))
    count = connection.execute(queue).rowcount
    invalidate_tallies(connection, count)
    less = JOBS.update().where(JOBS.c.id.in_(own), JOBS.c.keep.not_in(at_least(keep)))
    connection.execute(less.values(keep=keep))
    using = sa.select(POINTS.c.sweep_id).where(POINTS.c.run_id.in_(own))
    hold_publications(connection, JOBS.c.sweep_id.in_(using))
    return count


def _lacks_a_file(keep: Keep) -> sa.ColumnElement[bool]:
    """The run has a result, and lacks a file of this retention."""
    is_less = JOBS.c.state.in_([State.SUCCEEDED]) & JOBS.c.keep.not_in(at_least(keep))
    names = [name for name, least in KEPT_BY.items() if keep in at_least(least)]
    there = sa.select(sa.func.count()).where(ARTIFACTS.c.job_id == JOBS.c.id, ARTIFACTS.c.name.in_(names))
    return is_less & (there.correlate(JOBS).scalar_subquery() < len(names))


def queue_for_film(connection: sa.Connection, lease: Lease, moment: datetime) -> None:
    """Queue a run that has just got its result again, if a sweep that joined it asked for a film."""
    if lease.keep is not Keep.FILM:
        is_wanted = JOBS.c.keep.in_([Keep.FILM]) & JOBS.c.state.in_([State.SUCCEEDED]) & IS_WANTED
        film = sa.exists().where(ARTIFACTS.c.job_id == JOBS.c.id, ARTIFACTS.c.name == FILM)
        again = JOBS.update().where(JOBS.c.id == lease.id, is_wanted, sa.not_(film))
        fresh = {"crashes": 0, "crash_step": None, "fraction": None, "finished": None}
        connection.execute(again.values(state=State.QUEUED, queued=moment, **fresh))


def schedule(connection: sa.Connection, sweep_id: str, priority: int) -> None:
    """Give the queued runs of a sweep its priority and virtual times, unless theirs are earlier.

    Its unfinished runs then move to the classes of the most urgent sweeps that wait for them.
    """
    begin = open_class(connection, priority)
    runs = JOBS.alias("runs")
    queued = (
        sa.select(runs.c.id, runs.c.cost, sa.func.min(POINTS.c.ordinal).label("first_ordinal"))
        .join_from(POINTS, runs, runs.c.id == POINTS.c.run_id)
        .where(POINTS.c.sweep_id == sweep_id, runs.c.state == State.QUEUED)
        .group_by(runs.c.id, runs.c.cost)
        .subquery()
    )
    ahead = sa.func.sum(queued.c.cost).over(order_by=queued.c.first_ordinal) - queued.c.cost
    due = sa.select(queued.c.id, (begin + ahead).label("time")).subquery()
    is_sooner = (JOBS.c.priority == priority) & (JOBS.c.virtual_time > due.c.time)
    connection.execute(
        JOBS.update()
        .where(JOBS.c.id == due.c.id, is_sooner | (JOBS.c.priority > priority))
        .values(priority=priority, virtual_time=due.c.time)
    )
    follow_urgency(connection, sweep_id)


def follow_urgency(connection: sa.Connection, sweep_id: str) -> None:
    """Move the unfinished runs of a sweep to the classes of those that wait for them."""
    connection.execute(
        JOBS.update()
        .where(JOBS.c.id.in_(runs_of(sweep_id)))
        .where(JOBS.c.kind == Kind.RUN, JOBS.c.state.in_(ACTIVE), JOBS.c.priority != URGENCY)
        .values(priority=URGENCY, virtual_time=MOVED_TIME)
    )
