"""A projectile perforates a plate: Ma (2005), section 3.1.1."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from types import MappingProxyType
from typing import Annotated, Any, Self

from solver.units import Described, Radian
from studies.quantities.findings import Finding
from studies.quantities.numerical_defaults import DEFAULT_FAILURE, NO_FAILURE
from studies.scenarios import Materials, Scenario
from studies.scenarios.parts.impact import FEWEST_CELLS, LEAST_CELLS, Impact, SettlingImpact, outline
from studies.scenarios.parts.matter import Fracture
from studies.scenarios.parts.method import ParticleMethod, check_method, is_on_grid
from studies.scenarios.parts.numerics import Numerics
from studies.scenarios.parts.outline import Outline
from studies.scenarios.parts.shot import STEEPEST, Angles, ImpactShot, Plate, Settling

# The cap scales with the diameter, as everything does in a rate-independent material. 60 us at 8 mm: prototypes of
# copper plates crept for 30 us and longer on coarse grids.
CAP_PER_DIAMETER = 60e-6 / 8e-3  # s/m; a block needs longer


@dataclass(frozen=True, kw_only=True)
class PlateAngles(Angles):
    """Directions of flight and axis."""

    # Part of the identity of stored runs, at 0 too.
    obliquity: Annotated[
        Radian, Described("angle between the flight and the plate's normal; needs geometry half", 0.0, STEEPEST)
    ] = 0.0


@dataclass(frozen=True, kw_only=True)
class ThinPlate(SettlingImpact):
    """Parameters of a perforation."""

    experienced = MappingProxyType({name: name for name in ("hole_diameter", "hole_diameter_areal")})

    shot: ImpactShot
    fracture: Fracture
    numerics: Numerics
    settling: Settling
    angles: PlateAngles
    plate: Plate
    method: ParticleMethod

    @property
    def impact(self) -> Impact:
        """The projectile in front of the plate."""
        thickness, radius = self.plate.plate_thickness, self.plate.radius
        records = self.shot, self.fracture, self.numerics, self.angles, self.method
        return Impact(*records, thickness=thickness, radius=radius)

    def filled(self, materials: Materials) -> Self:
        diameter = self.shot.projectile_diameter
        return replace(
            self,
            fracture=self.fracture.filled(materials, DEFAULT_FAILURE if is_on_grid(self.method) else NO_FAILURE),
            shot=self.shot.filled(self.numerics, self.method, end_time=CAP_PER_DIAMETER * diameter),
            numerics=self.numerics.filled(few=self.shot.geometry != "axisymmetric", method=self.method),
            settling=self.settling.filled(diameter),
            plate=self.plate.filled(diameter),
        )

    def check(self, materials: Materials) -> list[Finding]:
        return [
            *check_method(self),
            *self.impact.check(materials),
            *self.settling.check(self.shot.projectile_diameter),
            *self.angles.check(self.shot),
            *self.plate.check(self.shot),
        ]

    @staticmethod
    def outline(values: Mapping[str, Any]) -> Outline | None:
        return outline(values, thickness="plate_thickness", radius="plate_radius")


SCENARIO = Scenario(
    name="thin_plate",
    title="Perforation of a plate",
    description="A sphere or cylinder hits a plate, at right angles or obliquely; the hole is measured.",
    parameters=ThinPlate,
    materials=("projectile", "target"),
    measurements=(
        "hole_diameter",
        "hole_diameter_areal",
        "hole_diameter_midplane",
        "hole_diameter_lip",
        "hole_diameter_largest",
        "hole_diameter_smallest",
        "hole_diameter_mean_root",
    ),
    settles=("hole_diameter",),
    accurate=("hole_diameter",),
    least_cells=LEAST_CELLS,
    fewest_cells=FEWEST_CELLS,
)
