"""A projectile perforates a plate: Ma (2005), section 3.1.1."""

from dataclasses import dataclass
from functools import partial
from typing import Annotated

from solver.units import Described, Radian
from studies.scenarios import Materials, Scenario, Setting, Size
from studies.scenarios._impact import assemble, check_shot, outline, size
from studies.scenarios._impact_observer import IMPACT
from studies.scenarios._method import ByMethod, check_method
from studies.scenarios._oblique import STEEPEST, Oblique, check_oblique
from studies.scenarios._plate import PlatePerforation, cells, check_plate, plate_radius
from studies.scenarios._settling import SettlingImpact, check_window, filled_settling
from studies.values.errors import Finding


@dataclass(frozen=True, kw_only=True)
class ThinPlate(ByMethod, PlatePerforation, Oblique, SettlingImpact):
    """Parameters of a perforation."""

    # Part of the identity of stored runs, at 0 too.
    obliquity: Annotated[
        Radian, Described("angle between the flight and the plate's normal; needs geometry half", 0.0, STEEPEST)
    ] = 0.0


def _fill(parameters: ThinPlate) -> ThinPlate:
    return filled_settling(parameters, plate_radius=plate_radius(parameters))


def _check(parameters: ThinPlate, materials: Materials) -> list[Finding]:
    return [
        *check_method(parameters),
        *check_shot(parameters, materials),
        *check_window(parameters),
        *check_oblique(parameters),
        *check_plate(parameters),
    ]


def _build(parameters: ThinPlate, materials: Materials) -> Setting:
    return assemble(parameters, materials, thickness=parameters.plate_thickness, radius=plate_radius(parameters))


def _size(parameters: ThinPlate, materials: Materials) -> Size:
    return size(parameters, thickness=parameters.plate_thickness, radius=plate_radius(parameters))


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
    fill=_fill,
    check=_check,
    build=_build,
    estimate=_size,
    cells=cells,
    observer=IMPACT,
    outline=partial(outline, thickness="plate_thickness", radius="plate_radius"),
)
