"""Johnson-Cook: hardening, rate and temperature.

sigma_y = (A + B eps^n) (1 + C ln(rate / reference_rate)) (1 - T*^m): Johnson and Cook (1983); Ma (2005), Eq. 2-20.
The rate is not taken below the reference rate, where the logarithm was never fitted.

The modified form has (1 + rate / reference_rate)^C in place of the logarithm's factor, and the part alpha of the
plastic work becomes heat: Borvik et al. (1999), Int. J. Impact Eng. 22, 855, as the seed of coupled SPH and finite
elements quotes it (Zhang, Qiang and Gao).
"""

from typing import Annotated, NamedTuple

from solver.jit import device
from solver.matter.strength import StrengthEntry
from solver.units import Described, Dimensionless, Pascal, PerSecond
from solver.vectors import SMALLEST, log, maximum, power, where


@device
def hardening_by_power(strength, plastic_strain):
    """A + B eps^n, and its slope."""
    hardened = strength.B * power(plastic_strain, strength.n)
    slope = strength.n * hardened / maximum(plastic_strain, SMALLEST)
    return strength.A + hardened, slope


class JohnsonCook(NamedTuple):
    """Parameters of the Johnson-Cook yield stress."""

    A: Annotated[Pascal, Described("initial yield stress", 0.0, 1e12, usual=(1e6, 5e9))]
    B: Annotated[Pascal, Described("hardening", 0.0, 1e12, usual=(1e6, 1e10))]
    n: Annotated[Dimensionless, Described("hardening exponent", 0.0, 10.0, usual=(0.01, 1.5))]
    C: Annotated[Dimensionless, Described("rate sensitivity", 0.0, 10.0, usual=(1e-4, 0.5))]
    # infinite: no softening
    m: Annotated[Dimensionless | None, Described("softening exponent", 0.01, 100.0, usual=(0.1, 5.0))]
    reference_rate: Annotated[PerSecond, Described("reference strain rate", 1e-9, 1e9, usual=(1e-6, 1e5))]

    def hardening(self, plastic_strain):
        return hardening_by_power(self, plastic_strain)

    def rate_and_heat(self, strain_rate, homologous, stiff):
        rate = 1.0 + self.C * log(maximum(strain_rate * (1.0 / self.reference_rate), 1.0))
        return rate * where(homologous >= 1.0, 0.0, 1.0 - power(homologous, self.m))


class ModifiedJohnsonCook(NamedTuple):
    """Parameters of the modified Johnson-Cook yield stress."""

    A: Annotated[Pascal, Described("initial yield stress", 0.0, 1e12, usual=(1e6, 5e9))]
    B: Annotated[Pascal, Described("hardening", 0.0, 1e12, usual=(1e6, 1e10))]
    n: Annotated[Dimensionless, Described("hardening exponent", 0.0, 10.0, usual=(0.01, 1.5))]
    C: Annotated[Dimensionless, Described("rate exponent", 0.0, 1.0, usual=(1e-4, 0.5))]
    # infinite: no softening
    m: Annotated[Dimensionless | None, Described("softening exponent", 0.01, 100.0, usual=(0.1, 5.0))]
    reference_rate: Annotated[PerSecond, Described("reference strain rate", 1e-9, 1e9, usual=(1e-6, 1e5))]
    alpha: Annotated[Dimensionless, Described("part of the plastic work that becomes heat", 0.0, 1.0, usual=(0.3, 1.0))]

    def hardening(self, plastic_strain):
        return hardening_by_power(self, plastic_strain)

    def rate_and_heat(self, strain_rate, homologous, stiff):
        rate = power(1.0 + strain_rate * (1.0 / self.reference_rate), self.C)
        return rate * where(homologous >= 1.0, 0.0, 1.0 - power(homologous, self.m))

    def stored_part(self):
        return 1.0 - self.alpha


STRENGTH = (
    StrengthEntry("johnson-cook", JohnsonCook, melts=True),
    StrengthEntry("modified-johnson-cook", ModifiedJohnsonCook, melts=True),
)
