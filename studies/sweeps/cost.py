"""The expected cost of a sweep: as it is, and at each accuracy that a preset offers."""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace

from studies.quantities.findings import InvalidInput
from studies.runs.run import Estimate, estimate
from studies.sweeps.accuracy import ACCURACY
from studies.sweeps.reading import RESOLUTION
from studies.sweeps.sweep import Sweep

MOST_LOOKED_AT = 64  # points of a sweep, at 1 ms each; those of a larger one cost as these do


@dataclass(frozen=True)
class Cost:
    """Estimated work of the different runs of a sweep, on one core."""

    runs: int  # points times their resolutions and offsets
    core_seconds: float
    bytes: int  # of what is kept
    memory: int  # of the largest process of a run, bytes


# Of any sweep, whatever its runs: processes that start, cube and report. From sweeps of 25 and 200 coarse runs,
# 2026-11-24: 3.2 MB, most of it the report's; 24 core seconds on a busy machine, where a run took 2.5 times those of
# ``SECONDS_OF_RUN``.
OF_SWEEP = Cost(0, 9.0, 3_200_000, 0)


@dataclass(frozen=True)
class PresetCost:
    """An accuracy with what it would make of a sweep."""

    name: str
    error: float  # of the mesh, relative
    runs: int
    cells: tuple[float, float] | None  # fewest and most across the diameter; None where it is not offered
    cost: Cost | None  # likewise
    reason: str = ""  # why it is not


@dataclass(frozen=True)
class PricedRun:
    """A run with its cost, and the number of runs that it stands for."""

    id: str
    work: Estimate
    cells: float | None  # across the diameter
    share: float  # 1, or more where not every point of a sweep is looked at


@dataclass(frozen=True)
class SweepCost:
    """The cost of a sweep, from the different runs at the points that were looked at."""

    runs: int  # most runs of the sweep, those of every try of a search
    looked_at: int  # points
    priced: tuple[PricedRun, ...]
    further: float  # tries of a search for each of its first runs; they lie between their values

    def of(self, priced: Iterable[PricedRun]) -> Cost:
        """The cost of some of the runs, with those that they stand for."""
        chosen = [(run, run.share * self.further) for run in priced]
        return Cost(
            self.runs,
            sum(run.work.core_seconds * share for run, share in chosen),
            round(sum(run.work.bytes * share for run, share in chosen)),
            max((run.work.memory for run, _ in chosen), default=0),
        )

    @property
    def whole(self) -> Cost:
        """The cost of all of its runs and of the sweep itself."""
        runs = self.of(self.priced)
        return replace(runs, core_seconds=runs.core_seconds + OF_SWEEP.core_seconds, bytes=runs.bytes + OF_SWEEP.bytes)


def sweep_cost(sweep: Sweep) -> SweepCost:
    """The cost of a sweep by its runs, drawn evenly; raises InvalidInput where one of them is refused."""
    on_axes = min(sweep.size, MOST_LOOKED_AT)
    priced: dict[str, PricedRun] = {}
    count = 0
    for count, point in enumerate(sweep.every_run(MOST_LOOKED_AT), 1):
        if point.run.id not in priced:
            cells = point.run.parameters.get(RESOLUTION)
            share = sweep.size / on_axes if count <= on_axes else 1.0  # then it screens the models
            across = None if cells is None else float(cells)
            priced[point.run.id] = PricedRun(point.run.id, estimate(point.run), across, share)
    runs = sweep.most_runs + count - on_axes
    further = sweep.most_runs / sweep.size
    return SweepCost(runs, count, tuple(priced.values()), further)


def cost_of(sweep: Sweep) -> Cost:
    """The cost of a sweep, at most; raises InvalidInput where one of its points is refused."""
    return sweep_cost(sweep).whole


def presets_of(sweep: Sweep, most_runs: int) -> Iterator[PresetCost]:
    """The cost of a sweep at each accuracy; empty where none can set its resolution."""
    if not sweep.definition.accurate or RESOLUTION in {*sweep.fixed, *(axis.name for axis in sweep.axes)}:
        return
    for name, error in ACCURACY.items():
        resolved = replace(sweep, resolutions=(), offsets=1, accuracy=error, cells=())
        reason = f"more than {most_runs} runs" if resolved.most_runs > most_runs else ""
        try:
            cost = None if reason else sweep_cost(resolved)
        except InvalidInput as refused:
            cost, reason = None, refused.findings[0].limit
        if cost is None:
            yield PresetCost(name, error, resolved.most_runs, None, None, reason)
            continue
        cells = [run.cells for run in cost.priced if run.cells is not None]
        yield PresetCost(name, error, cost.runs, (min(cells), max(cells)), cost.whole)
