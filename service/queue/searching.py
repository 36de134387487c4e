"""The next runs of a sweep that searches for a limit, from the results so far."""

import logging
from collections.abc import Mapping

from service.logs import about
from service.records.jobs import Lease, MeasuredRun, State
from service.store import Store
from service.store.sweeps import is_search
from solver.errors import WhippleError
from studies.runs.run import Run
from studies.sweeps.reading import ACCEPTED
from studies.sweeps.search import LimitOutcome, outcome_in
from studies.sweeps.sweep import Point, Sweep

log = logging.getLogger(__name__)


def goes_on(store: Store, lease: Lease) -> bool:
    """Whether the sweep of a leased publication got further runs, for which the publication waits."""
    assert lease.sweep_id is not None
    document = store.sweeps.document(lease.sweep_id)
    if not is_search(document):
        return False
    runs = {run.id: run for run in store.runs.measured(lease.sweep_id)}
    try:
        points = next_points(Sweep.parse(document, ACCEPTED), runs)
    except WhippleError as error:  # the publication says it too, where people read it
        log.warning("%s cannot go on with its search: %s", lease.key, error, extra=about(lease))
        return False
    return bool(points) and store.sweeps.extend(lease, points)


def next_points(sweep: Sweep, runs: Mapping[str, MeasuredRun]) -> list[Point]:
    """The points that the results of its runs (by id) ask for."""
    assert sweep.search is not None
    quantity = sweep.search.quantity

    def outcome_of(run: Run) -> LimitOutcome | str:
        ended = runs.get(run.id)
        if ended is None or ended.state not in (State.SUCCEEDED, State.FAILED):
            return "unfinished"
        return outcome_in(ended.summary if ended.state is State.SUCCEEDED else None, quantity)

    tried = sweep.tried(sweep.limits(outcome_of))
    return [point for point in tried.runs() if point.run.id not in runs]
