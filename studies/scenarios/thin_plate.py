"""A projectile perforates a plate: Ma (2005), section 3.1.1."""

import math
from dataclasses import dataclass
from typing import Annotated

from solver.units import Described, Metre, Radian
from studies.scenarios import Materials, Scenario, Setting, Size
from studies.scenarios._impact import (
    Impact,
    assemble,
    check_shot,
    filled,
    size,
    spacing,
)
from studies.scenarios._impact_watch import IMPACT
from studies.scenarios._matter import check_boiling, check_constants, check_eos, check_failure
from studies.values.errors import Finding

RADIUS = 3.5  # of the plate, in projectile diameters: fixed or free edges change the hole by less than 1 % (MPM3D-F90)

STEEPEST = math.radians(
    75.0
)  # beyond, a sphere skids along a plate that is too small to hold its path


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


def _radius(given: ThinPlate) -> float:
    return given.plate_radius or RADIUS * given.projectile_diameter


def _fill(given: ThinPlate) -> ThinPlate:
    return filled(given, plate_radius=_radius(given))


def _check(given: ThinPlate, materials: Materials) -> list[Finding]:
    findings = check_shot(given) + check_failure(given, materials)
    findings += check_eos(given.eos_form, materials) + check_constants(materials)
    findings += check_boiling(given, materials)
    findings += _check_obliquity(given)
    if _radius(given) < given.projectile_diameter:
        findings.append(
            Finding(
                "plate_radius",
                f"{_radius(given):g} m",
                f"at least the projectile's diameter, {given.projectile_diameter:g} m",
                "enlarge the plate; 3.5 diameters is the default",
            )
        )
    if given.plate_thickness < 0.5 * spacing(given):
        findings.append(
            Finding(
                "plate_thickness",
                f"{given.plate_thickness:g} m",
                f"at least half a cell, {0.5 * spacing(given):g} m",
                "raise the resolution (cells per diameter)",
            )
        )
    return findings


def _check_obliquity(given: ThinPlate) -> list[Finding]:
    if given.obliquity == 0.0:
        return []
    angle = f"{math.degrees(given.obliquity):g} deg"
    if given.geometry != "half":
        limit = "0 deg in a body of revolution or a quarter model"
        return [Finding("obliquity", angle, limit, "set geometry to half")]
    if given.projectile_shape != "sphere":
        return [Finding("obliquity", angle, "0 deg for a cylinder", "use a sphere")]
    return []


def _build(given: ThinPlate, materials: Materials) -> Setting:
    return assemble(
        given,
        materials,
        thickness=given.plate_thickness,
        radius=_radius(given),
        obliquity=given.obliquity,
    )


def _size(given: ThinPlate, materials: Materials) -> Size:
    return size(given, thickness=given.plate_thickness, radius=_radius(given))


def _cells(given: ThinPlate) -> dict[str, float]:
    return {
        "cells_per_diameter": given.cells_per_diameter,
        "cells_per_thickness": given.plate_thickness / spacing(given),
    }


SCENARIO = Scenario(
    name="thin_plate",
    title="Perforation of a plate",
    description="A sphere or cylinder hits a plate, at right angles or (a sphere) obliquely; the hole is measured.",
    parameters=ThinPlate,
    materials=("projectile", "target"),
    measurements=(
        "hole_diameter",
        "hole_diameter_clear",
        "hole_diameter_midplane",
        "hole_diameter_lip",
    ),
    settles=("hole_diameter",),
    fill=_fill,
    check=_check,
    build=_build,
    estimate=_size,
    cells=_cells,
    watch=IMPACT,
)
