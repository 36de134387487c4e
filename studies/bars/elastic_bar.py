"""An elastic bar rebounds from a rigid wall: Ma (2005), section 2.3.1.

A slender bar whose Poisson's ratio is 0 is one-dimensional: it leaves the wall after 2 L / c with all of its momentum.
"""

import math
from dataclasses import dataclass, replace
from typing import Annotated, Self

from solver.units import Described, Dimensionless, KilogramPerCubicMetre, Pascal, Second
from studies.bars.bar import FASTEST, Bar, BarDiameter, BarLength, BarSetUp, BarSpeed, CellsAcross, Wall
from studies.bars.loading import Loading
from studies.bars.setting import BarSetting
from studies.quantities.findings import Finding
from studies.quantities.parameters import flat
from studies.quantities.units import round_quantity
from studies.scenarios import Materials, ObservationRate, Scenario, Size
from studies.scenarios.parts.matter import longitudinal_speed
from studies.scenarios.parts.method import MethodChoice, among
from studies.scenarios.parts.numerics import OF_TWO_BODIES, Numerics

TRANSITS = 2.0  # end of a run, in contact times 2 L / c: twice the time at the wall
OBSERVATIONS_PER_TRANSIT = 200  # contact time is read to 0.5 %
# Cells that a wave crosses between observations of a pressed bar, whose peaks are read, and observations at most.
OBSERVED, MOST_OBSERVED = 0.25, 2000
ROOM = 2.0  # cells of grid beside and behind the bar, besides its flight


@dataclass(frozen=True, kw_only=True)
class BarMethod(MethodChoice):
    """The choice of a method for a bar."""

    method: Annotated[
        str,
        among("mpm", "sph", "fem", "sph-fem"),
        Described(
            "material points on a grid (mpm), smoothed particles (sph), hexahedra (fem), or hexahedra in the half away "
            "from the wall, coupled to smoothed particles in the other one (sph-fem); the latter three in three "
            "dimensions, particles with a symmetric wall, and hexahedra with a square section"
        ),
    ] = "mpm"


@dataclass(frozen=True, kw_only=True)
class ElasticBar(BarSetUp):
    """Parameters of an elastic bar."""

    wall: Wall
    speed: BarSpeed = 300.0
    bar_length: BarLength = 10e-3
    bar_diameter: BarDiameter = 4e-3
    young_modulus: Annotated[Pascal, Described("Young's modulus of the bar", 1e5, 1e13)] = 100e9
    poisson_ratio: Annotated[Dimensionless, Described("Poisson's ratio of the bar", 0.0, 0.49)] = 0.3
    density: Annotated[KilogramPerCubicMetre, Described("density of the bar", 1.0, 3e4)] = 8900.0
    cells_per_diameter: CellsAcross = 4.0
    end_time: Annotated[
        Second | None,
        Described(
            "end of the run; by default twice the contact time 2 L / sqrt(E / rho) of a slender bar", 1e-12, 10.0
        ),
    ] = None
    loading: Loading
    numerics: Numerics
    method: BarMethod

    @property
    def transit(self) -> float:
        """Contact time of a slender bar, 2 L / c with c = sqrt(E / rho), s."""
        return 2.0 * self.bar_length / self.wave_speed

    @property
    def wave_speed(self) -> float:
        """Speed of a wave in a slender bar, m/s."""
        return math.sqrt(self.young_modulus / self.density)

    @property
    def shear_modulus(self) -> float:
        """G, Pa."""
        return self.young_modulus / (2.0 * (1.0 + self.poisson_ratio))

    @property
    def bulk_modulus(self) -> float:
        """K, Pa."""
        return self.young_modulus / (3.0 * (1.0 - 2.0 * self.poisson_ratio))

    @property
    def bar(self) -> Bar:
        """The bar at the wall."""
        room, sound = ROOM * self.cell, self.wave_speed
        fastest = self.fastest(self.density * sound)
        return Bar(
            self,
            density=self.density,
            sound=sound,
            height=self.bar_length + fastest * self.end + room,
            # A bar that is stopped at once widens by the strain v / c at most.
            radius=0.5 * self.bar_diameter * (1.0 + fastest / sound) + room,
        )

    def filled(self, materials: Materials) -> Self:
        numerics, is_solid = self.numerics, self.wall.geometry != "axisymmetric"
        if self.method.method != "mpm":
            numerics = replace(numerics, particles_per_cell=numerics.particles_per_cell or 1)
        return replace(
            self,
            end_time=round_quantity(self.end_time or TRANSITS * self.transit),
            loading=self.loading.filled(),
            method=self.method.filled(),
            numerics=numerics.filled(materials, few=is_solid, method=self.method, unused=(*OF_TWO_BODIES, "tension")),
        )

    def check(self, materials: Materials) -> list[Finding]:
        findings = self.method.check(flat(self)) + self.numerics.check(self.end_time, self.method)
        findings += self.bar.check()
        fastest = FASTEST * self.wave_speed
        if self.speed > fastest:
            limit = f"at most {fastest:g} m/s, {FASTEST:g} of the wave speed"
            cure = "choose a lower speed: linear elasticity holds only far below this limit"
            findings.append(Finding("speed", f"{self.speed:g} m/s", limit, cure))
        return findings

    def build(self, materials: Materials) -> BarSetting:
        from solver.matter.eos.linear_elastic import LinearElastic
        from solver.matter.laws import Matter
        from solver.matter.strength.elastic import Elastic
        from solver.matter.tension.unlimited import UnlimitedTension

        room = 293.0  # K; nothing depends on it
        matter = Matter(
            eos=LinearElastic(density=self.density, bulk_modulus=self.bulk_modulus, temperature=room),
            strength=Elastic(),
            tension=UnlimitedTension(),
            shear_modulus=self.shear_modulus,
            room_temperature=room,
            melt_temperature=math.inf,
        )
        return self.bar.build(matter)

    def size(self, materials: Materials) -> Size:
        return self.bar.size(longitudinal_speed(self.bulk_modulus, self.shear_modulus, self.density))

    def rate(self, setting: BarSetting) -> ObservationRate:
        interval = self.transit / OBSERVATIONS_PER_TRANSIT
        if self.loading.pressure:
            crossing = OBSERVED * self.cell / self.wave_speed
            interval = min(interval, max(crossing, self.end / MOST_OBSERVED))
        return ObservationRate(interval=interval)


SCENARIO = Scenario(
    name="elastic_bar",
    title="Elastic bar on a wall",
    description="An elastic bar hits a rigid frictionless wall end-on and rebounds, or is pressed on it by loads; "
    "contact, momentum, energy, the motion of its free end, and velocity and stress in its middle are measured.",
    question="How does an elastic bar rebound?",
    place=70,
    parameters=ElasticBar,
    materials=(),
    measurements=(
        "contact_time",
        "rebound_momentum",
        "wall_pull",
        "rigid_energy",
        "vibration_energy",
        "strain_energy",
        "lost_energy",
        "rear_face_place",
        "rear_face_velocity",
        "middle_velocity",
        "middle_stress",
        "middle_peak_velocity",
        "middle_peak_stress",
    ),
)
