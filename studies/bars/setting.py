"""What the measurements of a bar need to know of a set-up."""

from dataclasses import dataclass
from typing import TYPE_CHECKING

from studies.measurements._settings import Setting

if TYPE_CHECKING:
    import numpy as np

# Length, mushroom diameter and width of a bar to be compared with, m.
References = tuple[float | None, float | None, float | None]


@dataclass(frozen=True, kw_only=True)
class BarSetting(Setting):
    """A bar at a wall."""

    length: float  # m
    speed: float  # m/s
    place: "np.ndarray"  # (n, 3) of each particle in the initial lattice: across, across, along
    references: References
