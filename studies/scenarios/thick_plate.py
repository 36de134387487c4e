"""A projectile craters a thick block: Ma (2005), section 3.2."""

from dataclasses import dataclass
from functools import partial
from typing import Annotated, ClassVar

from solver.units import Described, Metre
from studies.scenarios import Materials, Scenario, Setting, Size
from studies.scenarios._impact import assemble, check_shot, outline, size, spacing
from studies.scenarios._impact_observer import IMPACT
from studies.scenarios._oblique import Oblique, check_oblique
from studies.scenarios._settling import SettlingImpact, check_window, filled_settling
from studies.values.errors import Finding

# Semi-infinite means three crater depths (attached spall below t = 3 p: Gehring, in Cour-Palais 1987); a copper crater
# at 7 km/s is 3.5 diameters deep and three wide on each side. A fixed rim and a free back make a crater at 6 km/s 2 %
# deeper here than in a block half as large again, absorbing edges less than 1 % (verification case absorbing-block).
DEPTH, RADIUS = 11.0, 10.0  # of the block, in projectile diameters

# Nearer than this absorbing edges are refused: metal yields there, and the crater is 7 % shallower (the same case).
LEAST_ABSORBING = 5.0  # projectile diameters

# A cavity of radius R in a solid of strength Y stops within about R sqrt(rho / Y): its wall moves at sqrt(Y / rho) when
# what is left of the kinetic energy is what strength can still take up, and strength slows it by Y / (rho R). R of
# three diameters (above) in copper of 350 MPa, 8930 kg/m3: 15 ms per metre of diameter. Ma (2005), section 3.2, ran
# 45 us at 4.75 to 5.3 mm, 8.5 to 9.5 ms/m.
CAP_PER_DIAMETER = 15e-3  # s/m


@dataclass(frozen=True, kw_only=True)
class ThickPlate(Oblique, SettlingImpact):
    """Parameters of a crater."""

    cap_per_diameter: ClassVar[float] = CAP_PER_DIAMETER

    target_depth: Annotated[Metre | None, Described("thickness of the block; by default 11 diameters", 1e-5, 10.0)] = (
        None
    )
    target_radius: Annotated[
        Metre | None,
        Described("radius of a round block, half the width of a square one; by default 10 diameters", 1e-5, 10.0),
    ] = None


def _depth(parameters: ThickPlate) -> float:
    return parameters.target_depth or DEPTH * parameters.projectile_diameter


def _radius(parameters: ThickPlate) -> float:
    return parameters.target_radius or RADIUS * parameters.projectile_diameter


def _fill(parameters: ThickPlate) -> ThickPlate:
    return filled_settling(parameters, target_depth=_depth(parameters), target_radius=_radius(parameters))


def _check(parameters: ThickPlate, materials: Materials) -> list[Finding]:
    findings = [*check_shot(parameters, materials), *check_window(parameters), *check_oblique(parameters)]
    least, cure = 1.0, "enlarge the block, or use thin_plate"
    if parameters.edges == "absorbing":
        least, cure = LEAST_ABSORBING, "enlarge the block, or choose other edges"
    for name, value in (("target_depth", _depth(parameters)), ("target_radius", _radius(parameters))):
        if value < least * parameters.projectile_diameter:
            limit = f"at least {least:g} of the projectile's diameter, {least * parameters.projectile_diameter:g} m"
            findings.append(Finding(name, f"{value:g} m", limit, cure))
    return findings


def _build(parameters: ThickPlate, materials: Materials) -> Setting:
    return assemble(parameters, materials, thickness=_depth(parameters), radius=_radius(parameters), deep=True)


def _size(parameters: ThickPlate, materials: Materials) -> Size:
    return size(parameters, thickness=_depth(parameters), radius=_radius(parameters))


def _cells(parameters: ThickPlate) -> dict[str, float]:
    return {
        "cells_per_diameter": parameters.cells_per_diameter,
        "cells_per_thickness": _depth(parameters) / spacing(parameters),
    }


SCENARIO = Scenario(
    name="thick_plate",
    title="Crater in a thick block",
    description="A sphere or cylinder hits a block, at right angles or obliquely; the crater is measured.",
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
    fill=_fill,
    check=_check,
    build=_build,
    estimate=_size,
    cells=_cells,
    observer=IMPACT,
    outline=partial(outline, thickness="target_depth", radius="target_radius"),
)
