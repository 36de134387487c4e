"""Progress of a sweep and the time left, from a tally of its points.

The runs that are done say how many measured seconds one estimated core second takes. The time left is the estimated
cost of what is not computed yet, at that rate, by as many runs side by side as there are now.
"""

from collections import defaultdict
from collections.abc import Mapping, Sequence

import sqlalchemy as sa

from service.records.jobs import ACTIVE, RUN_STATES, State
from service.store.tables import JOBS, POINT_STATE, POINTS, StatementRow

MOST_REMEMBERED = 10_000  # sweeps whose tallies are remembered


class Tallies:
    """Tallies of sweeps; those without an unfinished point are remembered for one cache generation."""

    def __init__(self) -> None:
        self._remembered: dict[str, tuple[int, list[StatementRow]]] = {}

    def of(self, connection: sa.Connection, rows: Sequence[StatementRow]) -> Mapping[str, list[StatementRow]]:
        """``tallies_of`` sweeps; their rows name the cache generation of the moment they were read."""
        tallies = {row.id: self._remembered_of(row) for row in rows}
        fresh = tallies_of(connection, [id for id, tally in tallies.items() if not tally])
        if len(self._remembered) + len(fresh) > MOST_REMEMBERED:
            self._remembered.clear()
        for row in rows:
            if row.id in fresh and all(part.point_state not in ACTIVE for part in fresh[row.id]):
                self._remembered[row.id] = row.cache_generation, fresh[row.id]
        return {**tallies, **fresh}

    def _remembered_of(self, row: StatementRow) -> list[StatementRow]:
        generation, tally = self._remembered.get(row.id, (row.cache_generation, []))
        return tally if generation == row.cache_generation else []


def tallies_of(connection: sa.Connection, ids: Sequence[str]) -> Mapping[str, list[StatementRow]]:
    """For each sweep and state of its points: their number, cost, computed cost and measured seconds."""
    done = sa.func.coalesce(JOBS.c.fraction, 0.0) * JOBS.c.cost
    if not ids:
        return {}
    query = (
        sa.select(POINTS.c.sweep_id, POINT_STATE.label("point_state"))
        .add_columns(sa.func.count().label("points"), sa.func.sum(JOBS.c.cost).label("cost"))
        # A run that succeeded has a reason where it lost an answer.
        .add_columns(sa.func.count(JOBS.c.reason).label("reasons"))
        .add_columns(sa.func.sum(done).label("done"), sa.func.sum(JOBS.c.seconds).label("seconds"))
        .join_from(POINTS, JOBS, JOBS.c.id == POINTS.c.run_id)
        .where(POINTS.c.sweep_id.in_(ids))
        .group_by(POINTS.c.sweep_id, POINT_STATE)
    )
    tallies = defaultdict(list)
    for row in connection.execute(query):
        tallies[row.sweep_id].append(row)
    return tallies


def counts_of(tally: Sequence[StatementRow]) -> dict[str, int]:
    """Points by state of their runs, with zeros."""
    counts = dict.fromkeys((state.value for state in RUN_STATES), 0)
    return counts | {part.point_state.value: part.points for part in tally}


def progress_of(tally: Sequence[StatementRow]) -> float:
    """The computed part of the estimated cost, 0 to 1; cancelled points count as never computed."""
    total = sum(part.cost for part in tally)
    counted = (part for part in tally if part.point_state is not State.CANCELLED)
    computed = sum(part.done if part.point_state in ACTIVE else part.cost for part in counted)
    return computed / total if total else 1.0


def seconds_left(tally: Sequence[StatementRow]) -> float | None:
    """Seconds until all points are computed; None before the first measured run."""
    remaining = sum(part.cost - part.done for part in tally if part.point_state in ACTIVE)
    done = sum(part.done for part in tally)
    if not remaining:
        return 0.0
    if not done:
        return None
    rate = sum(part.seconds or 0.0 for part in tally) / done
    side_by_side = sum(part.points for part in tally if part.point_state is State.RUNNING)
    return remaining * rate / max(1, side_by_side)
