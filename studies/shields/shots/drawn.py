"""What drawn shots say of simulations, by range of the normal speed: what they add to P, and which failures they find.

``joined`` writes both, from the outcomes of the shots that were drawn and simulated (docs/pages/simulated_shields.py).
"""

import json
import math
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Literal

from studies.outcomes.found import DEVIATE, Share
from studies.shields.shots.judged import RANGES, range_of
from studies.shields.shots.records import Probability

FAST = RANGES[1][1]  # m/s: slower shots are counted apart
STORED = Path(__file__).with_name("joined.json")
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

    @property
    def is_gain(self) -> bool:
        """Whether P with the simulation is better at the lower bound of its interval."""
        return self.gained - self.within > 0.0


@dataclass(frozen=True)
class Joint:
    """What the outcome of a simulation adds to the logit of the probability."""

    perforated: float
    held: float
    covariance: tuple[tuple[float, float], tuple[float, float]]
    shots: int  # of the fit
    ranges: tuple[DrawnShots, ...] = ()  # of the normal speed

    def is_joined_at(self, normal_speed: float) -> bool:
        """Whether such simulations are seen to help at a normal speed, m/s."""
        return bool(self.ranges) and self.ranges[range_of(normal_speed)].is_gain

    def probability(self, before: Probability, told: Simulated) -> Probability:
        """The probability with the outcome of a simulation; one that is certain in double precision stays."""
        from studies.shields.shots.chance import expit, logit  # with NumPy, without which pages count shots

        if told == "open" or before.value in (0.0, 1.0):
            return before
        place = ("perforated", "held").index(told)
        shift, variance = (self.perforated, self.held)[place], self.covariance[place][place]
        middle, low, high = (float(logit(chance)) for chance in (before.value, before.low, before.high))
        down, up = (math.hypot(end - middle, DEVIATE * math.sqrt(variance)) for end in (low, high))
        return Probability(*(float(expit(middle + shift + by)) for by in (0.0, -down, up)))


@cache
def stored() -> Mapping[str, Joint]:
    """What is stored of each kind of simulation that shots were simulated by, by its name."""
    kinds = json.loads(STORED.read_text(encoding="utf-8"))
    ranges = {name: tuple(DrawnShots(**place) for place in kind["ranges"]) for name, kind in kinds.items()}
    return {name: Joint(**{**kind, "ranges": ranges[name]}) for name, kind in kinds.items()}


def failures_found(failure: str, normal_speed: float) -> Share | None:
    """How many perforated walls simulations with a failure on one grid find, below 3 km/s or from there on.

    None where no shots were simulated with it.
    """
    kind = stored().get(SimulationKind((failure,), "one").name)
    if kind is None:
        return None
    mine = kind.ranges[:1] if range_of(normal_speed) == 0 else kind.ranges[1:]
    return Share(sum(shots.found for shots in mine), sum(shots.perforated for shots in mine))
