"""Exact waves and vibrations of linear elastic matter: speeds, a bar between wall and free end."""

import math
from dataclasses import dataclass

import numpy as np

from solver.state import Particles
from solver.units import Dimensionless, KilogramPerCubicMetre, Metre, MetrePerSecond, Pascal


@dataclass(frozen=True)
class Isotropic:
    """Linear elastic matter."""

    density: KilogramPerCubicMetre
    young: Pascal
    poisson: Dimensionless

    @property
    def bulk_modulus(self) -> float:
        """K, Pa."""
        return self.young / (3.0 * (1.0 - 2.0 * self.poisson))

    @property
    def shear_modulus(self) -> float:
        """G, Pa."""
        return self.young / (2.0 * (1.0 + self.poisson))

    @property
    def bar_speed(self) -> float:
        """Speed of long waves in a thin bar, m/s; the thesis' bar has 3352 m/s (Ma 2005, section 2.3.1).

        >>> round(Isotropic(8900.0, 100e9, 0.3).bar_speed)
        3352
        """
        return math.sqrt(self.young / self.density)

    @property
    def longitudinal_speed(self) -> float:
        """Speed of plane waves in uniaxial strain, m/s; 3889 m/s for the matter of the thesis' bar.

        >>> round(Isotropic(8900.0, 100e9, 0.3).longitudinal_speed)
        3889
        """
        return math.sqrt((self.bulk_modulus + 4.0 / 3.0 * self.shear_modulus) / self.density)


COPPER = Isotropic(8930.0, 117e9, 0.35)  # Ma (2005), Table 2.1
COPPER_BAR = Isotropic(8930.0, 117e9, 0.0)  # its stiffness, without Poisson's effect


def strain_energy_density(matter: Isotropic, p: Particles) -> np.ndarray:
    """Elastic energy (n,) of the particles' stress, p^2 / 2 K + s:s / 4 G, J/m3."""
    shear = (p.deviator[:, :3] ** 2).sum(axis=1) + 2.0 * (p.deviator[:, 3:] ** 2).sum(axis=1)
    energy: np.ndarray = p.pressure**2 / (2.0 * matter.bulk_modulus)
    return energy + shear / (4.0 * matter.shear_modulus)


@dataclass(frozen=True)
class Vibration:
    """The first longitudinal mode of a bar held at x = 0 and free at its length; v(x, 0) = v0 sin(pi x / 2 L)."""

    matter: Isotropic
    length: Metre
    amplitude: MetrePerSecond  # v0

    @property
    def frequency(self) -> float:
        """Angular frequency, rad/s; 0.62832 for L = 25, E = 100, rho = 1.

        >>> round(Vibration(Isotropic(1.0, 100.0, 0.0), 25.0, 0.1).frequency, 5)
        0.62832
        """
        return 0.5 * math.pi * self.matter.bar_speed / self.length

    def mean_velocity(self, time: float) -> float:
        """Velocity of the centre of mass, (2 v0 / pi) cos(omega t)."""
        return 2.0 * self.amplitude / math.pi * math.cos(self.frequency * time)
