"""Shapes of known sizes: a scooped half space, a drilled ellipse, the crater of a tilted shot, two spheres."""

import math
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from functools import partial
from types import SimpleNamespace
from typing import Any

import numpy as np

from solver.geometry import grid
from solver.geometry.axisymmetric import Axisymmetric
from solver.geometry.cartesian3d import Cartesian3D
from solver.state import Particles, Snapshot, empty_table, views
from studies.measurements._impact import ImpactView, view
from tests.rows import Row, absolute, relative
from tests.studies.measurements.states import (
    BALLS,
    CELL,
    DENSITY,
    DIAMETER,
    PARTICLE,
    RADIUS,
    TENTH,
    THICKNESS,
    capped,
    read,
    reordered,
    two_balls,
)

SCOOP = 8e-3  # radius, m
# Half axes of the ellipse, m: 20 x 12 mm, whose mean root is 15.49 mm.
ELLIPSE = 10e-3, 6e-3
OFF_AXIS = 3.3e-3  # m
BOWL, SLIP = 8e-3, 2e-3  # depth, and the way of its deepest place from the middle of its mouth, m
SAME = 1e-10  # relative: sums run in another order

Inside = Callable[[np.ndarray, np.ndarray, np.ndarray], np.ndarray]


@dataclass(frozen=True)
class KnownShape:
    """A state of known sizes."""

    fine: Callable[[], Any]
    coarse: Callable[[], Any]  # in which the order of particles is changed
    sizes: Mapping[str, tuple[float, float]]  # by measurement: the size, and how far off the reading may be


def rows_of(shape: KnownShape) -> Iterator[Row]:
    """Each size, and then its reading of particles in another order."""
    state, coarse = shape.fine(), shape.coarse()
    shuffled = reordered(coarse)
    for name, (size, off) in shape.sizes.items():
        yield absolute(name, expected=size, got=read(name, state).value, within=off)
    for name in shape.sizes:
        expected, got = (read(name, each).value for each in (coarse, shuffled))
        yield relative(f"{name}, particles in another order", expected=expected, got=got, within=SAME)


def setting_of_plate(kind: str, **changes: Any) -> Any:
    """What ``view`` asks a setting for."""
    flat = kind == "axisymmetric"
    cells = round(changes.get("radius", RADIUS) / CELL)
    deep = round(changes.get("thickness", THICKNESS) / CELL) + 16
    left, wide = (-RADIUS, 2 * cells) if kind == "half" else (0.0, cells)
    lower = (0.0, -8.0 * CELL, 0.0) if flat else (left, 0.0, -8.0 * CELL)
    record = Axisymmetric if flat else Cartesian3D
    extent = (cells, deep, 0) if flat else (wide, cells, deep)
    return SimpleNamespace(
        **{
            "problem": SimpleNamespace(
                geometry=grid(record, lower=lower, cells=extent, spacing=CELL),
                bodies=(body_of("target", DENSITY),),
                absorbers=(),
            ),
            "target": "target",
            "projectile_diameter": DIAMETER,
            "thickness": THICKNESS,
            "radius": RADIUS,
            "sector": {"axisymmetric": 1.0, "quarter": 0.5 * math.pi, "half": math.pi}[kind],
            **changes,
        }
    )


def body_of(name: str, density: float, velocity: tuple[float, float, float] = (0.0, 0.0, 0.0)) -> Any:
    """What ``view`` asks a body for."""
    return SimpleNamespace(
        name=name, density=density, spacing=(PARTICLE,) * 3, velocity=np.array(velocity), mass=np.ones(1)
    )


def snapshot_of(particles: Particles) -> Snapshot:
    return Snapshot(0.0, 0, particles, np.zeros(particles.mass.size, np.int64))


def half_block(inside: Inside, *, radius: float, thickness: float, per_cell: int = 4) -> ImpactView:
    """A target in a half model after an oblique shot, without the particles that ``inside`` (x, y, z) takes.

    A fine lattice makes the staircase of a curved wall small.
    """
    step = CELL / per_cell
    wide, across, along = (
        step * (np.arange(round((high - low) / step)) + 0.5) + low
        for low, high in ((-radius, radius), (0.0, radius), (0.0, thickness))
    )
    position = np.stack([a.ravel() for a in np.meshgrid(wide, across, along, indexing="ij")], -1)
    position = position[~inside(*position.T)]
    particles = views(empty_table(len(position)))
    particles.position[:], particles.mass[:] = position, DENSITY * step**3
    setting = setting_of_plate("half", radius=radius, thickness=thickness)
    target = body_of("target", DENSITY)
    target.spacing = (step,) * 3
    setting.problem.bodies = (target, body_of("projectile", DENSITY, (1.0, 0.0, 1.0)))
    setting.problem.geometry = grid(
        Cartesian3D,
        lower=(-radius, 0.0, -8.0 * CELL),
        cells=(round(2.0 * radius / CELL), round(radius / CELL), round(thickness / CELL) + 16),
        spacing=CELL,
    )
    return view(setting, snapshot_of(particles))


def _scoop(x: np.ndarray, y: np.ndarray, z: np.ndarray) -> np.ndarray:
    return x**2 + y**2 + z**2 < SCOOP**2


def _drill(x: np.ndarray, y: np.ndarray, z: np.ndarray) -> np.ndarray:
    a, b = ELLIPSE
    return ((x - OFF_AXIS) / a) ** 2 + (y / b) ** 2 < 1.0


def _tilted(x: np.ndarray, y: np.ndarray, z: np.ndarray) -> np.ndarray:
    """A bowl whose mouth is an ellipse off the axis, and whose deepest place is off the middle of its mouth."""
    (a, b), level = ELLIPSE, z / BOWL
    return ((x - OFF_AXIS - SLIP * level) / a) ** 2 + (y / b) ** 2 < 1.0 - level


def _of_block(
    inside: Inside, sizes: Mapping[str, tuple[float, float]], *, radius: float, thickness: float
) -> KnownShape:
    block = partial(half_block, inside, radius=radius, thickness=thickness)
    return KnownShape(block, partial(block, per_cell=1), sizes)


def _floor(curvature: float) -> float:
    """Half of the rise of a round floor, by its curvature in 1/m, within the column in which it is looked for."""
    return 0.25 * (0.25 * DIAMETER) ** 2 * curvature


def _axes(quantity: str) -> dict[str, tuple[float, float]]:
    sizes = {"largest": 20e-3, "smallest": 12e-3, "mean_root": 15.49e-3}
    return {f"{quantity}_{axis}": (size, TENTH) for axis, size in sizes.items()}


def _spheres() -> dict[str, tuple[float, float]]:
    """Masses of whole balls, as far off as with another tenth of a cell, and the plane that 1 % of the mass exceeds."""
    masses = [4.0 / 3.0 * math.pi * radius**3 * DENSITY for radius, _, _ in BALLS]
    shells = [4.0 * math.pi * radius**2 * DENSITY * TENTH for radius, _, _ in BALLS]
    radius, middle, _ = BALLS[1]
    plane = middle + capped(0.01 * sum(masses) / masses[1]) * radius
    return {
        "fragments": (2.0, 0.0),
        "largest_fragment": (max(masses), max(shells)),
        "mass_behind": (sum(masses), sum(shells)),
        "cloud_length": (plane - THICKNESS, TENTH),
    }


def shapes() -> dict[str, KnownShape]:
    """The shapes by name."""
    a, b = ELLIPSE
    scooped = {
        "crater_depth": (SCOOP - _floor(1.0 / SCOOP), TENTH),
        "crater_diameter_mean_root": (2.0 * SCOOP, TENTH),
        "crater_volume": (2.0 / 3.0 * math.pi * SCOOP**3, 2.0 * math.pi * SCOOP**2 * TENTH),
    }
    tilted = {
        # At the deepest place, and not below the middle of the mouth.
        "crater_depth": (BOWL - _floor(BOWL * (a**-2 + b**-2)), TENTH),
        **_axes("crater_diameter"),
        # The surface of the bowl is larger than that of its mouth.
        "crater_volume": (0.5 * math.pi * a * b * BOWL, math.pi * a * b * TENTH),
    }
    block = {"radius": 16e-3, "thickness": 12e-3}
    return {
        "scooped half space": _of_block(_scoop, scooped, **block),
        "drilled ellipse of 20 x 12 mm": _of_block(_drill, _axes("hole_diameter"), radius=20e-3, thickness=2e-3),
        # With three points a cell it would pass without walls at the circle that halves a window's area.
        "crater of a tilted shot": _of_block(_tilted, tilted, **block),
        "two separated spheres": KnownShape(two_balls, two_balls, _spheres()),
    }
