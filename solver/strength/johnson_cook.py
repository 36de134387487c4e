"""Johnson-Cook: hardening, rate and temperature.

sigma_y = (A + B eps^n) (1 + C ln(rate / reference_rate)) (1 - T*^m): Johnson and Cook (1983); Ma (2005), Eq. 2-20.
The rate is not taken below the reference rate, where the logarithm was never fitted.
"""

from typing import NamedTuple

from solver.jit import implements
from solver.strength import StrengthEntry, hardening, rate_and_heat
from solver.vectors import SMALLEST, log, maximum, power, where


class JohnsonCook(NamedTuple):
    """Parameters of the Johnson-Cook yield stress."""

    A: float  # Pa
    B: float  # Pa
    n: float
    C: float
    m: float
    reference_rate: float  # 1/s


STRENGTH = StrengthEntry("johnson_cook", JohnsonCook)


@implements(hardening, JohnsonCook)
def _(strength, plastic_strain):
    hardened = strength.B * power(plastic_strain, strength.n)
    slope = strength.n * hardened / maximum(plastic_strain, SMALLEST)
    return strength.A + hardened, slope


@implements(rate_and_heat, JohnsonCook)
def _(strength, strain_rate, homologous, stiff):
    rate = 1.0 + strength.C * log(maximum(strain_rate * (1.0 / strength.reference_rate), 1.0))
    return rate * where(homologous >= 1.0, 0.0, 1.0 - power(homologous, strength.m))
