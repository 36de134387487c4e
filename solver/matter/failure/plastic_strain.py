"""Failure at a plastic strain: what has been sheared too far is broken.

The simplest criterion of impact codes; the limit depends on the mesh and is an assumption of the user.
"""

from typing import Annotated, NamedTuple

from solver.jit import implements
from solver.matter.failure import FailureEntry, grown_damage
from solver.units import Described, Dimensionless
from solver.vectors import maximum, minimum


class PlasticStrainLimit(NamedTuple):
    """Damage is the part of the limit that has been used up."""

    strain: Annotated[Dimensionless, Described("plastic strain at which matter fails", 1e-3, 100.0, usual=(0.01, 10.0))]


FAILURE = FailureEntry("plastic-strain", PlasticStrainLimit)


@implements(grown_damage, PlasticStrainLimit)
def grown_damage_of_plastic_strain_limit(failure, damage, loading):
    return maximum(damage, minimum(loading.plastic_strain / failure.strain, 1.0))
