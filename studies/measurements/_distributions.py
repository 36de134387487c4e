"""Distributions: arrays over fixed bins, read off the last state of a run; a scenario names those of its runs.

How to add one: an entry of ``DISTRIBUTIONS``. Bins are those of every run, so that a cube has them as coordinates.
"""

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from studies.measurements._cloud import CloudView


@dataclass(frozen=True)
class Bins:
    """Bins of equal width; what lies beyond the last edge is in the last bin."""

    name: str
    title: str
    unit: str
    meaning: str
    width: float
    count: int

    @property
    def middles(self) -> list[float]:
        """The middle of each bin."""
        return [(place + 0.5) * self.width for place in range(self.count)]

    def place(self, values: np.ndarray) -> np.ndarray:
        """The bin (n,) of each value, none of which is negative."""
        return np.minimum((values / self.width).astype(np.int64), self.count - 1)


@dataclass(frozen=True)
class Distribution:
    """A quantity over bins."""

    name: str
    title: str
    unit: str
    meaning: str
    version: int
    bins: tuple[Bins, ...]
    read: Callable[[Any], np.ndarray]  # of a view, with the shape of the bins


SPEEDS = Bins("relative_speed", "relative speed", "1", "speed over the impact speed", 0.05, 30)
ANGLES = Bins(
    "angle_of_flight",
    "angle of flight",
    "rad",
    "angle between velocity and line of flight, 0 downrange, pi uprange",
    math.pi / 36.0,
    36,
)


def _mass(view: CloudView) -> np.ndarray:
    """Mass (speeds, angles) of all matter before and behind the plate, kg."""
    outside = view.behind() | view.before()
    along, across = view.axial_velocity[outside], view.transverse_velocity[outside]
    speed = SPEEDS.place(np.hypot(along, across) / view.speed)
    angle = ANGLES.place(np.arctan2(across, along))
    mass = np.zeros((SPEEDS.count, ANGLES.count))
    np.add.at(mass, (speed, angle), view.mass[outside])
    return mass


DISTRIBUTIONS: Mapping[str, Distribution] = {
    each.name: each
    for each in (
        Distribution(
            name="mass_over_velocity_and_angle",
            title="Mass over velocity and angle",
            unit="kg",
            meaning="mass of all matter before and behind the plate's original surfaces, over its speed and the angle "
            "of its flight; the last speed holds all that is faster",
            version=1,
            bins=(SPEEDS, ANGLES),
            read=_mass,
        ),
    )
}
