"""A debris cloud behind a plate at a stated time: Ma (2005), section 3.1.2.

A scenario of its own, because its end, its room and what is measured are not those of a hole: nothing of it settles,
and no run of ``thin_plate`` has another identity for it. The time is that of the literature, in the distance that the
projectile would have travelled; it is stated before a run, and not chosen after.
"""

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from types import MappingProxyType
from typing import TYPE_CHECKING, Annotated, Literal, Self

from solver.units import Described, Dimensionless, Second
from studies.debris.breakup import breakup_of
from studies.debris.setting import CloudSetting, Melting
from studies.quantities.findings import Finding
from studies.quantities.numerical_defaults import DebrisName
from studies.quantities.parameters import Plain
from studies.quantities.units import round_quantity
from studies.scenarios import Materials, ObservationRate, Scenario
from studies.scenarios.parts.impact import FEWEST_CELLS, LEAST_CELLS, REACH, Impact, ImpactSetUp, outline
from studies.scenarios.parts.outline import Outline
from studies.scenarios.parts.shot import Plate, Shot, TargetName

if TYPE_CHECKING:
    from solver.matter.laws import Matter
    from solver.state import Snapshot
    from studies.debris.cloud import CloudView
    from studies.materials import Material
    from studies.sections.section import SectionOptions

# Distance that the projectile would have travelled at the end, in its diameters: 8 mm, 6.6 km/s and 9 us in Ma (2005),
# section 3.1.2.
FLIGHT = 7.425

# Of the impact speed: matter leaves the back of a plate of the projectile's metal at twice the particle speed of the
# shock, which is the impact speed, and somewhat faster where jets form.
FASTEST = 1.1
BEHIND_TIP = 1.0  # grid behind the farthest place, projectile diameters
MOST_ROOM = 50.0  # projectile diameters

OBSERVATIONS = 30  # in a run
MOMENTS = (1.0 / 3.0, 2.0 / 3.0)  # of the run: sections before the end


@dataclass(frozen=True, kw_only=True)
class CloudShot(Shot):
    """A shot at a plate until a stated time, in a grid with room for its debris."""

    target: TargetName
    end_time: Annotated[
        Second | None,
        Described(
            "time after the first touch at which the cloud is measured; by default that in which the projectile would "
            "have travelled 7.425 diameters (9 us at 8 mm and 6.6 km/s)",
            1e-9,
            1.0,
        ),
    ] = None
    edges: Annotated[
        Literal["fixed", "free", "absorbing"],
        Described("what holds the plate's rim; debris that flies past it leaves the grid"),
    ] = "free"
    debris: Annotated[
        DebrisName | None,
        Described(
            "debris that is free of the plate and on a clear way out of the grid is followed to the edge, or retired: "
            "recorded, and flown straight from there"
        ),
    ] = "follow"
    downrange: Annotated[
        Dimensionless | None,
        Described(
            "grid behind the plate, in projectile diameters; by default a diameter more than matter at 1.1 times the "
            "impact speed flies until the end; what leaves flies straight from there",
            0.5,
            MOST_ROOM,
        ),
    ] = None
    beyond_edge: Annotated[
        Dimensionless | None, Described("grid outside a rim that is not fixed, in projectile diameters", 0.1, MOST_ROOM)
    ] = 2.0


@dataclass(frozen=True, kw_only=True)
class DebrisCloud(ImpactSetUp[CloudSetting, "CloudView"]):
    """Parameters of a debris cloud."""

    experienced = MappingProxyType({"tip_velocity_percent": "tip_velocity_percent"})

    shot: CloudShot
    plate: Plate

    @property
    def impact(self) -> Impact:
        return Impact(self, thickness=self.plate.plate_thickness, radius=self.plate.radius)

    def filled(self, materials: Materials) -> Self:
        shot, diameter = self.shot, self.shot.projectile_diameter
        end_time = shot.end_time or FLIGHT * diameter / shot.speed
        farthest = FASTEST * shot.speed * end_time / diameter
        downrange = round_quantity(shot.downrange or min(farthest + BEHIND_TIP, MOST_ROOM))
        roomy = replace(self, shot=replace(shot, downrange=downrange))
        return replace(roomy.with_shot(materials, end_time=end_time), plate=self.plate.filled(diameter))

    def check(self, materials: Materials) -> list[Finding]:
        return self.impact.check(materials) + self.plate.check(self.shot)

    def build(self, materials: Materials) -> CloudSetting:
        setting = self.impact.build(materials)
        bodies = setting.problem.bodies
        return CloudSetting(
            **vars(setting),
            breakup=tuple(breakup_of(materials[body.name]) for body in bodies),
            melting=tuple(_melting(materials[body.name], body.matter) for body in bodies),
        )

    @staticmethod
    def view(setting: CloudSetting, snapshot: "Snapshot") -> "CloudView":
        from studies.debris.cloud import view

        return view(setting, snapshot)

    def rate(self, setting: CloudSetting) -> ObservationRate:
        return ObservationRate(interval=setting.problem.end_time / OBSERVATIONS)

    def sections(self, setting: CloudSetting) -> "SectionOptions":
        from studies.sections.radiograph import PIXELS
        from studies.sections.section import SectionOptions

        moments = tuple(moment * setting.problem.end_time for moment in MOMENTS)
        return SectionOptions(
            moments=moments,
            reach=REACH * self.shot.projectile_diameter,
            pixel=self.shot.projectile_diameter / PIXELS,
            whole=2.0 * math.pi / setting.sector,
        )

    @staticmethod
    def outline(values: Mapping[str, Plain]) -> Outline | None:
        return outline(values, thickness="plate_thickness", radius="plate_radius")


def _melting(material: "Material", matter: "Matter") -> Melting | str:
    """How matter melts at no pressure, or the flag that says why that is not known."""
    from solver.matter.melting import onset_of_melting

    curve, thermal = matter.melting, material.thermal
    if thermal.melt_temperature is None:
        return "never_melts"
    if thermal.latent_heat_of_fusion is None:
        return "no_latent_heat"
    if curve.span:
        return Melting(onset_of_melting(matter), (curve.fusion + curve.span) * matter.eos.heat_capacity)
    if thermal.melting_density is not None:
        return "lindemann_reference"  # its melting point is that of the law, not the one at no pressure
    onset = thermal.heat_capacity * (thermal.melt_temperature - thermal.room_temperature)
    return Melting(onset, thermal.latent_heat_of_fusion)


SCENARIO = Scenario(
    name="debris_cloud",
    title="Debris cloud of a plate",
    description="A sphere or cylinder perforates a plate at right angles; the debris is measured at a stated time.",
    question="What debris flies behind a plate?",
    place=40,
    parameters=DebrisCloud,
    materials=("projectile", "target"),
    first=(
        *("tip_velocity_percent", "rear_velocity", "cloud_radius"),
        *("cloud_length", "momentum_behind", "melted_share_behind"),
    ),
    measurements=(
        "tip_velocity_percent",
        "tip_velocity_permille",
        "rear_velocity",
        "cloud_radius",
        "cloud_radius_place",
        "cloud_length",
        "cloud_length_over_diameter",
        "mass_behind",
        "mass_before",
        "momentum_behind",
        "momentum_before",
        "kinetic_energy_behind",
        "kinetic_energy_before",
        "internal_energy_behind",
        "internal_energy_before",
        "melted_share_behind",
        "melted_share_projectile",
        "fragments",
        "largest_fragment",
        "expansion_rate",
        "fragment_size_brittle",
        "fragment_size_ductile",
        "fragment_size_grady",
        "fragment_size_liquid",
    ),
    accurate=("tip_velocity_percent",),
    distributions=("mass_over_velocity_and_angle", "fragments_over_size", "fragment_mass_over_size"),
    least_cells=LEAST_CELLS,
    fewest_cells=FEWEST_CELLS,
)
