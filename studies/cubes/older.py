"""Results of a sweep that another version expanded: its runs have other ids here, and the same coordinates."""

from collections.abc import Iterable, Mapping

from studies.cubes import limits
from studies.cubes.cells import MISSING, Results
from studies.quantities.parameters import Value
from studies.runs.results import RunResult
from studies.sweeps.sweep import Point, Sweep

PointsOfRuns = Iterable[tuple[Mapping[str, Value], str]]  # the coordinates of each point, and the id of its run then


def by_present_ids(sweep: Sweep, results: Results, places: PointsOfRuns) -> Results:
    """The results by the ids of this version too; each keeps that of its run.

    The values that a search tried follow from the results, a step at a time.
    """
    known = {frozenset(coordinates.items()): results[id] for coordinates, id in places if id in results}
    if not sweep.search:
        return {**results, **_at_points(sweep.every_run(), known)}
    quantity = sweep.search.quantity
    more: Mapping[str, RunResult] = results
    while more:
        results = {**results, **more}
        outcomes = results
        searched = sweep.limits(lambda run: limits.outcome_of(outcomes.get(run.id, MISSING), quantity))  # noqa: B023
        found = _at_points(sweep.tried(searched).runs(), known)
        more = {id: result for id, result in found.items() if id not in results}
    return results


def _at_points(
    points: Iterable[Point], known: Mapping[frozenset[tuple[str, Value]], RunResult]
) -> dict[str, RunResult]:
    """The results that are known of these points, by the ids of their runs."""
    there = ((point.run.id, frozenset(point.coordinates.items())) for point in points)
    return {id: known[place] for id, place in there if place in known}
