"""Drucker and Prager: soil, rock and concrete, whose strength grows with the pressure.

The surface is a cone about the hydrostatic axis, tau = k + q p with tau = sqrt(J2) and the pressure p, positive in
compression; in tension it ends at the cut-off p = -t, and at its apex p = -k / q at the latest::

    sigma_y = sqrt(3) max(0, k + q max(p, -t))

Drucker and Prager (1952), Q. Appl. Math. 10, 157; ``*MAT_DRUCKER_PRAGER`` of LS-DYNA and ``dpm`` of MPM3D-F90 with
k_phi, q_phi and the tensile strength. Slip is without change of volume (dilatancy zero): the return to the cone is at
constant pressure, along the deviator. The pressure is that of the new density with the energy before the step: where
the equation of state does not depend on the energy, as with linear elasticity, the state lies on the cone exactly.
The tensile floor of the pressure itself is that of the rule of tension (``recoverable``), with the same t.
"""

import math
from typing import Annotated, NamedTuple

from solver.matter.eos import pressure_terms
from solver.matter.strength import StrengthEntry
from solver.units import Described, Dimensionless, FromMaterial, Pascal
from solver.vectors import maximum


class DruckerPrager(NamedTuple):
    """Parameters of the cone."""

    cohesion: Annotated[Pascal, Described("shear strength without pressure", 0.0, 1e12, usual=(1e4, 2e9))]  # k
    friction: Annotated[
        Dimensionless, Described("rise of the shear strength with pressure", 0.0, 10.0, usual=(0.05, 3.0))
    ]  # q
    tensile: Annotated[Pascal, FromMaterial("tension.spall_strength")]  # t
    pressure: Pascal = 0.0  # p of the present state

    def under_pressure(self, eos, density, energy):
        a, b = pressure_terms(eos, density, energy)
        return DruckerPrager(self.cohesion, self.friction, self.tensile, a + b * energy)

    def hardening(self, plastic_strain):
        pressure = maximum(self.pressure, -self.tensile)
        shear = self.cohesion + self.friction * pressure
        return math.sqrt(3.0) * maximum(shear, 0.0), 0.0


STRENGTH = StrengthEntry("drucker-prager", DruckerPrager)
