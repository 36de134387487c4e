"""Isotropic linear hardening: a yield stress that grows with plastic strain, until melting."""

from typing import Annotated, NamedTuple

from solver.jit import implements
from solver.strength import StrengthEntry, hardening, rate_and_heat, solid
from solver.units import Described, Pascal


class LinearHardening(NamedTuple):
    """Parameters of sigma_y = yield_stress + hardening_modulus eps_p."""

    yield_stress: Annotated[Pascal, Described("initial yield stress", 0.0, 1e12)]
    hardening_modulus: Annotated[Pascal, Described("hardening modulus", 0.0, 1e13)]


STRENGTH = StrengthEntry("linear-hardening", LinearHardening)


@implements(hardening, LinearHardening)
def _(strength, plastic_strain):
    stress = strength.yield_stress + strength.hardening_modulus * plastic_strain
    return stress, strength.hardening_modulus


@implements(rate_and_heat, LinearHardening)
def _(strength, strain_rate, homologous, stiff):
    return solid(homologous)
