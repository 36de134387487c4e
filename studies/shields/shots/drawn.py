"""What drawn shots say of simulations, by range of the normal speed: which of their failures simulations find.

``joined`` writes it, from the outcomes of the shots that were drawn and simulated (docs/pages/simulated_shields.py).
"""

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Literal

from studies.outcomes.found import Share
from studies.shields.shots.judged import RANGES, range_of

FAST = RANGES[1][1]  # m/s: slower shots are counted apart
STORED = Path(__file__).with_name("drawn.json")
Simulated = Literal["perforated", "held", "open"]


@dataclass(frozen=True)
class SimulationKind:
    """How the runs of a simulation are computed."""

    failures: tuple[str, ...]  # ascending
    grids: Literal["one", "several"]

    @property
    def name(self) -> str:
        """ "johnson-cook and none, several grids"."""
        return f"{' and '.join(self.failures)}, {self.grids} grid{'s' if self.grids == 'several' else ''}"


@dataclass(frozen=True)
class DrawnShots:
    """The drawn shots of a range of the normal speed, and what a kind of simulation says of them."""

    shots: int
    gained: float  # mean fall of the square of P less the outcome by it, on laboratories that are left out
    within: float  # 1.96 standard errors of it
    perforated: int  # walls, in the laboratory
    found: int  # of these perforated in the simulation, too


@cache
def stored() -> Mapping[str, Sequence[DrawnShots]]:
    """What is stored of each kind of simulation that shots were simulated by, by its name and the ranges."""
    kinds = json.loads(STORED.read_text(encoding="utf-8"))
    return {name: [DrawnShots(**place) for place in ranges] for name, ranges in kinds.items()}


def failures_found(failure: str, normal_speed: float) -> Share | None:
    """How many perforated walls simulations with a failure on one grid find, below 3 km/s or from there on.

    None where no shots were simulated with it.
    """
    ranges = stored().get(SimulationKind((failure,), "one").name)
    if ranges is None:
        return None
    mine = ranges[:1] if range_of(normal_speed) == 0 else ranges[1:]
    return Share(sum(shots.found for shots in mine), sum(shots.perforated for shots in mine))
