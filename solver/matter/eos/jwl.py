"""Jones, Wilkins and Lee: detonation products, lit by a programmed burn.

With V = rho0 / rho and E = rho0 e, energy per initial volume, the products have::

    p_s = A (1 - omega / (R1 V)) exp(-R1 V) + B (1 - omega / (R2 V)) exp(-R2 V) + omega E / V

Lee, Hornig and Kury (1968), UCRL-50422. The explosive begins with E = E0, its chemical energy, so that the energy of
the audit holds it from the start and burning moves it within the balance. The pressure is F p_s with the burnt fraction

    F = min(1, (t - t_l) D / (width h)), 0 before t_l

of the time t, the time t_l at which the detonation reaches the particle, its velocity D, and cells of h: LS-DYNA Theory
Manual, material 8, ``*MAT_HIGH_EXPLOSIVE_BURN``, where F1 = 2 (t - t_l) D A_max / (3 v) is 1 after 1.5 edges of a cube.
Unburnt matter is without pressure; nothing moves it before the detonation, which outruns all sound.

On the isentrope of the products p V^(omega + 1) falls to its last term::

    p_i = A exp(-R1 V) + B exp(-R2 V) + C V^-(omega + 1)

The exponential terms belong to a curve of room temperature, beyond which heat follows from the heat capacity. Material
files do not name this form: where it is lit is a matter of the set-up.
"""

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from solver.jit import device
from solver.matter.eos import EosEntry
from solver.state import LIGHTING
from solver.units import Density, Dimensionless, HeatCapacity, MetrePerSecond, Pascal, RoomTemperature
from solver.vectors import exp, load, maximum, minimum

BURN_WIDTH = 1.5  # cells over which the burnt fraction rises: LS-DYNA's, see above


class JonesWilkinsLee(NamedTuple):
    """Parameters of an explosive and its products."""

    density: Density  # rho0
    A: Pascal
    B: Pascal
    R1: Dimensionless
    R2: Dimensionless
    omega: Dimensionless
    E0: Pascal  # chemical energy per initial volume, J/m3
    detonation_velocity: MetrePerSecond  # D
    temperature: RoomTemperature  # temperature of the unburnt explosive
    heat_capacity: HeatCapacity = math.inf  # cv of the products; inf: the temperature stays
    width: Dimensionless = BURN_WIDTH  # width of the burning zone, cells
    burnt: Dimensionless = 0.0  # F

    def burns(self):
        return True

    def burning(self, table, p, lanes, time, spacing):
        lighting = load(table, LIGHTING, p, lanes)
        return JonesWilkinsLee(*self[:-1], burnt_fraction(self, lighting, time, spacing))

    def pressure_terms(self, density, energy):
        _, _, cold, _ = _terms(self, density)
        return self.burnt * cold, self.burnt * (self.omega * density)

    def sound_speed_squared(self, density, energy, pressure):
        _, _, _, slope = _terms(self, density)
        # dV = -V / rho drho; at constant entropy de = p / rho^2 drho.
        compressed = -slope * self.density / (density * density) + self.omega * energy
        return self.burnt * (compressed + self.omega * pressure / density)

    def temperature_at(self, density, energy):
        first, second, _, _ = _terms(self, density)
        cold = (first / self.R1 + second / self.R2) / self.density
        return self.temperature + self.burnt * (energy - cold) / self.heat_capacity

    def reference_sound_speed(self):
        return self.detonation_velocity


EOS = EosEntry("jwl", JonesWilkinsLee, JonesWilkinsLee)


def lighting_times(position: np.ndarray, velocity: float, points: Sequence[Sequence[float]]) -> np.ndarray:
    """Time (n,), s, at which a detonation of a velocity (m/s) reaches places (n, 3).

    It sets out at time zero from points; the first to arrive counts.

    >>> lighting_times(np.array([[0.03, 0.04, 0.0]]), 5000.0, [(0.0, 0.0, 0.0), (1.0, 0.0, 0.0)])
    array([1.e-05])
    """
    far = np.full(len(position), math.inf)
    for point in points:
        far = np.minimum(far, np.linalg.norm(position - np.asarray(point), axis=1))
    return far / velocity


@device
def burnt_fraction(eos, lighting, time, spacing):
    """F of matter that is lit at a time (s), now, in cells of a size (m)."""
    run = (time - lighting) * (eos.detonation_velocity / (eos.width * spacing))
    return minimum(maximum(run, 0.0), 1.0)


@device
def _terms(eos, density):
    """The two exponential terms of p_s at the volume of a density, and their sum's slope with the volume."""
    volume = eos.density / density
    first, second = eos.A * exp(-eos.R1 * volume), eos.B * exp(-eos.R2 * volume)
    thermal = eos.omega / volume
    cold = first * (1.0 - thermal / eos.R1) + second * (1.0 - thermal / eos.R2)
    slope = first * (thermal - eos.R1 + thermal / (eos.R1 * volume))
    slope = slope + second * (thermal - eos.R2 + thermal / (eos.R2 * volume))
    return first, second, cold, slope
