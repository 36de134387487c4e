"""The plate of an impact: its parameters, its checks, and its resolution."""

from dataclasses import dataclass
from typing import Annotated

from solver.units import Described, Metre
from studies.scenarios._impact import Impact, spacing
from studies.values.errors import Finding

RADIUS = 3.5  # of the plate, in projectile diameters: fixed or free edges change the hole by less than 1 % (MPM3D-F90)


@dataclass(frozen=True, kw_only=True)
class PlatePerforation(Impact):
    """Parameters of an impact on a plate."""

    plate_thickness: Annotated[Metre, Described("thickness of the plate", 1e-6, 1.0)]
    plate_radius: Annotated[
        Metre | None,
        Described("radius of a round plate, half the width of a square one; by default 3.5 diameters", 1e-5, 10.0),
    ] = None


def plate_radius(parameters: PlatePerforation) -> float:
    """Radius of the plate, m."""
    return parameters.plate_radius or RADIUS * parameters.projectile_diameter


def check_plate(parameters: PlatePerforation) -> list[Finding]:
    """The plate is wider than the projectile, and no thinner than half a cell."""
    findings = []
    radius, diameter = plate_radius(parameters), parameters.projectile_diameter
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


def cells(parameters: PlatePerforation) -> dict[str, float]:
    """Cells across the projectile and through the plate."""
    return {
        "cells_per_diameter": parameters.cells_per_diameter,
        "cells_per_thickness": parameters.plate_thickness / spacing(parameters),
    }
