"""A projectile craters a thick block: Ma (2005), section 3.2."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from types import MappingProxyType
from typing import Annotated, Self

from solver.units import Described, Metre
from studies.quantities.findings import Finding
from studies.quantities.parameters import Plain
from studies.quantities.units import round_quantity
from studies.scenarios import Materials, Scenario
from studies.scenarios.parts.impact import FEWEST_CELLS, LEAST_CELLS, Impact, TargetSetUp, outline
from studies.scenarios.parts.outline import Outline
from studies.scenarios.parts.shot import Angles, Growing, ImpactShot

# Semi-infinite means three crater depths (attached spall below t = 3 p: Gehring, in Cour-Palais 1987); a copper crater
# at 7 km/s is 3.5 diameters deep and three wide on each side. A fixed rim and a free back make a crater at 6 km/s 2 %
# deeper here than in a block half as large again, absorbing edges less than 1 % (claim absorbing-block).
DEPTH, RADIUS = 11.0, 10.0  # of the block, in projectile diameters

# Nearer than this absorbing edges are refused: metal yields there, and the crater is 7 % shallower (the same case).
LEAST_ABSORBING = 5.0  # projectile diameters

# A cavity of radius R in a solid of strength Y stops within about R sqrt(rho / Y): its wall moves at sqrt(Y / rho) when
# what is left of the kinetic energy is what strength can still take up, and strength slows it by Y / (rho R). R of
# three diameters (above) in copper of 350 MPa, 8930 kg/m3: 15 ms per metre of diameter. Ma (2005), section 3.2, ran
# 45 us at 4.75 to 5.3 mm, 8.5 to 9.5 ms/m.
CAP_PER_DIAMETER = 15e-3  # s/m


@dataclass(frozen=True, kw_only=True)
class ThickPlate(TargetSetUp):
    """Parameters of a crater."""

    experienced = MappingProxyType(
        {name: name for name in ("crater_depth", "crater_diameter", "crater_depth_over_diameter")}
    )

    shot: ImpactShot
    settling: Growing
    angles: Angles
    target_depth: Annotated[Metre | None, Described("thickness of the block; by default 11 diameters", 1e-5, 10.0)] = (
        None
    )
    target_radius: Annotated[
        Metre | None,
        Described("radius of a round block, half the width of a square one; by default 10 diameters", 1e-5, 10.0),
    ] = None

    @property
    def impact(self) -> Impact:
        assert self.target_depth is not None
        assert self.target_radius is not None
        return Impact(self, thickness=self.target_depth, radius=self.target_radius, deep=True)

    def filled(self, materials: Materials) -> Self:
        diameter = self.shot.projectile_diameter
        return replace(
            self.with_shot(materials, end_time=CAP_PER_DIAMETER * diameter),
            settling=self.settling.filled(diameter),
            target_depth=round_quantity(self.target_depth or DEPTH * diameter),
            target_radius=round_quantity(self.target_radius or RADIUS * diameter),
        )

    def check(self, materials: Materials) -> list[Finding]:
        findings, diameter = super().check(materials), self.shot.projectile_diameter
        least, cure = 1.0, "enlarge the block, or use thin_plate"
        if self.shot.edges == "absorbing":
            least, cure = LEAST_ABSORBING, "enlarge the block, or choose other edges"
        for name, value in (("target_depth", self.impact.thickness), ("target_radius", self.impact.radius)):
            if value < least * diameter:
                limit = f"at least {least:g} of the projectile's diameter, {least * diameter:g} m"
                findings.append(Finding(name, f"{value:g} m", limit, cure))
        return findings

    @staticmethod
    def outline(values: Mapping[str, Plain]) -> Outline | None:
        return outline(values, thickness="target_depth", radius="target_radius")


SCENARIO = Scenario(
    name="thick_plate",
    title="Crater in a thick block",
    description="A sphere or cylinder hits a block, at right angles or obliquely; the crater is measured.",
    question="How deep is the crater in a block?",
    place=20,
    parameters=ThickPlate,
    materials=("projectile", "target"),
    measurements=(
        "crater_depth",
        "crater_diameter",
        "crater_depth_over_diameter",
        "crater_volume",
        "crater_lip_height",
        "crater_rebound",
        "crater_diameter_largest",
        "crater_diameter_smallest",
        "crater_diameter_mean_root",
    ),
    settles=("crater_depth", "crater_diameter"),
    accurate=("crater_depth", "crater_diameter"),
    least_cells=LEAST_CELLS,
    fewest_cells=FEWEST_CELLS,
)
