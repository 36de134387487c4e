"""The expected cost of a sweep: as it is, and at each accuracy that a preset offers."""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace

from studies.runs import run
from studies.sweeps.sweep import Sweep
from studies.values.errors import InvalidInput
from studies.values.recipes import ACCURACY


@dataclass(frozen=True)
class Cost:
    """Estimated work of the different runs of a sweep, on one core."""

    runs: int  # points times their resolutions and offsets
    core_seconds: float
    bytes: int  # of what is kept
    memory: int  # of the largest process of a run, bytes

    def times(self, count: int) -> "Cost":
        """The cost of so many times the work."""
        return Cost(self.runs * count, self.core_seconds * count, self.bytes * count, self.memory)

    def plus(self, other: "Cost") -> "Cost":
        """The cost of both."""
        return Cost(
            self.runs + other.runs,
            self.core_seconds + other.core_seconds,
            self.bytes + other.bytes,
            max(self.memory, other.memory),
        )


# Of any sweep, whatever its runs: processes that start, cube and report. From sweeps of 25 and 200 coarse runs,
# 2026-11-24: 3.2 MB, most of it the report's; 24 core seconds on a busy machine, where a run took 2.5 times those of
# ``SECONDS_OF_RUN``.
OF_SWEEP = Cost(0, 9.0, 3_200_000, 0)


@dataclass(frozen=True)
class PresetCost:
    """A preset with what it would make of a sweep."""

    name: str
    meaning: str
    resolutions: tuple[float, ...]
    offsets: int
    runs: int
    cost: Cost | None  # None where it is not offered
    reason: str = ""  # why it is not


def cost_of(sweep: Sweep) -> Cost:
    """The cost of a sweep, at most; raises InvalidInput where one of its points is refused."""
    return _of_runs(sweep).plus(OF_SWEEP)


def _of_runs(sweep: Sweep) -> Cost:
    """The cost of its runs."""
    cost = _cost(point.run for point in sweep.every_run())
    if sweep.searched is None:
        return cost
    # The further tries of a search lie between the values of its first runs.
    share = sweep.most_runs / cost.runs
    return Cost(sweep.most_runs, cost.core_seconds * share, round(cost.bytes * share), cost.memory)


def _of_screening(sweep: Sweep) -> Cost:
    """The cost of the runs that screen the models of a sweep."""
    if sweep.model_part != "screen":
        return Cost(0, 0.0, 0, 0)
    return _cost(each.run for each in sweep.screening()[1] if each.run is not None)


def _cost(runs: Iterable[run.Run]) -> Cost:
    """The cost of the different ones of some runs, counted all."""
    every = list(runs)
    estimates = [run.estimate(each) for each in {each.id: each for each in every}.values()]
    return Cost(
        len(every),
        sum(each.core_seconds for each in estimates),
        sum(each.bytes for each in estimates),
        max((each.memory for each in estimates), default=0),
    )


def presets_of(sweep: Sweep, most_runs: int) -> Iterator[PresetCost]:
    """The cost of a sweep at each accuracy; empty where no preset can set its resolution."""
    for name, preset in ACCURACY.items():
        try:
            resolved = sweep.at_accuracy(name)
        except ValueError:
            continue
        about = (name, preset.meaning, preset.resolutions, preset.offsets, resolved.size)
        if resolved.size > most_runs:
            yield PresetCost(*about, None, f"more than {most_runs} runs")
            continue
        try:
            # An offset changes no cost; what screens the models is computed at one.
            once = _of_runs(replace(resolved, offsets=1, model_part="none"))
            every = once.times(preset.offsets).plus(_of_screening(resolved)).plus(OF_SWEEP)
            yield replace(PresetCost(*about, every), runs=every.runs)
        except InvalidInput as error:
            yield PresetCost(*about, None, str(error.findings[0].limit))
