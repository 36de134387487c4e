"""A small plate, whose attached share is measured."""

from dataclasses import dataclass, replace
from typing import Annotated

from solver.units import Described, Dimensionless
from studies.scenarios import thin_plate
from studies.scenarios.parts.shot import ImpactShot


@dataclass(frozen=True, kw_only=True)
class CoarseShot(ImpactShot):
    """A shot that is coarse by default."""

    cells_per_diameter: Annotated[Dimensionless, Described("grid cells across the projectile's diameter", 2.0, 8.0)] = (
        2.0
    )


@dataclass(frozen=True, kw_only=True)
class SmallPlate(thin_plate.ThinPlate):
    """Parameters of the plate."""

    shot: CoarseShot


SCENARIO = replace(
    thin_plate.SCENARIO,
    name="small_plate",
    title="Perforation of a small plate",
    parameters=SmallPlate,
    measurements=("hole_diameter", "attached_share"),
)
