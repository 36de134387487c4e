"""Failure at a plastic strain: what has been sheared too far is broken.

The simplest of the erosion criteria of impact codes; the limit depends on the mesh and is an assumption of the user.
"""

from typing import NamedTuple

from solver.failure import FailureEntry, floor_until_failure, grown_damage
from solver.jit import implements
from solver.vectors import maximum, minimum


class PlasticStrainLimit(NamedTuple):
    """Damage is the part of the limit that has been used up."""

    limit: float  # equivalent plastic strain, greater than zero


FAILURE = FailureEntry("plastic_strain", PlasticStrainLimit)


@implements(grown_damage, PlasticStrainLimit)
def _(failure, damage, plastic_strain, pressure, dt):
    return maximum(damage, minimum(plastic_strain / failure.limit, 1.0))


@implements(floor_until_failure, PlasticStrainLimit)
def _(failure, floor):
    return floor
