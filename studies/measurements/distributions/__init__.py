"""Distributions: arrays over bins that are read off the last state of a run; its scenario names them.

How to add one: an entry of the group ``whipple.studies.measurements.distributions``; it offers no module here.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING

from solver.registry import entries

if TYPE_CHECKING:
    import numpy as np


@dataclass(frozen=True)
class Bins:
    """Bins of equal width; what lies beyond the first or last edge is in the first or last bin."""

    name: str
    title: str
    unit: str
    meaning: str
    width: float
    count: int
    begin: float = 0.0  # of the first bin

    @property
    def middles(self) -> list[float]:
        """The middle of each bin."""
        return [self.begin + (place + 0.5) * self.width for place in range(self.count)]

    def place(self, values: "np.ndarray") -> "np.ndarray":
        """The bin (n,) of each value."""
        return ((values - self.begin) / self.width).astype(int).clip(0, self.count - 1)


@dataclass(frozen=True)
class Distribution:
    """A quantity over bins, read off the last state of a run. Bins are those of every run, so coordinates of a cube."""

    name: str
    title: str
    unit: str
    meaning: str
    bins: tuple[Bins, ...]
    read: Callable[..., "np.ndarray"]  # of a view of its family, with the shape of the bins
    version: int = 1


def load(name: str) -> Distribution:
    """The distribution of a name; KeyError for an unknown one."""
    distribution: Distribution = entries(__name__, "DISTRIBUTION")[name]
    return distribution
