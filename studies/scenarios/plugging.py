"""A hard projectile cuts a plug out of a clamped plate: Borvik et al. (1999), Int. J. Impact Eng. 22, 855.

The front face of the plate is z = 0, its body stands at z > 0, and the projectile flies along +z with its tip a gap
away from the plate at time zero. The clamp is the outer edge of the grid. Projectile and plate are solids of
revolution; what fills them with particles knows nothing else of them.
"""

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Annotated, Any, Literal

from solver.units import Described, Dimensionless, Metre, MetrePerSecond, Second
from studies.scenarios import (
    Dimension,
    ImpactSetting,
    Materials,
    ObservationRate,
    ObserverOptions,
    Outline,
    Scenario,
    Setting,
    Shape,
    Size,
)
from studies.scenarios._coupled_plate import EVEN, coupled_plate, plate_size
from studies.scenarios._lattice import SECTORS, BodyShape, body, line, mesh, points
from studies.scenarios._matter import (
    Fracture,
    check_boiling,
    check_constants,
    check_eos,
    check_failure,
    failure_of,
    failures,
    matter,
)
from studies.scenarios._method import REPULSION, ByCoupledMethod, check_method, is_coupled, is_on_grid, is_smoothed
from studies.scenarios._numerics import (
    ContactName,
    Numerics,
    check_numerics,
    filled_from,
    filled_numerics,
    has_melting,
    mean_step,
    numerics,
    particles_per_cell,
    recipe_of,
    shapes,
)
from studies.values.errors import Finding
from studies.values.parameters import Choice, MaterialName
from studies.values.quantities import round_quantity
from studies.values.recipes import RECIPES

if TYPE_CHECKING:
    from solver.problem import Body
    from studies.films.section import SectionOptions
    from studies.materials import Material

RADIUS = 12.5  # of the plate, in projectile diameters: 500 mm for 20 mm, Borvik et al. (1999), as recalled
CONE = 1.0  # default length of a conical nose, in projectile diameters

# The projectile of the seed has cut its plug when it would have flown 2.7 thicknesses (120 us at 285.4 m/s); slower
# ones need longer.
FLIGHT = 5.0  # thicknesses of the plate that the projectile would fly behind the first touch
FASTEST = 1.25  # speed of the plug over that of the projectile before the impact, at most: room behind the plate
AROUND = 2.0  # cells of grid around what moves
# Half width of the particles in a coupled plate, in projectile diameters: the 47 133 particles of Zhang, Qiang and Gao
# (2011) are 80 layers of 316 in the projectile, and 13 layers of 41 by 41 in the plate, 1 mm apart.
SQUARE = 1.0
# Cells of flight between two observations, in which the first contact is read, and observations of a run at most.
OBSERVED, MOST_OBSERVED = 0.25, 2000
MOMENTS = (1.0 / 3.0, 2.0 / 3.0)  # of the run: sections before the end
REACH = 2.5  # of the sections, in projectile diameters


@dataclass(frozen=True, kw_only=True)
class PluggingShot:
    """Projectile, plate and speed, and how long they are observed."""

    speed: Annotated[MetrePerSecond, Described("impact speed, normal to the plate", 1.0, 2000.0)]
    projectile_diameter: Annotated[Metre, Described("diameter of the projectile", 1e-4, 1.0)] = 20e-3
    projectile_length: Annotated[Metre, Described("length of the projectile, its nose included", 1e-4, 1.0)] = 80e-3
    nose: Annotated[Literal["blunt", "conical", "hemispherical"], Described("nose of the projectile")] = "blunt"
    nose_length: Annotated[
        Metre | None, Described("length of a conical nose, a diameter by default; other noses have none", 1e-5, 1.0)
    ] = None
    plate_thickness: Annotated[Metre, Described("thickness of the plate", 1e-5, 1.0)] = 12e-3
    plate_radius: Annotated[
        Metre | None,
        Described(
            "radius of a round plate, half the width of a square one; by default 12.5 diameters of the projectile",
            1e-4,
            10.0,
        ),
    ] = None
    gap: Annotated[Metre, Described("distance of the tip from the plate at the start", 0.0, 1.0)] = 2e-3
    projectile: Annotated[MaterialName, Described("material of the projectile")] = "arne-elastic"
    target: Annotated[MaterialName, Described("material of the plate")] = "weldox-460-e"
    geometry: Annotated[
        Literal["axisymmetric", "quarter"],
        Described("body of revolution, or a quarter of a square plate in three dimensions"),
    ] = "axisymmetric"
    cells_per_diameter: Annotated[
        Dimensionless, Described("grid cells across the projectile's diameter", 4.0, 512.0)
    ] = 40.0
    end_time: Annotated[
        Second | None,
        Described(
            "end of the run; by default when the projectile would have flown the gap and five thicknesses of the plate",
            1e-9,
            1.0,
        ),
    ] = None
    thermal_softening: Annotated[
        bool, Described("whether temperature softens and melting takes all strength", acts=has_melting)
    ] = True
    offset: Annotated[
        Dimensionless,
        Described(
            "shift of the grid against the bodies along the line of flight, in cells: it changes the mesh error alone",
            0.0,
            1.0,
        ),
    ] = 0.0


@dataclass(frozen=True, kw_only=True)
class Plugging(ByCoupledMethod, Numerics, Fracture, PluggingShot):
    """Parameters of the plugging of a plate."""

    # Splines feel the other body two cells early: docs/recipe.md.
    shape: Annotated[str, Choice(shapes), Described("shape functions", acts=is_on_grid)] = "gimp"
    particles_per_cell: Annotated[
        int | None, Described("particles per cell along each direction; by default 2, 1 of smoothed ones", 1, 6)
    ] = None
    contact: Annotated[
        Literal[ContactName, "repulsion"] | None,
        Described(
            "bodies share one velocity field, or have separate fields with contact on the nodes: where their "
            "surfaces meet (gap), where they approach (bardenhagen), by the criterion printed in the thesis (thesis); "
            "smoothed particles of different bodies repel each other (repulsion), or meet in their sums (none); by "
            "default gap, and repulsion of smoothed particles"
        ),
    ] = None  # type: ignore[assignment]  # which follows from the method
    failure: Annotated[str, Choice(failures), Described("failure model of what has constants for it")] = (
        "modified-johnson-cook"
    )


@dataclass(frozen=True)
class PluggingSetting(ImpactSetting):
    """The plugging of a plate as its observer needs to know it."""

    gap: float  # m


def solids(parameters: Plugging) -> tuple[BodyShape, BodyShape]:
    """Projectile and plate."""
    radius = 0.5 * parameters.projectile_diameter
    projectile = BodyShape(
        role="projectile",
        begin=-parameters.gap - parameters.projectile_length,
        end=-parameters.gap,
        breadth=radius,
        is_round=True,
        nose=parameters.nose,
        nose_length=_nose_length(parameters),
        speed=parameters.speed,
    )
    plate = BodyShape(
        role="target",
        begin=0.0,
        end=parameters.plate_thickness,
        breadth=_plate_radius(parameters),
        is_round=parameters.geometry == "axisymmetric",
        nose="blunt",
        nose_length=0.0,
        speed=0.0,
    )
    return projectile, plate


def _nose_length(parameters: Plugging) -> float:
    if parameters.nose == "conical":
        return parameters.nose_length or CONE * parameters.projectile_diameter
    return 0.5 * parameters.projectile_diameter if parameters.nose == "hemispherical" else 0.0


def _plate_radius(parameters: Plugging) -> float:
    return parameters.plate_radius or RADIUS * parameters.projectile_diameter


def _cell(parameters: Plugging) -> float:
    return parameters.projectile_diameter / parameters.cells_per_diameter


def _end_time(parameters: Plugging) -> float:
    flight = parameters.gap + FLIGHT * parameters.plate_thickness
    return parameters.end_time or flight / parameters.speed


def _with_method(parameters: Plugging) -> Plugging:
    """The parameters with the particles, the contact and the viscosity of their method.

    Monaghan's linear viscosity of 1 resists shear as matter with a viscosity of rho c h / 10 does: at 1 mm by 120 MPa
    at the 2.5e4 1/s of a band of four spacings, a quarter of what the plate can bear. Particles have that of a grid.
    """
    smoothed = is_smoothed(parameters)
    made = replace(
        parameters,
        particles_per_cell=parameters.particles_per_cell or (1 if smoothed else 2),
        contact=parameters.contact or ("repulsion" if smoothed else "gap"),
    )
    return filled_from(made, RECIPES[parameters.recipe]) if smoothed else made


def _fill(parameters: Plugging) -> Plugging:
    return replace(
        filled_numerics(_with_method(parameters)),
        plate_radius=round_quantity(_plate_radius(parameters)),
        end_time=round_quantity(_end_time(parameters)),
        nose_length=round_quantity(_nose_length(parameters))
        if parameters.nose == "conical"
        else parameters.nose_length,
    )


def _check(parameters: Plugging, materials: Materials) -> list[Finding]:
    return [
        *check_method(parameters, ("repulsion", "none")),
        *_check_shape(parameters),
        *check_numerics(parameters),
        *check_failure(parameters, materials),
        *check_eos("hugoniot", materials),
        *check_constants(materials),
        *check_boiling(parameters, materials),
    ]


def _check_shape(parameters: Plugging) -> list[Finding]:
    """A nose fits on its projectile, and the plate is wider than that and no thinner than two cells."""
    findings = []
    length, diameter = parameters.projectile_length, parameters.projectile_diameter
    if parameters.nose != "conical" and parameters.nose_length is not None:
        value, limit = f"{parameters.nose_length:g} m", f"no length of a {parameters.nose} nose"
        findings.append(Finding("nose_length", value, limit, "leave it out"))
    if length < _nose_length(parameters):
        limit = f"at least the length of the nose, {_nose_length(parameters):g} m"
        findings.append(Finding("projectile_length", f"{length:g} m", limit, "lengthen the projectile"))
    radius = _plate_radius(parameters)
    narrowest, limit = diameter, f"at least the projectile's diameter, {diameter:g} m"
    if is_coupled(parameters):
        narrowest = SQUARE * diameter + (EVEN + 1) * _square(parameters)["step"]
        limit = f"at least {narrowest:g} m, the particles and {EVEN + 1} elements"
    if radius < narrowest:
        findings.append(Finding("plate_radius", f"{radius:g} m", limit, "enlarge the plate"))
    if parameters.contact == "repulsion" and not is_smoothed(parameters):
        limit = "none, bardenhagen, thesis or gap, the contacts of material points"
        findings.append(Finding("contact", "repulsion", limit, "take another contact"))
    reach = REPULSION * _cell(parameters) / particles_per_cell(parameters)
    if parameters.contact == "repulsion" and parameters.gap < reach * (1.0 - 1e-9):
        limit = f"at least {reach:g} m, {REPULSION:g} spacings of particles that repel each other"
        cure = "enlarge the gap, raise the resolution (cells per diameter), or set contact to none"
        findings.append(Finding("gap", f"{parameters.gap:g} m", limit, cure))
    thickness, least = parameters.plate_thickness, 2.0 * _cell(parameters)
    if thickness < least:
        cure = "raise the resolution (cells per diameter)"
        findings.append(Finding("plate_thickness", f"{thickness:g} m", f"at least two cells, {least:g} m", cure))
    return findings


def _build(parameters: Plugging, materials: Materials) -> Setting:
    from solver.problem import Problem

    geometry, faces = _grid(parameters)
    projectile, plate = solids(parameters)
    flying = _filled(projectile, parameters, materials[projectile.role], geometry)
    target = materials[plate.role]
    if is_coupled(parameters):
        elements, particles = coupled_plate(
            plate.role,
            _matter(parameters, target),
            density=target.density,
            begin=plate.begin,
            end=plate.end,
            **_square(parameters),
        )
        bodies: tuple[Body, ...] = (elements, flying, particles)
    else:
        bodies = (flying, _filled(plate, parameters, target, geometry))
    return PluggingSetting(
        problem=Problem(
            geometry=geometry,
            bodies=bodies,
            faces=faces,
            clamp=_clamp(parameters),
            end_time=_end_time(parameters),
            **_numerics(parameters),
        ),
        sector=SECTORS[parameters.geometry],
        target="target",
        projectile_diameter=parameters.projectile_diameter,
        thickness=parameters.plate_thickness,
        radius=_plate_radius(parameters),
        speed=parameters.speed,
        gap=parameters.gap,
    )


def _numerics(parameters: Plugging) -> dict[str, Any]:
    """The numerics of the problem; elements beside particles have the viscosity of the recipe, that of a grid."""
    from solver.problem import ArtificialViscosity

    recipe = RECIPES[parameters.recipe]
    viscosity = ArtificialViscosity(recipe.viscosity_linear, recipe.viscosity_quadratic)
    return numerics(parameters) | ({"viscosity": viscosity} if is_coupled(parameters) else {})


def _square(parameters: Plugging) -> dict[str, float]:
    """Half widths of the particles of a coupled plate and of the plate, and their spacing, m."""
    return {
        "square": SQUARE * parameters.projectile_diameter,
        "width": _plate_radius(parameters),
        "step": _cell(parameters) / particles_per_cell(parameters),
    }


def _grid(parameters: Plugging) -> tuple[Any, tuple[Any, ...]]:
    from solver.problem import Face

    cell, (projectile, plate) = _cell(parameters), solids(parameters)
    before = math.ceil(-projectile.begin / cell + AROUND)
    flown = FASTEST * parameters.speed * _end_time(parameters) - parameters.gap
    behind = math.ceil((plate.end + max(flown, plate.end)) / cell + AROUND)
    return mesh(
        parameters.geometry,
        across=math.ceil(plate.breadth / cell - 1e-9),
        along=before + behind,
        front=-(before + parameters.offset) * cell,
        cell=cell,
        side=(Face.SYMMETRIC, Face.FIXED),
        flight=(Face.FREE, Face.FREE),
    )


def _clamp(parameters: Plugging) -> Any:
    """The rim of the plate, and the cell on either side that its particles reach."""
    import numpy as np

    from solver.problem import clamp

    reach = (1.0 + 1e-6) * _cell(parameters)
    lower, upper = np.full(3, -np.inf), np.full(3, np.inf)
    axis = 1 if parameters.geometry == "axisymmetric" else 2
    lower[axis], upper[axis] = -reach, parameters.plate_thickness + reach
    return clamp(lower=lower, upper=upper)


def _filled(solid: BodyShape, parameters: Plugging, material: "Material", geometry: Any) -> "Body":
    """A solid filled with the particles of the material point method."""
    import numpy as np

    step = _cell(parameters) / particles_per_cell(parameters)
    across, wide = line(0.0, solid.breadth, step)
    along, high = line(solid.begin, solid.end, step)
    flat = parameters.geometry == "axisymmetric"
    position = points(across, along, np.zeros(1)) if flat else points(across, across, along)
    axis = 1 if flat else 2
    if solid.is_round:
        radius = np.sqrt((position[:, :axis] ** 2).sum(axis=1))
        position = position[radius < solid.radius(position[:, axis])]
    velocity = np.zeros(3)
    velocity[axis] = solid.speed
    part = 1.0 if flat else SECTORS[parameters.geometry]
    return body(
        solid.role,
        _matter(parameters, material),
        geometry,
        position=position,
        spacing=(wide, high, 0.0) if flat else (wide, wide, high),
        velocity=velocity,
        density=material.density,
        volume=solid.volume * part / (2.0 * math.pi),
    )


def _matter(parameters: Plugging, material: "Material") -> Any:
    return matter(
        material,
        thermal_softening=parameters.thermal_softening,
        tension=recipe_of(parameters).tension,
        failure=failure_of(parameters, material),
    )


def _size(parameters: Plugging, materials: Materials) -> Size:
    parameters = _fill(parameters)
    lattice = _cell(parameters) / particles_per_cell(parameters)
    if parameters.geometry == "axisymmetric":
        areas = (solid.breadth * (solid.end - solid.begin) for solid in solids(parameters))
        particles = sum(areas) / lattice**2
    elif is_coupled(parameters):
        particles = solids(parameters)[0].volume / 4.0 / lattice**3
        particles += plate_size(thickness=parameters.plate_thickness, **_square(parameters))
    else:
        particles = sum(solid.volume for solid in solids(parameters)) / 4.0 / lattice**3
    sound = max(_elastic(material) for material in materials.values())
    step = mean_step(parameters, _cell(parameters), sound=sound, speed=parameters.speed)
    return Size(particles=round(particles), steps=math.ceil(_end_time(parameters) / step))


def _elastic(material: "Material") -> float:
    """Speed of longitudinal waves, m/s."""
    stiffness = material.elastic.bulk_modulus + 4.0 / 3.0 * material.elastic.shear_modulus
    return math.sqrt(stiffness / material.density)


def _cells(parameters: Plugging) -> dict[str, float]:
    return {
        "cells_per_diameter": parameters.cells_per_diameter,
        "cells_per_thickness": parameters.plate_thickness / _cell(parameters),
    }


def _rate(parameters: Any, setting: Setting) -> ObservationRate:
    interval = OBSERVED * _cell(parameters) / parameters.speed
    return ObservationRate(interval=max(interval, setting.problem.end_time / MOST_OBSERVED))


def _view(setting: Any, snapshot: Any) -> Any:
    from studies.measurements._plug import view

    return view(setting, snapshot)


def _sections(parameters: Plugging, setting: Any) -> "SectionOptions":
    from studies.films.section import SectionOptions

    moments = tuple(moment * setting.problem.end_time for moment in MOMENTS)
    return SectionOptions(moments=moments, reach=REACH * parameters.projectile_diameter)


def _outline(values: Mapping[str, Any]) -> Outline | None:
    """Projectile and plate at the start; the nose is drawn blunt."""
    diameter, length = values.get("projectile_diameter"), values.get("projectile_length")
    thickness, rim = values.get("plate_thickness"), values.get("plate_radius")
    if not diameter or not length or not thickness or not rim:
        return None
    half, gap = 0.5 * diameter, values.get("gap") or 0.0
    projectile = Shape("projectile", -half, half, -length - gap, -gap, heading=(0.0, 1.0))
    return Outline(
        (projectile, Shape("target", -rim, rim, 0.0, thickness)),
        (
            Dimension("projectile_diameter", (-half, -length - gap), (half, -length - gap)),
            Dimension("projectile_length", (half, -length - gap), (half, -gap)),
            Dimension("plate_thickness", (rim, 0.0), (rim, thickness)),
            Dimension("plate_radius", (0.0, thickness), (rim, thickness)),
        ),
    )


SCENARIO = Scenario(
    name="plugging",
    title="Plugging of a plate",
    description="A hard projectile with a blunt, conical or hemispherical nose hits a clamped plate at right angles; "
    "the projectile, the plug and the hole are measured.",
    parameters=Plugging,
    materials=("projectile", "target"),
    measurements=(
        "perforated",
        "projectile_velocity",
        "residual_velocity",
        "plug_velocity",
        "plug_mass",
        "hole_diameter_front",
        "hole_diameter_rear",
        "dishing",
        "first_contact",
        "plug_separation",
    ),
    settles=(),
    fill=_fill,
    check=_check,
    build=_build,
    estimate=_size,
    cells=_cells,
    observer=ObserverOptions(
        rate=_rate,
        view=_view,
        sections=_sections,
        least_cells={"cells_per_thickness": 8.0},
        fewest_cells={"cells_per_thickness": 4.0},
    ),
    outline=_outline,
)
