"""Steinberg, Cochran and Guinan: strength at high rates, where the rate no longer matters, follows the shear modulus.

G / G0 = 1 + A p / eta^(1/3) - B (T - 300 K), eta = rho / rho0, and in proportion less where gaps have opened
sigma_y = min(Y0 (1 + beta eps)^n, Y_max) G / G0

Steinberg, Cochran and Guinan (1980), J. Appl. Phys. 51, 1498; constants of metals in Steinberg (1996), UCRL-MA-106439.
The melting points of that report belong to the reference density: metal at 1 bar is thinner where it melts, and melts
below them. How much below is a matter of the expansion in the equation of state too.
"""

from typing import Annotated, NamedTuple

from solver.matter.melting import THINNEST_SOLID
from solver.matter.strength import StrengthEntry, solid
from solver.units import Below, Described, Dimensionless, Pascal, PerKelvin, PerPascal
from solver.vectors import maximum, minimum, power, where

COLD = 300.0  # K, the temperature of G0

# Of G0 in the law. With a tensile floor no solid comes to it, melting does first (contract test); molten matter bears
# no shear whatever it is, and is counted as molten.
SOFTEST = 0.1


class SteinbergGuinan(NamedTuple):
    """Parameters of the strength."""

    Y0: Annotated[Pascal, Described("initial yield stress", 0.0, 1e12, usual=(1e6, 5e9)), Below("Y_max", or_equal=True)]
    Y_max: Annotated[Pascal, Described("hardest yield stress", 0.0, 1e12, usual=(1e6, 1e10))]
    beta: Annotated[Dimensionless, Described("hardening", 0.0, 1e5, usual=(0.1, 1e4))]
    n: Annotated[Dimensionless, Described("hardening exponent", 0.0, 10.0, usual=(0.01, 1.5))]
    A: Annotated[PerPascal, Described("rise of the shear modulus with pressure", 0.0, 1e-9, usual=(1e-12, 5e-10))]
    B: Annotated[PerKelvin, Described("fall of the shear modulus with temperature", 0.0, 0.1, usual=(1e-5, 5e-3))]

    def hardening(self, plastic_strain):
        strained = 1.0 + self.beta * plastic_strain
        stress = self.Y0 * power(strained, self.n)
        slope = self.n * self.beta * stress / strained
        return minimum(stress, self.Y_max), where(stress < self.Y_max, slope, 0.0)

    def rate_and_heat(self, strain_rate, homologous, stiff):
        return stiff * solid(homologous)

    def stiffness(self, density_ratio, pressure, kelvin):
        pressed = self.A * pressure / power(density_ratio, 1.0 / 3.0)
        law = 1.0 + pressed - self.B * (kelvin - COLD)
        return maximum(law, SOFTEST) * minimum(density_ratio / THINNEST_SOLID, 1.0)


STRENGTH = StrengthEntry("steinberg-guinan", SteinbergGuinan)
