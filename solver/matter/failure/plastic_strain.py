"""Failure at a plastic strain: what has been sheared too far is broken.

The simplest criterion of impact codes; the limit depends on the mesh and is an assumption of the user.
"""

from typing import Annotated, NamedTuple

from solver.matter.failure import FailureEntry
from solver.units import Described, Dimensionless
from solver.vectors import maximum, minimum


class PlasticStrainLimit(NamedTuple):
    """Damage is the part of the limit that has been used up."""

    strain: Annotated[Dimensionless, Described("plastic strain at which matter fails", 1e-3, 100.0, usual=(0.01, 10.0))]

    def grown_damage(self, damage, loading):
        return maximum(damage, minimum(loading.plastic_strain / self.strain, 1.0))


FAILURE = FailureEntry("plastic-strain", PlasticStrainLimit)
