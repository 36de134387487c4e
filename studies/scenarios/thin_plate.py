"""A projectile perforates a plate: Ma (2005), section 3.1.1."""

import math
from dataclasses import dataclass
from functools import partial
from typing import Annotated

from solver.units import Described, Metre, Radian
from studies.scenarios import Materials, Scenario, Setting, Size
from studies.scenarios._impact import (
    Impact,
    assemble,
    check_shot,
    filled,
    outline,
    size,
    spacing,
)
from studies.scenarios._impact_observer import IMPACT
from studies.values.errors import Finding

RADIUS = 3.5  # of the plate, in projectile diameters: fixed or free edges change the hole by less than 1 % (MPM3D-F90)

# Beyond, a sphere skids along a plate that is too small to hold its path.
STEEPEST = math.radians(75.0)


@dataclass(frozen=True, kw_only=True)
class ThinPlate(Impact):
    """Parameters of a perforation."""

    plate_thickness: Annotated[Metre, Described("thickness of the plate", 1e-6, 1.0)]
    obliquity: Annotated[
        Radian,
        Described(
            "angle between the flight and the plate's normal; needs geometry half", 0.0, STEEPEST
        ),
    ] = 0.0
    plate_radius: Annotated[
        Metre | None,
        Described(
            "radius of a round plate, half the width of a square one; by default 3.5 diameters",
            1e-5,
            10.0,
        ),
    ] = None


def _radius(parameters: ThinPlate) -> float:
    return parameters.plate_radius or RADIUS * parameters.projectile_diameter


def _fill(parameters: ThinPlate) -> ThinPlate:
    return filled(parameters, plate_radius=_radius(parameters))


def _check(parameters: ThinPlate, materials: Materials) -> list[Finding]:
    findings = check_shot(parameters, materials)
    findings += _check_obliquity(parameters)
    radius, diameter = _radius(parameters), parameters.projectile_diameter
    if radius < diameter:
        limit = f"at least the projectile's diameter, {diameter:g} m"
        cure = "enlarge the plate; 3.5 diameters is the default"
        findings.append(Finding("plate_radius", f"{radius:g} m", limit, cure))
    thickness, half_cell = parameters.plate_thickness, 0.5 * spacing(parameters)
    if thickness < half_cell:
        limit = f"at least half a cell, {half_cell:g} m"
        cure = "raise the resolution (cells per diameter)"
        findings.append(Finding("plate_thickness", f"{thickness:g} m", limit, cure))
    return findings


def _check_obliquity(parameters: ThinPlate) -> list[Finding]:
    if parameters.obliquity == 0.0:
        return []
    angle = f"{math.degrees(parameters.obliquity):g} deg"
    if parameters.geometry != "half":
        limit = "0 deg in a body of revolution or a quarter model"
        return [Finding("obliquity", angle, limit, "set geometry to half")]
    if parameters.projectile_shape != "sphere":
        return [Finding("obliquity", angle, "0 deg for a cylinder", "use a sphere")]
    return []


def _build(parameters: ThinPlate, materials: Materials) -> Setting:
    return assemble(
        parameters,
        materials,
        thickness=parameters.plate_thickness,
        radius=_radius(parameters),
        obliquity=parameters.obliquity,
    )


def _size(parameters: ThinPlate, materials: Materials) -> Size:
    return size(parameters, thickness=parameters.plate_thickness, radius=_radius(parameters))


def _cells(parameters: ThinPlate) -> dict[str, float]:
    return {
        "cells_per_diameter": parameters.cells_per_diameter,
        "cells_per_thickness": parameters.plate_thickness / spacing(parameters),
    }


SCENARIO = Scenario(
    name="thin_plate",
    title="Perforation of a plate",
    description="A sphere or cylinder hits a plate, at right angles or (a sphere) obliquely; the hole is measured.",
    parameters=ThinPlate,
    materials=("projectile", "target"),
    measurements=(
        "hole_diameter",
        "hole_diameter_areal",
        "hole_diameter_midplane",
        "hole_diameter_lip",
    ),
    settles=("hole_diameter",),
    fill=_fill,
    check=_check,
    build=_build,
    estimate=_size,
    cells=_cells,
    observer=IMPACT,
    outline=partial(outline, thickness="plate_thickness", radius="plate_radius"),
)
