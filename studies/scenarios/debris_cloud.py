"""A debris cloud behind a plate at a stated time: Ma (2005), section 3.1.2.

A scenario of its own, because its end, its room and what is measured are not those of a hole: nothing of it settles,
and no run of ``thin_plate`` has another identity for it. The time is that of the literature, in the distance that the
projectile would have travelled; it is stated before a run, and not chosen after.
"""

import math
from dataclasses import dataclass, replace
from functools import partial
from typing import TYPE_CHECKING, Annotated, Any, Literal

from solver.units import Described, Dimensionless, Second
from studies.scenarios import (
    CloudSetting,
    Materials,
    Melting,
    ObservationRate,
    ObserverOptions,
    Scenario,
    Setting,
    Size,
)
from studies.scenarios._impact import assemble, check_shot, filled, has_free_rim, outline, size
from studies.scenarios._impact_observer import IMPACT, REACH
from studies.scenarios._plate import PlatePerforation, cells, check_plate, plate_radius
from studies.values.errors import Finding
from studies.values.quantities import round_quantity
from studies.values.recipes import DebrisName

if TYPE_CHECKING:
    from studies.films.section import SectionOptions
    from studies.materials import Material

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
PIXELS = 24.0  # of a radiograph, across the projectile


@dataclass(frozen=True, kw_only=True)
class DebrisCloud(PlatePerforation):
    """Parameters of a debris cloud."""

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
        Dimensionless,
        Described("grid outside a rim that is not fixed, in projectile diameters", 0.1, MOST_ROOM, acts=has_free_rim),
    ] = 2.0


def _fill(parameters: DebrisCloud) -> DebrisCloud:
    diameter = parameters.projectile_diameter
    end = parameters.end_time or FLIGHT * diameter / parameters.speed
    farthest = FASTEST * parameters.speed * end / diameter
    downrange = parameters.downrange or min(farthest + BEHIND_TIP, MOST_ROOM)
    return filled(
        replace(parameters, downrange=round_quantity(downrange)), end_time=end, plate_radius=plate_radius(parameters)
    )


def _check(parameters: DebrisCloud, materials: Materials) -> list[Finding]:
    return check_shot(parameters, materials) + check_plate(parameters)


def _build(parameters: DebrisCloud, materials: Materials) -> Setting:
    setting = assemble(parameters, materials, thickness=parameters.plate_thickness, radius=plate_radius(parameters))
    melting = tuple(_melting(materials[body.name]) for body in setting.problem.bodies)
    return CloudSetting(**vars(setting), melting=melting)


def _melting(material: "Material") -> Melting | str:
    """How matter melts at no pressure, or the flag that says why that is not known."""
    thermal = material.thermal
    if thermal.melt_temperature is None:
        return "never_melts"
    if material.strength.kind == "steinberg-guinan":
        return "lindemann_reference"  # its melting point is that of the law, not the one at no pressure
    if thermal.latent_heat_of_fusion is None:
        return "no_latent_heat"
    return Melting(
        heat_capacity=thermal.heat_capacity,
        room_temperature=thermal.room_temperature,
        melt_temperature=thermal.melt_temperature,
        latent_heat=thermal.latent_heat_of_fusion,
    )


def _size(parameters: DebrisCloud, materials: Materials) -> Size:
    return size(parameters, thickness=parameters.plate_thickness, radius=plate_radius(parameters))


def _rate(parameters: DebrisCloud, setting: Setting) -> ObservationRate:
    return ObservationRate(interval=setting.problem.end_time / OBSERVATIONS)


def _view(setting: CloudSetting, snapshot: Any) -> Any:
    from studies.measurements._cloud import view

    return view(setting, snapshot)


def _sections(parameters: DebrisCloud, setting: CloudSetting) -> "SectionOptions":
    from studies.films.section import SectionOptions

    moments = tuple(moment * setting.problem.end_time for moment in MOMENTS)
    return SectionOptions(
        moments=moments,
        reach=REACH * setting.projectile_diameter,
        pixel=setting.projectile_diameter / PIXELS,
        whole=2.0 * math.pi / setting.sector,
    )


SCENARIO = Scenario(
    name="debris_cloud",
    title="Debris cloud of a plate",
    description="A sphere or cylinder perforates a plate at right angles; the debris is measured at a stated time.",
    parameters=DebrisCloud,
    materials=("projectile", "target"),
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
    ),
    settles=(),
    fill=_fill,
    check=_check,
    build=_build,
    estimate=_size,
    cells=cells,
    observer=ObserverOptions(
        rate=_rate, view=_view, sections=_sections, least_cells=IMPACT.least_cells, fewest_cells=IMPACT.fewest_cells
    ),
    distributions=("mass_over_velocity_and_angle",),
    measured_with=("thermal.latent_heat_of_fusion",),
    outline=partial(outline, thickness="plate_thickness", radius="plate_radius"),
)
