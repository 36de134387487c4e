"""A metal bar flattens against a rigid wall: Taylor (1948), Ma (2005), section 2.3.2."""

import math
from dataclasses import dataclass, replace
from types import MappingProxyType
from typing import TYPE_CHECKING, Annotated, Literal, Self

from solver.units import Described, Dimensionless, Metre, Second
from studies.bars.bar import Bar, BarDiameter, BarLength, BarSetUp, BarSpeed, CellsAcross, Wall
from studies.bars.loading import Loading
from studies.bars.setting import BarSetting
from studies.convergence.experience import MeshGrid
from studies.quantities.findings import Finding
from studies.quantities.parameters import Choice, MaterialName
from studies.quantities.units import round_quantity
from studies.scenarios import Materials, ObservationRate, Scenario, Size
from studies.scenarios.parts.matter import (
    HUGONIOT,
    check_boiling,
    check_constants,
    check_eos,
    elastic_speed,
    eos_forms,
    matter,
    yield_stress,
)
from studies.scenarios.parts.numerics import OF_TWO_BODIES, Numerics, ThermalSoftening, softens

if TYPE_CHECKING:
    from studies.materials import Material

# Ma (2005), section 2.3.2: until the kinetic energy no longer changes, 72 us for 25.4 mm.
END_PER_LENGTH = 72e-6 / 25.4e-3  # s/m
WINDOW = 1.0 / 12.0  # of the end time, over which growth is judged: 6 us of 72

# Radius of the grid over that of the bar: at least, and at most where a bar is softer or faster than any that was shot.
SPREAD, MOST_SPREAD = 3.0, 8.0
# Of the grid over the widening that Taylor's balance expects: the foot of a bar is softened by its own heat, and curls.
# Room alone, a fifth more than the widest shipped bar takes, 2.1 (aluminium 6061-T6 at 591 m/s): an empty node changes
# a number by no more than round-off.
MARGIN = 2.5
WORKED = 1.0  # plastic strain of the foot, at which its yield stress is taken


SIZES = ("final_length", "mushroom_diameter", "width_at_fifth")
# Parameters that say what is shot, on which grid, and how long it is observed: experience of mesh errors is about the
# defaults of all others.
SHOT = frozenset(
    {
        *("bar", "speed", "bar_length", "bar_diameter", "cells_per_diameter", "end_time", "stop", "settled_growth"),
        *("reference_length", "reference_diameter", "reference_width", "film_interval"),
    }
)


def spread(*, density: float, speed: float, yield_stress: float | None) -> float:
    """Radius of the grid over that of a bar (density in kg/m3, speed in m/s, yield stress in Pa).

    Matter that comes to rest at a wall is squeezed by e of its length, to an area 1 / (1 - e) times that of the bar,
    with rho v^2 / Y = e^2 / (1 - e): mass and momentum across the front of plastic flow, Taylor (1948), Proc. R. Soc. A
    194, 289.

    >>> e = 0.75
    >>> round(spread(density=e**2 / (1.0 - e), speed=1.0, yield_stress=1.0) / MARGIN, 12)
    2.0
    """
    if not yield_stress:
        return SPREAD
    ratio = density * speed**2 / yield_stress
    squeezed = 0.5 * (math.sqrt(ratio**2 + 4.0 * ratio) - ratio)
    return min(max(SPREAD, MARGIN / math.sqrt(1.0 - squeezed)), MOST_SPREAD)


@dataclass(frozen=True, kw_only=True)
class TaylorBar(BarSetUp):
    """Parameters of a Taylor bar."""

    experienced = MappingProxyType({name: name for name in SIZES})

    wall: Wall
    bar: Annotated[MaterialName, Described("material of the bar")] = "copper-thesis-taylor"
    speed: BarSpeed = 190.0
    bar_length: BarLength = 25.4e-3
    bar_diameter: BarDiameter = 7.6e-3
    cells_per_diameter: CellsAcross = 10.0
    end_time: Annotated[
        Second | None,
        Described("latest end of the run; by default 2.83 ms per metre of length, 72 us at 25.4 mm", 1e-9, 1.0),
    ] = None
    stop: Annotated[
        Literal["settled", "end_time"], Described("end once length and mushroom have settled, or at end_time only")
    ] = "end_time"
    settled_growth: Annotated[
        Dimensionless, Described("relative growth within a twelfth of end_time that counts as settled", 0.0, 0.5)
    ] = 0.005
    thermal_softening: ThermalSoftening = True
    eos_form: Annotated[
        str,
        Choice(eos_forms),
        Described("the material's own equation of state, the thesis' cubic form, or linear elasticity"),
    ] = HUGONIOT
    reference_length: Annotated[Metre | None, Described("final length to compare with", 1e-5, 1.0)] = None
    reference_diameter: Annotated[Metre | None, Described("mushroom diameter to compare with", 1e-5, 1.0)] = None
    reference_width: Annotated[Metre | None, Described("width at a fifth of the length to compare with", 1e-5, 1.0)] = (
        None
    )
    loading: Loading
    numerics: Numerics

    def filled(self, materials: Materials) -> Self:
        return replace(
            self,
            end_time=round_quantity(self.end_time or END_PER_LENGTH * self.bar_length),
            loading=self.loading.filled(),
            thermal_softening=softens(self.thermal_softening, materials.values()),
            numerics=self.numerics.filled(materials, unused=OF_TWO_BODIES),
        )

    def check(self, materials: Materials) -> list[Finding]:
        return [
            *self.numerics.check(self.end_time),
            *check_constants(materials),
            *check_eos(self.eos_form, materials),
            *check_boiling(self.numerics.choices.tension, self.thermal_softening, materials),
            *self.at_wall(materials["bar"]).check(),
        ]

    def at_wall(self, material: "Material") -> Bar:
        """The bar of a material at the wall."""
        sound = elastic_speed(material)
        fastest = self.fastest(material.density * sound)
        wide = spread(density=material.density, speed=fastest, yield_stress=yield_stress(material, WORKED))
        return Bar(
            self,
            density=material.density,
            sound=sound,
            height=self.bar_length + (fastest - self.speed) * self.end + 2.0 * self.cell,
            radius=0.5 * wide * self.bar_diameter,
        )

    def build(self, materials: Materials) -> BarSetting:
        material = materials["bar"]
        made = matter(
            material,
            eos_form=self.eos_form,
            thermal_softening=self.thermal_softening,
            tension=self.numerics.choices.tension,
        )
        references = (self.reference_length, self.reference_diameter, self.reference_width)
        return self.at_wall(material).build(made, references)

    def mesh_grids(self, materials: Materials) -> dict[str, MeshGrid]:
        strength = yield_stress(materials["bar"])
        if not strength or not self.has_defaults(materials, SHOT):
            return {}
        grid = MeshGrid(
            "",
            across=self.cells_per_diameter,
            through=math.inf,
            speed=self.speed,
            strength=strength,
            length=self.bar_length / self.bar_diameter,
        )
        return {name: replace(grid, quantity=name) for name in self.experienced}

    def size(self, materials: Materials) -> Size:
        return self.at_wall(materials["bar"]).size(elastic_speed(materials["bar"]))

    def rate(self, setting: BarSetting) -> ObservationRate:
        window = WINDOW * setting.problem.end_time
        return ObservationRate.settling(window, growth=self.settled_growth, stop=self.stop)


SCENARIO = Scenario(
    name="taylor_bar",
    title="Taylor bar",
    description="A bar hits a rigid frictionless wall end-on, or is pressed on it by loads, and flattens; its final "
    "shape is measured.",
    question="How does a bar flatten on a wall?",
    place=60,
    parameters=TaylorBar,
    materials=("bar",),
    measurements=("final_length", "mushroom_diameter", "width_at_fifth", "taylor_error"),
    asked_by={"taylor_error": ("reference_length", "reference_diameter", "reference_width")},
    settles=("final_length", "mushroom_diameter"),
    accurate=SIZES,
)
