"""A small plate, whose attached share is measured."""

from dataclasses import dataclass, replace
from typing import Annotated

from solver.units import Described, Dimensionless
from studies.scenarios import thin_plate


@dataclass(frozen=True, kw_only=True)
class SmallPlate(thin_plate.ThinPlate):
    """Parameters of the plate; it is coarse by default."""

    cells_per_diameter: Annotated[Dimensionless, Described("grid cells across the projectile's diameter", 2.0, 8.0)] = (
        2.0
    )


SCENARIO = replace(
    thin_plate.SCENARIO,
    name="small_plate",
    title="Perforation of a small plate",
    parameters=SmallPlate,
    measurements=("hole_diameter", "attached_share"),
)
