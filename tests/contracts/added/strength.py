"""Power-law hardening: sigma_y = Y (1 + eps)^n until melting."""

from typing import Annotated, NamedTuple

from solver.jit import implements
from solver.matter.strength import StrengthEntry, hardening, rate_and_heat, solid
from solver.units import Described, Dimensionless, Pascal
from solver.vectors import power


class PowerHardening(NamedTuple):
    """Parameters of the hardening."""

    Y: Annotated[Pascal, Described("initial yield stress", 0.0, 1e12)]
    n: Annotated[Dimensionless, Described("hardening exponent", 0.0, 1.0)]


STRENGTH = StrengthEntry("power-hardening", PowerHardening)


@implements(hardening, PowerHardening)
def hardening_of_power_hardening(strength, plastic_strain):
    stress = strength.Y * power(1.0 + plastic_strain, strength.n)
    return stress, strength.n * stress / (1.0 + plastic_strain)


@implements(rate_and_heat, PowerHardening)
def rate_and_heat_of_power_hardening(strength, strain_rate, homologous, stiff):
    return solid(homologous)
