"""What the measurements of two plates need to know of a set-up."""

from dataclasses import dataclass
from typing import TYPE_CHECKING

from studies.measurements._settings import Setting

if TYPE_CHECKING:
    import numpy as np


@dataclass(frozen=True, kw_only=True)
class PlateSetting(Setting):
    """Two plates, a flyer and a target."""

    speed: float  # m/s
    thicknesses: tuple[float, float]  # flyer, target; m
    section: float  # area of the column, m2 (m2 per radian)
    impedance: float  # rho0 c0 of the target, Pa s/m
    crossing: float  # when the first wave has crossed its plate, s
    layer: "np.ndarray"  # (n,) of each particle, counted from the interface
