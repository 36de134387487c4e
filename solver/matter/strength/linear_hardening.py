"""Isotropic linear hardening: a yield stress that grows with plastic strain, until melting."""

from typing import Annotated, NamedTuple

from solver.matter.strength import StrengthEntry
from solver.units import Described, Pascal


class LinearHardening(NamedTuple):
    """Parameters of sigma_y = yield_stress + hardening_modulus eps_p."""

    yield_stress: Annotated[Pascal, Described("initial yield stress", 0.0, 1e12, usual=(1e6, 5e9))]
    hardening_modulus: Annotated[Pascal, Described("hardening modulus", 0.0, 1e13, usual=(1e6, 1e11))]

    def hardening(self, plastic_strain):
        stress = self.yield_stress + self.hardening_modulus * plastic_strain
        return stress, self.hardening_modulus


STRENGTH = StrengthEntry("linear-hardening", LinearHardening)
