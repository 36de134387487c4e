"""Fairness between owners and between the sweeps of one owner, and the priority of runs that sweeps share.

Start-time fair queueing (Goyal, Vin, Cheng 1996) by estimated cost, on two levels within each priority class. Owners
get equal shares of the cores while they have work: the next run is of the owner who was served least (``served``), and
an owner who returns begins where the least served of the others is. Each owner has a queue with a virtual time, that of
its run leased last. A sweep that is accepted begins there: the virtual time of each of its runs is later by the cost of
the sweep's unfinished runs before it. So the sweeps of an owner get equal parts of its share, however long the older
one is. Classes have queues of their own, so that an urgent sweep that passes all others leaves theirs as they were. A
run that changes its queue keeps its distance from the virtual time of the queue.
"""

import heapq
from collections import deque

import sqlalchemy as sa

from service.records.jobs import ACTIVE, Kind, State
from service.store.tables import (
    IS_QUEUED,
    JOBS,
    POINTS,
    PUBLICATIONS,
    SHARES,
    SWEEPS,
    StatementRow,
    insert_into,
    runs_of,
)

LAST = 1e300  # a virtual time after every other

# The sweeps that wait for a run.
_WAITING = (
    sa.select(SWEEPS.c.number)
    .join_from(POINTS, SWEEPS, SWEEPS.c.id == POINTS.c.sweep_id)
    .join(PUBLICATIONS, PUBLICATIONS.c.sweep_id == POINTS.c.sweep_id)
    .where(POINTS.c.run_id == JOBS.c.id, POINTS.c.detached.is_(False))
    .where(PUBLICATIONS.c.state == State.WAITING)
    .correlate(JOBS)
)
IS_WANTED = _WAITING.exists()
# The queue of a wanted run: that of the most urgent sweep that waits for it. Among equals the run stays with its owner.
PRIORITY = _WAITING.with_only_columns(sa.func.min(SWEEPS.c.priority)).scalar_subquery()
_FIRST = _WAITING.order_by(SWEEPS.c.priority, SWEEPS.c.number).limit(1)
_STAYS = _WAITING.where(SWEEPS.c.priority == PRIORITY, SWEEPS.c.owner == JOBS.c.owner).exists()
OWNER = sa.case((_STAYS, JOBS.c.owner), else_=_FIRST.with_only_columns(SWEEPS.c.owner).scalar_subquery())


def _time_of(priority: sa.ColumnElement[int], owner: sa.ColumnElement[str]) -> sa.ColumnElement[float]:
    """Virtual time of a queue."""
    time = sa.select(SHARES.c.virtual_time).where(SHARES.c.priority == priority, SHARES.c.owner == owner)
    return sa.func.coalesce(time.correlate(JOBS).scalar_subquery(), 0.0)


# The distance of a run from the virtual time of its queue, and its virtual time in the queue that it moves to.
AHEAD = JOBS.c.virtual_time - _time_of(JOBS.c.priority, JOBS.c.owner)
MOVED = {"priority": PRIORITY, "owner": OWNER, "virtual_time": AHEAD + _time_of(PRIORITY, OWNER)}

_QUEUED = (IS_QUEUED, JOBS.c.priority == SHARES.c.priority, JOBS.c.owner == SHARES.c.owner)
_HAS_WORK = sa.exists().where(*_QUEUED)


def open_queue(connection: sa.Connection, priority: int, owner: str) -> float:
    """Virtual time of the queue of an owner in a class; an owner without work there begins beside the others."""
    of_class = sa.select(SHARES, _HAS_WORK.label("has_work")).where(SHARES.c.priority == priority)
    shares = {row.owner: row for row in connection.execute(of_class)}
    own = shares.pop(owner, None)
    time, served = (0.0, 0.0) if own is None else (float(own.virtual_time), float(own.served))
    if own is None or not own.has_work:
        all_served = [row.served for row in shares.values()]
        with_work = [row.served for row in shares.values() if row.has_work]
        served = max(served, min(with_work) if with_work else max(all_served, default=0.0))
    new = insert_into(connection, SHARES).values(priority=priority, owner=owner, virtual_time=time, served=served)
    connection.execute(new.on_conflict_do_update(index_elements=["priority", "owner"], set_={"served": served}))
    return time


def take_due(connection: sa.Connection, limit: int, *conditions: sa.ColumnElement[bool]) -> list[str]:
    """Ids of the queued runs that are due, in order; their owners are charged. ``conditions`` on JOBS exclude some."""
    with_work = sa.select(SHARES).where(_HAS_WORK).order_by(SHARES.c.priority)
    runs = sa.select(JOBS.c.id, JOBS.c.virtual_time, JOBS.c.cost).where(IS_QUEUED, *conditions)
    runs = runs.order_by(JOBS.c.virtual_time, JOBS.c.ordinal).limit(limit)
    due: list[str] = []
    by_class: dict[int, list[StatementRow]] = {}
    for share in connection.execute(with_work):
        by_class.setdefault(share.priority, []).append(share)
    for priority, shares in by_class.items():
        heap: list[tuple[float, str, float, deque[StatementRow]]] = []
        for share in shares:
            own = runs.where(JOBS.c.priority == priority, JOBS.c.owner == share.owner)
            heap.append((share.served, share.owner, share.virtual_time, deque(connection.execute(own))))
        heapq.heapify(heap)
        while heap and len(due) < limit:
            served, owner, time, waiting = heapq.heappop(heap)
            if waiting:
                run = waiting.popleft()
                due.append(run.id)
                is_own = (SHARES.c.priority == priority) & (SHARES.c.owner == owner)
                served, time = served + run.cost, max(time, run.virtual_time)
                connection.execute(SHARES.update().where(is_own).values(virtual_time=time, served=served))
                heapq.heappush(heap, (served, owner, time, waiting))
        if len(due) == limit:
            break
    return due


def schedule(connection: sa.Connection, sweep_id: str) -> None:
    """Give the queued runs of a sweep its priority, owner and virtual times, unless they come earlier where they are.

    Its unfinished runs then move to the queues of the most urgent sweeps that wait for them.
    """
    sweep = sa.select(SWEEPS.c.priority, SWEEPS.c.owner).where(SWEEPS.c.id == sweep_id)
    priority, owner = connection.execute(sweep).one()
    begin = open_queue(connection, priority, owner)
    runs = JOBS.alias("runs")
    queued = (
        sa.select(runs.c.id, runs.c.cost, sa.func.min(POINTS.c.ordinal).label("first_ordinal"))
        .join_from(POINTS, runs, runs.c.id == POINTS.c.run_id)
        .where(POINTS.c.sweep_id == sweep_id, runs.c.state == State.QUEUED)
        .group_by(runs.c.id, runs.c.cost)
        .subquery()
    )
    ahead = sa.func.sum(queued.c.cost).over(order_by=queued.c.first_ordinal) - queued.c.cost
    due = sa.select(queued.c.id, ahead.label("ahead")).subquery()
    is_sooner = (JOBS.c.priority == priority) & (due.c.ahead < AHEAD)
    connection.execute(
        JOBS.update()
        .where(JOBS.c.id == due.c.id, is_sooner | (JOBS.c.priority > priority))
        .values(priority=priority, owner=owner, virtual_time=begin + due.c.ahead)
    )
    follow_urgency(connection, sweep_id)


def follow_urgency(connection: sa.Connection, sweep_id: str) -> None:
    """Move the unfinished runs of a sweep to the queues of the most urgent sweeps that wait for them."""
    connection.execute(
        JOBS.update()
        .where(JOBS.c.id.in_(runs_of(sweep_id)))
        .where(JOBS.c.kind == Kind.RUN, JOBS.c.state.in_(ACTIVE))
        .where(sa.or_(JOBS.c.priority != PRIORITY, JOBS.c.owner != OWNER))
        .values(MOVED)
    )
