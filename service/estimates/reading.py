"""Sweeps priced, in a child process."""

from dataclasses import dataclass

from service.api.reading import Posted, doubts_about
from studies.sweeps.cost import PresetCost, SweepCost, presets_of, sweep_cost
from studies.sweeps.reading import SweepLimits
from studies.sweeps.sweep import Sweep


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
