"""A projectile perforates a plate: Ma (2005), section 3.1.1."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from types import MappingProxyType
from typing import Self

from studies.quantities.findings import Finding
from studies.quantities.numerical_defaults import DEFAULT_FAILURE, NO_FAILURE
from studies.quantities.parameters import Plain
from studies.scenarios import Materials, Scenario
from studies.scenarios.parts.impact import FEWEST_CELLS, LEAST_CELLS, Impact, TargetSetUp, outline
from studies.scenarios.parts.method import ParticleMethod
from studies.scenarios.parts.outline import Outline
from studies.scenarios.parts.shot import Angles, Growing, ImpactShot, Plate

# The cap scales with the diameter, as everything does in a rate-independent material. 60 us at 8 mm: prototypes of
# copper plates crept for 30 us and longer on coarse grids.
CAP_PER_DIAMETER = 60e-6 / 8e-3  # s/m; a block needs longer


@dataclass(frozen=True, kw_only=True)
class ThinPlate(TargetSetUp):
    """Parameters of a perforation."""

    experienced = MappingProxyType({name: name for name in ("hole_diameter", "hole_diameter_areal")})

    shot: ImpactShot
    settling: Growing
    angles: Angles
    plate: Plate
    method: ParticleMethod

    @property
    def impact(self) -> Impact:
        """The projectile in front of the plate."""
        return Impact(self, thickness=self.plate.plate_thickness, radius=self.plate.radius)

    def filled(self, materials: Materials) -> Self:
        diameter = self.shot.projectile_diameter
        failure = DEFAULT_FAILURE if self.method.is_on_grid else NO_FAILURE
        return replace(
            self.with_shot(materials, end_time=CAP_PER_DIAMETER * diameter, failure=failure),
            settling=self.settling.filled(diameter),
            plate=self.plate.filled(diameter),
            method=self.method.filled(),
        )

    def check(self, materials: Materials) -> list[Finding]:
        return [*super().check(materials), *self.plate.check(self.shot)]

    @staticmethod
    def outline(values: Mapping[str, Plain]) -> Outline | None:
        return outline(values, thickness="plate_thickness", radius="plate_radius")


SCENARIO = Scenario(
    name="thin_plate",
    title="Perforation of a plate",
    description="A sphere or cylinder hits a plate, at right angles or obliquely; the hole is measured.",
    question="How large is the hole in a plate?",
    place=10,
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
