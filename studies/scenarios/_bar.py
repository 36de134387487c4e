"""Common part of the scenarios of a bar that hits a wall: parameters, lattice, faces, the size of the work.

The wall is the face z = 0; the bar stands on it at z > 0 and flies towards -z. The lattice is stretched by a few per
cent where needed so that length and diameter are exact; the masses are scaled to the analytic mass, from which a
lattice cylinder differs by 1 %.
"""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Annotated, Any, Literal

from solver.units import Described
from studies.scenarios import Dimension, Outline, Setting, Shape, Size
from studies.scenarios._lattice import SECTORS, body, line, mesh, points
from studies.scenarios._loading import Loading, added_speed, check_loading, loads
from studies.scenarios._method import is_coupled, is_meshed
from studies.scenarios._numerics import Numerics, filled_numerics, mean_step, numerics, particles_per_cell
from studies.values.errors import Finding

if TYPE_CHECKING:
    import numpy as np

    from solver.problem import Body, Face, Matter


@dataclass(frozen=True, kw_only=True)
class AtWall:
    """Model of a bar and its wall."""

    geometry: Annotated[
        Literal["axisymmetric", "quarter"], Described("body of revolution, or a quarter of a bar in three dimensions")
    ] = "axisymmetric"
    section: Annotated[
        Literal["round", "square"],
        Described("section of the bar; a square one, whose side is bar_diameter, in three dimensions", neutral=True),
    ] = "round"
    wall: Annotated[
        Literal["unilateral", "symmetric"],
        Described("frictionless wall that only pushes, or a wall that holds the normal velocity in both directions"),
    ] = "unilateral"


@dataclass(frozen=True, kw_only=True)
class Bar(Numerics, Loading, AtWall):
    """Parameters of every bar that hits a wall."""


@dataclass(frozen=True, kw_only=True)
class Extent:
    """A bar in numbers, and the room and time that it gets."""

    length: float  # m
    diameter: float  # m
    speed: float  # m/s
    fastest: float  # of matter, with its loads, m/s
    cell: float  # m
    height: float  # of the grid, m
    radius: float  # of the grid, m
    end_time: float  # s


@dataclass(frozen=True, kw_only=True)
class BarSetting(Setting):
    """A bar as its observer needs to know it."""

    length: float  # m
    diameter: float  # m
    speed: float  # m/s
    place: "np.ndarray"  # (n, 3) of each particle in the initial lattice: across, across, along
    # Length, mushroom diameter and width to be compared with, m.
    references: tuple[float | None, float | None, float | None] = (None, None, None)


def assemble(
    parameters: Bar,
    extent: Extent,
    matter: "Matter",
    density: float,
    references: tuple[float | None, float | None, float | None] = (None, None, None),
) -> BarSetting:
    """The problem of a bar at the moment when it touches the wall."""
    from solver.problem import Problem

    geometry, faces = _grid(parameters, extent)
    bodies, place = (_meshed_bar if is_meshed(parameters) else _bar)(parameters, extent, matter, density, geometry)
    return BarSetting(
        problem=Problem(
            geometry=geometry,
            bodies=bodies,
            faces=faces,
            end_time=extent.end_time,
            **loads(parameters, axis=1 if parameters.geometry == "axisymmetric" else 2, end_time=extent.end_time),
            **numerics(parameters),
        ),
        sector=SECTORS[parameters.geometry],
        length=extent.length,
        diameter=extent.diameter,
        speed=extent.speed,
        place=place,
        references=references,
    )


def size(parameters: Bar, extent: Extent, sound_speed: float) -> Size:
    """Particles from the volume, and steps from the stable step of the undisturbed state."""
    parameters = filled_numerics(parameters)
    step = extent.cell / particles_per_cell(parameters)
    if parameters.geometry == "axisymmetric":
        particles = 0.5 * extent.diameter * extent.length / step**2
    else:
        particles = _section(parameters, extent) * extent.length / step**3
    dt = mean_step(parameters, extent.cell, sound=sound_speed, speed=extent.fastest)
    return Size(particles=round(particles), steps=math.ceil(extent.end_time / dt))


def check_bar(parameters: Bar, extent: Extent, *, density: float, sound: float) -> list[Finding]:
    """The bar is as long as a cell at least, square in three dimensions alone, and bears its loads.

    Its diameter has two cells by its own bounds.
    """
    findings = check_loading(
        parameters, density=density, sound=sound, time=extent.end_time, length=(extent.length, extent.cell)
    )
    if extent.length < extent.cell:
        limit = f"at least a cell, {extent.cell:g} m"
        cure = "raise the resolution (cells per diameter)"
        findings.append(Finding("bar_length", f"{extent.length:g} m", limit, cure))
    if parameters.section == "square" and parameters.geometry == "axisymmetric":
        limit = "round in a body of revolution"
        findings.append(Finding("section", "square", limit, "set geometry to quarter"))
    return findings


def fastest(parameters: Any, *, impedance: float, time: float) -> float:
    """Speed that matter may have within a time (s), with its loads, m/s; ``impedance`` is rho c, Pa s/m."""
    own: float = parameters.speed
    return own + added_speed(parameters, impedance=impedance, time=time)


def longitudinal_speed(bulk: float, shear: float, density: float) -> float:
    """Speed of an elastic wave of uniaxial strain, m/s."""
    return math.sqrt((bulk + 4.0 / 3.0 * shear) / density)


def outline(values: Mapping[str, Any], *, length: str, diameter: str) -> Outline | None:
    """A bar as it touches the wall; ``length`` and ``diameter`` are its parameters."""
    high, wide = (values.get(name) for name in (length, diameter))
    if not high or not wide:
        return None
    half = 0.5 * wide
    bar = Shape("bar", -half, half, 0.0, high, heading=(0.0, -1.0))
    wall = Shape("wall", -3.0 * half, 3.0 * half, -0.3 * half, 0.0)
    return Outline(
        (bar, wall), (Dimension(diameter, (-half, high), (half, high)), Dimension(length, (half, 0.0), (half, high)))
    )


def view(setting: Any, snapshot: Any) -> Any:
    """A state of a bar, as measurements see it."""
    from studies.measurements import _bar

    return _bar.view(setting, snapshot)


def _grid(parameters: Bar, extent: Extent) -> tuple[Any, tuple[tuple["Face", "Face"], ...]]:
    from solver.problem import Face

    return mesh(
        parameters.geometry,
        across=math.ceil(extent.radius / extent.cell - 1e-9),
        along=math.ceil(extent.height / extent.cell - 1e-9),
        front=0.0,
        cell=extent.cell,
        side=(Face.SYMMETRIC, Face.FREE),
        flight=(Face.WALL if parameters.wall == "unilateral" else Face.SYMMETRIC, Face.FREE),
    )


def _section(parameters: Bar, extent: Extent) -> float:
    """Area of the section that the model has, m2 (m2 per radian)."""
    radius = 0.5 * extent.diameter
    if parameters.geometry == "axisymmetric":
        return 0.5 * radius**2
    return (1.0 if parameters.section == "square" else 0.25 * math.pi) * radius**2


def _bar(
    parameters: Bar, extent: Extent, matter: "Matter", density: float, geometry: Any
) -> tuple[tuple["Body", ...], "np.ndarray"]:
    """The bar, and the place of each of its particles in the lattice."""
    import numpy as np

    step = extent.cell / particles_per_cell(parameters)
    radius = 0.5 * extent.diameter
    across, wide = line(0.0, radius, step)
    along, high = line(0.0, extent.length, step)
    flat = parameters.geometry == "axisymmetric"
    columns = (across, np.zeros(1), along) if flat else (across, across, along)
    where = points(*columns)
    place = points(*(np.arange(column.size) for column in columns))
    if parameters.section == "round":
        inside = np.hypot(where[:, 0], where[:, 1]) < radius
        where, place = where[inside], place[inside]
    velocity = np.zeros(3)
    velocity[1 if flat else 2] = -extent.speed
    made = body(
        "bar",
        matter,
        geometry,
        position=where[:, [0, 2, 1]] if flat else where,
        spacing=(wide, high, 0.0) if flat else (wide, wide, high),
        velocity=velocity,
        density=density,
        volume=_section(parameters, extent) * extent.length,
    )
    return (made,), place


def _meshed_bar(
    parameters: Bar, extent: Extent, matter: "Matter", density: float, geometry: Any
) -> tuple[tuple["Body", ...], "np.ndarray"]:
    """A square bar of elements, or of these and of particles below them, and the place of each node or particle."""
    import numpy as np

    from solver.fem.elements import Hexahedron
    from solver.fem.mesh import lattice, node_masses
    from solver.problem import Body

    step = extent.cell / particles_per_cell(parameters)
    pieces, layers = (max(1, round(whole / step)) for whole in (0.5 * extent.diameter, extent.length))
    across = np.linspace(0.0, 0.5 * extent.diameter, pieces + 1)
    along = np.linspace(0.0, extent.length, layers + 1)
    middle = layers // 2 if is_coupled(parameters) else 0
    parts = [("bar-elements" if middle else "bar", middle, layers)]
    parts += [("bar", 0, middle)] if middle else []
    bodies, places = [], []
    for number, (name, begin, end) in enumerate(parts):
        position, mesh = lattice(Hexahedron(), across, across, along[begin : end + 1])
        bodies.append(
            Body(
                name=name,
                matter=matter,
                position=position,
                velocity=np.array([0.0, 0.0, -extent.speed]),
                mass=node_masses(mesh, position, density),
                density=density,
                spacing=(across[1], across[1], along[1]),
                mesh=None if number else mesh,
            )
        )
        corners = np.arange(pieces + 1)
        places.append(points(corners, corners, np.arange(begin, end + 1)))
    return tuple(bodies), np.concatenate(places)
