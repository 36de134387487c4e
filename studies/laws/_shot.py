"""Shots: the data that laws are asked about."""

import math
from dataclasses import dataclass

from solver.units import Dimensionless, Metre, MetrePerSecond, Radian
from studies.materials import Material


@dataclass(frozen=True)
class Shot:
    """The data of a shot that laws use: impact of a projectile on a plate or a block; features add targets."""

    speed: MetrePerSecond
    projectile_diameter: Metre  # diameter of the sphere with the projectile's volume
    plate_thickness: Metre | None  # None for a target without a back face
    projectile: Material
    target: Material
    obliquity: Radian = 0.0  # between the flight and the target's normal
    length_ratio: Dimensionless = 1.0  # length of the projectile over its own diameter

    @property
    def normal_speed(self) -> float:
        """Component of the velocity along the target's normal, m/s."""
        return self.speed * math.cos(self.obliquity)

    @property
    def density_ratio(self) -> float:
        """Density of the projectile over that of the target."""
        return self.projectile.density / self.target.density

    @property
    def mass(self) -> float:
        """Mass of the projectile, kg."""
        return self.projectile.density * math.pi / 6.0 * self.projectile_diameter**3

    @property
    def brinell_hardness(self) -> float:
        """Brinell hardness number of the target; NaN where its material states none."""
        hardness = self.target.brinell_hardness
        return math.nan if hardness is None else hardness

    @property
    def thickness_ratio(self) -> float:
        """t/d; NaN without a plate."""
        if self.plate_thickness is None:
            return math.nan
        return self.plate_thickness / self.projectile_diameter
