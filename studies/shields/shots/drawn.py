"""What drawn shots say of simulations, by range of the normal speed: what they add to P, and which failures they find.

``joined`` writes both, from the outcomes of the shots that were drawn and simulated (docs/pages/simulated_shields.py).
"""

import json
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any, Literal

from studies.outcomes.found import Share
from studies.shields.shots.judged import RANGES, range_of

FAST = RANGES[1][1]  # m/s: slower shots are counted apart
STORED = Path(__file__).with_name("joined.json")


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

    @property
    def is_gain(self) -> bool:
        """Whether P with the simulation is better at the lower bound of its interval."""
        return self.gained - self.within > 0.0


@cache
def stored() -> Mapping[str, Mapping[str, Any]]:
    """What is stored of each kind, by its name; nothing before shots were simulated."""
    kinds: Mapping[str, Mapping[str, Any]] = json.loads(STORED.read_text(encoding="utf-8")) if STORED.exists() else {}
    return kinds


def ranges_of(kind: SimulationKind) -> tuple[DrawnShots, ...]:
    """The drawn shots of a kind by range of the normal speed; none of one that no shots were simulated by."""
    return tuple(DrawnShots(**each) for each in stored().get(kind.name, {}).get("ranges", ()))


def failures_found(failure: str, normal_speed: float) -> Share | None:
    """How many perforated walls simulations with a failure on one grid find, below 3 km/s or from there on.

    None where no shots were simulated with it.
    """
    ranges = ranges_of(SimulationKind((failure,), "one"))
    mine = [each for place, each in enumerate(ranges) if (place == 0) == (range_of(normal_speed) == 0)]
    return Share(sum(each.found for each in mine), sum(each.perforated for each in mine)) if mine else None


def beside_held(found: Share | None) -> str:
    """What stands beside a simulated wall that holds: "such simulations found 7 of 17 walls that were perforated"."""
    if found is None:
        return "no published shots were simulated like this"
    return f"such simulations found {found.count} of {found.of} walls that were perforated"


def beside_walls(failures: Iterable[str]) -> str:
    """What stands below a table of simulated walls, by the failures of its runs."""
    told = {each: beside_held(failures_found(each, FAST)) for each in failures}
    each = [f"with failure {failure}, {text}" for failure, text in told.items()]
    return f"Where a wall holds at {FAST / 1e3:g} km/s or faster: {'; '.join(each)}."
