"""Common part of the impact scenarios: parameters, matter, lattices, faces and the size of the work.

The original surface of the target is z = 0, its body stands at z > 0, and the projectile flies towards +z and touches
it at time zero. Lattices have the recipe's particles per cell and direction, stretched by a few per cent where needed
so that lengths are exact; the masses of a body are scaled to the analytic mass, from which a lattice sphere differs by
2 to 4 %.
"""

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Annotated, Any, ClassVar, Literal, TypeVar

from solver.units import Described, Dimensionless, Metre, MetrePerSecond, Second
from studies.scenarios import Dimension, ImpactSetting, Materials, Outline, Setting, Shape, Size
from studies.scenarios._lattice import SECTORS, body, line, mesh, points
from studies.scenarios._matter import (
    Fracture,
    check_boiling,
    check_constants,
    check_eos,
    check_failure,
    eos_forms,
    failure_of,
    matter,
)
from studies.scenarios._method import is_smoothed
from studies.scenarios._numerics import (
    BY_RECIPE,
    Numerics,
    check_numerics,
    filled_from,
    filled_numerics,
    has_melting,
    mean_step,
    numerics,
    particles_per_cell,
    recipe_of,
)
from studies.values.errors import Finding
from studies.values.parameters import Choice, MaterialName
from studies.values.quantities import round_quantity
from studies.values.recipes import IMPACT_RECIPES, DebrisName

if TYPE_CHECKING:
    import numpy as np

    from solver.problem import Absorber, Body, Clamp, Face, Matter, Retirement
    from studies.materials import Material

SOUND_SPEED = 5000.0  # m/s, in the estimate of the number of steps

# Debris may be retired from here on, in times in which the projectile flies its own length. Matter moves at half of the
# impact speed or more while it is thrown out of a plate no thicker than the projectile, which takes four of them.
CLEAR = 5.0

# The cap scales with the diameter, as everything does in a rate-independent material. 60 us at 8 mm: prototypes of
# copper plates crept for 30 us and longer on coarse grids.
CAP_PER_DIAMETER = 60e-6 / 8e-3  # s/m; a block needs longer


def has_free_rim(parameters: Any) -> bool:
    """Whether the grid goes on outside the target's rim."""
    return bool(parameters.edges != "fixed")


@dataclass(frozen=True, kw_only=True)
class ImpactShot:
    """Projectile, target and speed, and how long the impact is observed."""

    cap_per_diameter: ClassVar[float] = CAP_PER_DIAMETER  # latest end of a run, s/m

    speed: Annotated[MetrePerSecond, Described("impact speed, normal to the target", 100.0, 2e4)]
    projectile_diameter: Annotated[Metre, Described("diameter of the projectile", 1e-5, 1.0)]
    projectile: Annotated[MaterialName, Described("material of the projectile")]
    target: Annotated[MaterialName, Described("material of the target")]
    projectile_shape: Annotated[
        Literal["sphere", "cylinder"],
        Described("shape of the projectile; a cylinder flies along its axis unless it yaws"),
    ] = "sphere"
    projectile_length: Annotated[Metre | None, Described("length of a cylinder; omitted for a sphere", 1e-5, 1.0)] = (
        None
    )
    geometry: Annotated[
        Literal["axisymmetric", "quarter", "half"],
        Described("body of revolution, or a quarter or half of a square target in three dimensions"),
    ] = "axisymmetric"
    cells_per_diameter: Annotated[
        Dimensionless, Described("grid cells across the projectile's diameter", 2.0, 512.0)
    ] = 32.0
    edges: Annotated[
        Literal["fixed", "free", "absorbing"],
        Described(
            "what holds the target's rim (absorbing: waves leave there, and through the back of a block); debris that "
            "flies past it leaves the grid"
        ),
    ] = "fixed"
    end_time: Annotated[
        Second | None,
        Described(
            "latest end of the run; by default 7.5 ms per metre of diameter (60 us at 8 mm), 15 for a thick block",
            1e-9,
            1.0,
        ),
    ] = None
    eos_form: Annotated[
        str,
        Choice(eos_forms),
        Described(
            "Mie-Grueneisen about the exact Hugoniot, the thesis' cubic truncation of it, or linear elasticity without "
            "an equation of state, by the stated bulk modulus; other equations of state have the first or the last"
        ),
    ] = "hugoniot"
    thermal_softening: Annotated[
        bool, Described("whether temperature softens and melting takes all strength", acts=has_melting)
    ] = True
    debris: Annotated[
        DebrisName | None,
        Described(
            "debris that is free of the target and on a clear way out of the grid is followed to the edge, or retired: "
            f"it leaves a record and flies straight from there; {BY_RECIPE}"
        ),
    ] = None
    uprange: Annotated[
        Dimensionless | None, Described(f"grid in front of the target, in projectile diameters; {BY_RECIPE}", 0.5, 50.0)
    ] = None
    downrange: Annotated[
        Dimensionless | None, Described(f"grid behind the target, in projectile diameters; {BY_RECIPE}", 0.5, 50.0)
    ] = None
    beyond_edge: Annotated[
        Dimensionless,
        Described("grid outside a rim that is not fixed, in projectile diameters", 0.1, 50.0, acts=has_free_rim),
    ] = 0.5
    offset: Annotated[
        Dimensionless,
        Described(
            "shift of the grid against the bodies along the line of flight, in cells: it changes the mesh error alone",
            0.0,
            1.0,
        ),
    ] = 0.0


@dataclass(frozen=True, kw_only=True)
class Impact(Numerics, Fracture, ImpactShot):
    """Parameters of every normal impact: the shot, what breaks, and then its numerics."""


Parameters = TypeVar("Parameters", bound=Impact)


def filled(parameters: Parameters, **derived: float) -> Parameters:
    """The parameters with every default that follows from others, at 12 significant digits."""
    derived = {"end_time": end_time(parameters), **derived}
    changes: dict[str, Any] = {name: round_quantity(value) for name, value in derived.items()}
    return replace(filled_choices(parameters), **changes)


def filled_choices(parameters: Parameters) -> Parameters:
    """The parameters with all that their recipe chooses."""
    preset = IMPACT_RECIPES[parameters.recipe]
    if is_smoothed(parameters):  # which does not retire any
        preset = replace(preset, debris="follow")
    return filled_from(filled_numerics(parameters), preset)


def outline(values: Mapping[str, Any], *, thickness: str, radius: str) -> Outline | None:
    """Projectile and target as they touch; ``thickness`` and ``radius`` are the target's parameters."""
    diameter, depth, rim = (values.get(name) for name in ("projectile_diameter", thickness, radius))
    if not diameter or not depth or not rim:
        return None
    length, angle = values.get("projectile_length") or diameter, values.get("obliquity") or 0.0
    is_sphere = values.get("projectile_shape", "sphere") == "sphere"
    half = 0.5 * diameter
    projectile = Shape(
        "projectile", -half, half, -length, 0.0, is_disc=is_sphere, heading=(math.sin(angle), math.cos(angle))
    )
    dimensions = [
        Dimension("projectile_diameter", (-half, -length), (half, -length)),
        Dimension(thickness, (rim, 0.0), (rim, depth)),
        Dimension(radius, (0.0, depth), (rim, depth)),
    ]
    if not is_sphere:
        dimensions.append(Dimension("projectile_length", (half, -length), (half, 0.0)))
    return Outline((projectile, Shape("target", -rim, rim, 0.0, depth)), tuple(dimensions))


def spacing(parameters: Impact) -> float:
    """Size of a cell, m."""
    return parameters.projectile_diameter / parameters.cells_per_diameter


def end_time(parameters: Impact) -> float:
    """Latest end of a run, s."""
    return parameters.end_time or parameters.cap_per_diameter * parameters.projectile_diameter


def check_shot(parameters: Impact, materials: Materials) -> list[Finding]:
    """Findings that any impact may have."""
    return [
        *_check_projectile(parameters),
        *check_numerics(parameters),
        *check_failure(parameters, materials),
        *check_eos(parameters.eos_form, materials),
        *check_constants(materials),
        *check_boiling(parameters, materials),
    ]


def _check_projectile(parameters: Impact) -> list[Finding]:
    """A cylinder has a length and a sphere has none."""
    name, length = "projectile_length", parameters.projectile_length
    if parameters.projectile_shape == "cylinder" and length is None:
        return [Finding(name, "nothing", "the length of the cylinder", f"give {name}")]
    if parameters.projectile_shape == "sphere" and length is not None:
        cure = f"leave {name} out, or set projectile_shape to cylinder"
        return [Finding(name, f"{length:g} m", "a sphere without a length", cure)]
    return []


def size(parameters: Impact, *, thickness: float, radius: float) -> Size:
    """Particles from volumes, and steps from the stable step of the undisturbed state."""
    parameters = filled_numerics(parameters)
    lattice = spacing(parameters) / particles_per_cell(parameters)
    length = parameters.projectile_length or 2.0 / 3.0 * parameters.projectile_diameter
    round_area = math.pi / 4.0 * parameters.projectile_diameter**2
    if parameters.geometry == "axisymmetric":
        half_plane = math.pi / 8.0 * parameters.projectile_diameter**2  # of a sphere
        if parameters.projectile_length:
            half_plane = 0.5 * parameters.projectile_diameter * parameters.projectile_length
        particles = (radius * thickness + half_plane) / lattice**2
    else:
        parts = 4 if parameters.geometry == "quarter" else 2
        particles = ((2.0 * radius) ** 2 * thickness + round_area * length) / parts / lattice**3
    # Half of the impact speed on top of 5 km/s of sound: the mean over runs of copper at 2 to 7 km/s.
    step = mean_step(parameters, spacing(parameters), sound=SOUND_SPEED, speed=0.5 * parameters.speed)
    return Size(particles=round(particles), steps=round(end_time(parameters) / step))


def assemble(
    parameters: Impact, materials: Materials, *, thickness: float, radius: float, deep: bool = False
) -> Setting:
    """The problem of a projectile in front of a plate or block; an oblique one also flies towards +x.

    A ``deep`` target stands for a half-space: where edges absorb, its back does too.
    """
    import numpy as np

    from solver.problem import Problem

    parameters = filled_choices(parameters)
    geometry, faces = _grid(parameters, thickness, radius)
    axis = _flight_axis(parameters)
    velocity, obliquity = np.zeros(3), getattr(parameters, "obliquity", 0.0)
    velocity[axis] = parameters.speed * math.cos(obliquity)
    velocity[0] = parameters.speed * math.sin(obliquity)
    lattice = np.full(3, spacing(parameters) / particles_per_cell(parameters))
    bodies = (
        _body("projectile", parameters, materials["projectile"], geometry, _projectile(parameters, lattice), velocity),
        _body(
            "target",
            parameters,
            materials["target"],
            geometry,
            _target(parameters, lattice, thickness, radius),
            np.zeros(3),
        ),
    )
    problem = Problem(
        geometry=geometry,
        bodies=bodies,
        faces=faces,
        clamp=_clamp(parameters, thickness),
        absorbers=_absorbers(parameters, bodies[1].matter, thickness, radius, deep=deep),
        end_time=end_time(parameters),
        retirement=_retirement(parameters),
        **numerics(parameters),
    )
    return ImpactSetting(
        problem=problem,
        target="target",
        projectile_diameter=parameters.projectile_diameter,
        thickness=thickness,
        radius=radius,
        sector=SECTORS[parameters.geometry],
        speed=parameters.speed,
    )


@dataclass(frozen=True)
class _Lattice:
    """Points of a body before they have mass."""

    position: "np.ndarray"  # (n, 3) m
    spacing: tuple[float, float, float]  # m
    volume: float  # analytic volume of the modelled part, m3 (m3 per radian in axisymmetry)


def _retirement(parameters: Impact) -> "Retirement | None":
    from solver.problem import Retirement

    if parameters.debris == "follow":
        return None
    longest = max(parameters.projectile_diameter, _length(parameters))
    return Retirement(body=1, after=CLEAR * longest / parameters.speed)


def _flight_axis(parameters: Impact) -> int:
    return 1 if parameters.geometry == "axisymmetric" else 2


def _grid(parameters: Impact, thickness: float, radius: float) -> tuple[Any, tuple[tuple["Face", "Face"], ...]]:
    from solver.problem import Face

    assert parameters.uprange is not None
    assert parameters.downrange is not None
    cell = spacing(parameters)
    beyond = 0.0 if parameters.edges == "fixed" else parameters.beyond_edge * parameters.projectile_diameter
    across = math.ceil((radius + beyond) / cell - 1e-9)
    before = math.ceil(parameters.uprange * parameters.projectile_diameter / cell)
    before = max(before, math.ceil((_height(parameters) + 2.0 * cell) / cell))
    behind = math.ceil((thickness + parameters.downrange * parameters.projectile_diameter) / cell)
    return mesh(
        parameters.geometry,
        across=across,
        along=before + behind,
        front=-(before + parameters.offset) * cell,
        cell=cell,
        side=(Face.SYMMETRIC, Face.FIXED if parameters.edges == "fixed" else Face.FREE),
        flight=(Face.FREE, Face.FREE),
    )


def _clamp(parameters: Impact, thickness: float) -> "Clamp":
    """The rim of the target, and the cell on either side that its particles reach; debris beyond it flies on."""
    import numpy as np

    from solver.problem import clamp

    # Nodes a cell away belong to it whatever the round-off.
    reach = (1.0 + 1e-6) * spacing(parameters)
    lower, upper = np.full(3, -np.inf), np.full(3, np.inf)
    axis = _flight_axis(parameters)
    lower[axis], upper[axis] = -reach, thickness + reach
    return clamp(lower=lower, upper=upper)


def _absorbers(
    parameters: Impact, target: "Matter", thickness: float, radius: float, *, deep: bool
) -> "tuple[Absorber, ...]":
    """The rim of the target where edges absorb, and the back of a deep one."""
    from solver.absorb import absorber

    if parameters.edges != "absorbing":
        return ()
    rims = {"axisymmetric": [(0, 1)], "quarter": [(0, 1), (1, 1)], "half": [(0, 0), (0, 1), (1, 1)]}[
        parameters.geometry
    ]
    surfaces = [(axis, side, radius if side else -radius) for axis, side in rims]
    if deep:
        surfaces.append((_flight_axis(parameters), 1, thickness))
    return tuple(absorber(target, body=1, axis=axis, side=side, place=place) for axis, side, place in surfaces)


def _length(parameters: Impact) -> float:
    return parameters.projectile_length or parameters.projectile_diameter


def _lean(parameters: Impact) -> float:
    """Angle between the axis of a cylinder and the target's normal, rad; 0 for a sphere."""
    if parameters.projectile_shape == "sphere":
        return 0.0
    return float(getattr(parameters, "obliquity", 0.0) + getattr(parameters, "yaw", 0.0))


def _height(parameters: Impact) -> float:
    """Extent of the projectile along the target's normal, m."""
    lean = _lean(parameters)
    across = parameters.projectile_diameter * abs(math.sin(lean))
    return _length(parameters) * abs(math.cos(lean)) + across if lean else _length(parameters)


def _target(parameters: Impact, lattice: "np.ndarray", thickness: float, radius: float) -> _Lattice:
    import numpy as np

    across, step = line(0.0, radius, float(lattice[0]))
    along, layer = line(0.0, thickness, float(lattice[0]))
    if parameters.geometry == "axisymmetric":
        position = points(across, along, np.zeros(1))
        return _Lattice(position, (step, layer, 0.0), 0.5 * radius**2 * thickness)
    wide = np.concatenate([-across[::-1], across]) if parameters.geometry == "half" else across
    parts = 2 if parameters.geometry == "half" else 1
    return _Lattice(points(wide, across, along), (step, step, layer), parts * radius**2 * thickness)


def _projectile(parameters: Impact, lattice: "np.ndarray") -> _Lattice:
    """Points around the projectile's own centre, so that a sphere is symmetric on any grid."""
    import numpy as np

    radius, length = 0.5 * parameters.projectile_diameter, _length(parameters)
    across, step = line(0.0, radius, float(lattice[0]))
    along, layer = line(-length, 0.0, float(lattice[0]))
    whole = np.concatenate([-across[::-1], across])
    if parameters.geometry == "axisymmetric":
        position = points(across, along, np.zeros(1))
        from_axis, along_flight, spacings = position[:, 0], position[:, 1], (step, layer, 0.0)
    else:
        position = points(whole if parameters.geometry == "half" else across, across, along)
        from_axis, along_flight = np.hypot(position[:, 0], position[:, 1]), position[:, 2]
        spacings = (step, step, layer)
    lean = _lean(parameters)
    if parameters.projectile_shape == "sphere":
        inside = from_axis**2 + (along_flight + radius) ** 2 < radius**2
        volume = 4.0 / 3.0 * math.pi * radius**3
    else:
        inside = from_axis < radius
        volume = math.pi * radius**2 * length
    position = position[inside]
    if lean:
        # About the middle of the cylinder, whose lowest edge then touches the surface.
        height = position[:, 2] + 0.5 * length
        x = position[:, 0] * math.cos(lean) + height * math.sin(lean)
        z = height * math.cos(lean) - position[:, 0] * math.sin(lean)
        position = np.stack([x, position[:, 1], z - 0.5 * _height(parameters)], axis=-1)
    part = 1.0 if parameters.geometry == "axisymmetric" else SECTORS[parameters.geometry]
    return _Lattice(position, spacings, volume * part / (2.0 * math.pi))


def _body(
    name: str, parameters: Impact, material: "Material", geometry: Any, lattice: _Lattice, velocity: "np.ndarray"
) -> "Body":
    tension = recipe_of(parameters).tension
    return body(
        name,
        matter(
            material,
            eos_form=parameters.eos_form,
            thermal_softening=parameters.thermal_softening,
            tension=tension,
            failure=failure_of(parameters, material),
        ),
        geometry,
        position=lattice.position,
        spacing=lattice.spacing,
        velocity=velocity,
        density=material.density,
        volume=lattice.volume,
    )
