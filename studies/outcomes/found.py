"""How many of the failures that were seen in shots simulations find.

A feature tells it for an outcome of its own through the entry-point group ``whipple.studies.outcomes.found``.
"""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

from solver.registry import entries
from studies.quantities.display import NONE

if TYPE_CHECKING:
    import xarray as xr

DEVIATE = 1.96  # standard normal deviate of an interval of 95 %


@dataclass(frozen=True)
class Share:
    """A share of shots, with Wilson's interval at 95 %; NaN of none."""

    count: int
    of: int

    @property
    def value(self) -> float:
        """The share itself."""
        return self.count / self.of if self.of else math.nan

    @property
    def interval(self) -> tuple[float, float]:
        """Wilson (1927), J. Am. Stat. Assoc. 22, 209.

        >>> [round(bound, 3) for bound in Share(8, 10).interval]
        [0.49, 0.943]
        """
        if not self.of:
            return math.nan, math.nan
        square = DEVIATE**2 / self.of
        middle = (self.value + square / 2.0) / (1.0 + square)
        half = math.sqrt(square * self.value * (1.0 - self.value) + square**2 / 4.0) / (1.0 + square)
        return max(0.0, middle - half), min(1.0, middle + half)

    @property
    def in_words(self) -> str:
        """With its interval: "7 of 9 (45 to 94 %)"."""
        if not self.of:
            return NONE
        low, high = (f"{100.0 * bound:.0f}" for bound in self.interval)
        return f"{self.count} of {self.of} ({low} to {high} %)"


Shares = Sequence[Share | None]


@dataclass(frozen=True)
class FailuresFound:
    """What published shots tell of an outcome: how many failures simulations like each point of a cube find."""

    name: str  # the outcome
    # At each point, None where no shots were simulated like it; None of a cube that does not say how it was computed.
    at: "Callable[[xr.Dataset], Shares | None]"


def found_at(points: "xr.Dataset", outcome: str) -> Shares | None:
    """Of the failures of published shots those that simulations like each point find; None where nothing tells."""
    known: FailuresFound | None = entries(__name__, "FOUND").get(outcome)
    return known.at(points) if known else None
