"""The expected cost of a sweep: as it is, and at each accuracy that a preset offers."""

from collections.abc import Iterator
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

    def times(self, count: int) -> "Cost":
        """The cost of so many times the work."""
        return Cost(self.runs * count, self.core_seconds * count, self.bytes * count)


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
    """The cost of a sweep; raises InvalidInput where one of its points is refused."""
    points = sweep.runs()
    different = {point.run.id: point.run for point in points}
    estimates = [run.estimate(each) for each in different.values()]
    return Cost(
        len(points), sum(e.core_seconds for e in estimates), sum(e.bytes for e in estimates)
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
            once = cost_of(replace(resolved, offsets=1))  # an offset changes no cost
            yield PresetCost(*about, once.times(preset.offsets))
        except InvalidInput as error:
            yield PresetCost(*about, None, str(error.findings[0].limit))
