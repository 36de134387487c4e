"""The cost of a sweep, on this machine (``whipple estimate``, ``whipple.estimate``) and in a child process."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from service.api.reading import Posted, doubts_about
from studies.quantities.display import duration
from studies.sweeps.cost import Cost, PresetCost, SweepCost, cost_of, presets_of, sweep_cost
from studies.sweeps.document import document_of
from studies.sweeps.reading import SweepLimits
from studies.sweeps.sweep import Sweep


@dataclass(frozen=True, repr=False)
class Estimated:
    """The cost of a sweep, as it is and at each accuracy; a notebook shows it in words."""

    name: str
    cost: Cost
    presets: tuple[PresetCost, ...]
    warnings: tuple[str, ...]  # doubts about points and constants that are allowed and hardly useful

    def __repr__(self) -> str:
        return "\n".join(self._lines())

    def _lines(self) -> Iterator[str]:
        from studies.sweeps.accuracy import in_percent

        yield f"{self.name}: {_in_words(self.cost)}"
        for preset in self.presets:
            text = f"not available: {preset.reason}"
            if preset.cost and preset.cells:
                fewest, most = preset.cells
                cells = f"{fewest:g} cells" if fewest == most else f"{fewest:g} to {most:g} cells"
                text = f"{cells} across the diameter: {_in_words(preset.cost)}"
            yield f"  accuracy: {in_percent(preset.error)} ({preset.name})".ljust(28) + text


def _in_words(cost: Cost) -> str:
    time, size = duration(cost.core_seconds), cost.bytes / 1e6
    memory = f"{cost.memory / 1e6:.0f} MB of memory a run"
    return f"{cost.runs} runs, about {time} of one core, {size:.0f} MB of files, {memory}"


def estimate(document: Mapping[str, Any] | str | Path, *, accuracy: str | float | None = None) -> Estimated:
    """Estimate the cost of a sweep, a mapping or the path of a YAML file; nothing is computed.

    With an ``accuracy`` ("3 %", "fine") in place of its resolution. Raises InvalidInput.

    >>> import whipple
    >>> shot = dict(projectile="copper-ofhc", projectile_diameter="8 mm", target="copper-ofhc", plate_thickness="2 mm")
    >>> whipple.estimate({**shot, "speed": ["3 km/s", "6 km/s"], "resolution": 8}).cost.runs
    2
    """
    from service.settings import Settings

    limit = Settings().max_runs
    sweep = Sweep.parse(document_of(document, accuracy=accuracy), SweepLimits(max_runs=limit))
    return Estimated(sweep.name, cost_of(sweep), tuple(presets_of(sweep, limit)), tuple(doubts_about(sweep)))


@dataclass(frozen=True)
class EstimatedSweep:
    scenario: str
    cost: SweepCost
    warnings: list[str]
    presets: list[PresetCost]


def estimated(posted: Posted) -> EstimatedSweep:
    """The cost of the sweep of a body; raises InvalidInput with every error."""
    with posted.document() as document:
        return estimated_sweep(Sweep.parse(document, SweepLimits(posted.max_runs)), posted.max_runs)


def estimated_sweep(sweep: Sweep, max_runs: int) -> EstimatedSweep:
    """The cost of a sweep, and of its presets of at most so many runs; raises InvalidInput."""
    return EstimatedSweep(sweep.scenario, sweep_cost(sweep), doubts_about(sweep), [*presets_of(sweep, max_runs)])
