"""Shapes in three dimensions and separated spheres have their known sizes, in whatever order their particles come."""

import math
from collections.abc import Callable, Mapping
from functools import partial
from typing import Any

import numpy as np
import pytest

from solver.problem.geometry import Cartesian3D, grid
from solver.state import empty_table, views
from studies.measurements.impact.view import ImpactView, view
from tests import samples
from tests.claims.rows import Row, absolute, relative
from tests.studies.measurements.states import (
    CELL,
    DENSITY,
    DIAMETER,
    TENTH,
    body_of,
    lattice,
    read,
    reordered,
    setting_of_plate,
    snapshot_of,
)

SCOOP = 8e-3  # radius, m
# Half axes of the ellipse, m: 20 x 12 mm, whose mean root is 15.49 mm.
ELLIPSE = 10e-3, 6e-3
OFF_AXIS = 3.3e-3  # m
BOWL, SLIP = 8e-3, 2e-3  # depth, and the way of its deepest place from the middle of its mouth, m
SAME = 1e-10  # relative: sums run in another order

Inside = Callable[[np.ndarray, np.ndarray, np.ndarray], np.ndarray]


def half_block(inside: Inside, *, radius: float, thickness: float, per_cell: int = 4) -> ImpactView:
    """A target in a half model after an oblique shot, without the particles that ``inside`` (x, y, z) takes.

    A fine lattice makes the staircase of a curved wall small.
    """
    step = CELL / per_cell
    wide, across, along = (
        step * (np.arange(round((high - low) / step)) + 0.5) + low
        for low, high in ((-radius, radius), (0.0, radius), (0.0, thickness))
    )
    position = np.stack(lattice(wide, across, along), axis=-1)
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


def _drill(x: np.ndarray, y: np.ndarray, z: np.ndarray) -> np.ndarray:
    a, b = ELLIPSE
    return ((x - OFF_AXIS) / a) ** 2 + (y / b) ** 2 < 1.0


def _tilted(x: np.ndarray, y: np.ndarray, z: np.ndarray) -> np.ndarray:
    """A bowl whose mouth is an ellipse off the axis, and whose deepest place is off the middle of its mouth."""
    (a, b), level = ELLIPSE, z / BOWL
    return ((x - OFF_AXIS - SLIP * level) / a) ** 2 + (y / b) ** 2 < 1.0 - level


def _floor(curvature: float) -> float:
    """Half of the rise of a round floor, by its curvature in 1/m, within the column in which it is looked for."""
    return 0.25 * (0.25 * DIAMETER) ** 2 * curvature


def _axes(quantity: str) -> dict[str, tuple[float, float]]:
    sizes = {"largest": 20e-3, "smallest": 12e-3, "mean_root": 15.49e-3}
    return {f"{quantity}_{axis}": (size, TENTH) for axis, size in sizes.items()}


A, B = ELLIPSE
BLOCK: dict[str, Any] = {"radius": 16e-3, "thickness": 12e-3}
# State of four particles a cell (with three, a tilted crater would pass without walls at the circle that halves a
# window's area) or of one, and by measurement: the size, and how far off the reading may be.
SHAPES: Mapping[str, tuple[Callable[..., Any], Mapping[str, tuple[float, float]]]] = {
    "scooped half space": (
        partial(half_block, lambda x, y, z: x**2 + y**2 + z**2 < SCOOP**2, **BLOCK),
        {
            "crater_depth": (SCOOP - _floor(1.0 / SCOOP), TENTH),
            "crater_diameter_mean_root": (2.0 * SCOOP, TENTH),
            "crater_volume": (2.0 / 3.0 * math.pi * SCOOP**3, 2.0 * math.pi * SCOOP**2 * TENTH),
        },
    ),
    "drilled ellipse of 20 x 12 mm": (
        partial(half_block, _drill, radius=20e-3, thickness=2e-3),
        _axes("hole_diameter"),
    ),
    "crater of a tilted shot": (
        partial(half_block, _tilted, **BLOCK),
        {
            # At the deepest place, and not below the middle of the mouth.
            "crater_depth": (BOWL - _floor(BOWL * (A**-2 + B**-2)), TENTH),
            **_axes("crater_diameter"),
            # The surface of the bowl is larger than that of its mouth.
            "crater_volume": (0.5 * math.pi * A * B * BOWL, math.pi * A * B * TENTH),
        },
    ),
    **samples.joined("SHAPES", {}),
}


QUICK = pytest.mark.claim("shapes", "known-shapes")
# Of seconds; craters are read about the axis in ``test_known_answers``, and in the half model in the contracts.
LONG = pytest.mark.claim("shapes", "known-shapes", minutes=0.1)


@pytest.mark.parametrize(
    "shape", [pytest.param(name, marks=LONG if "_depth" in str(SHAPES[name][1]) else QUICK) for name in SHAPES]
)
def test_shape__has_its_known_sizes(shape: str, compared: Callable[[Row], None]) -> None:
    """Craters, holes and spheres of known sizes are read to a tenth of a cell, whatever the order of particles."""
    build, sizes = SHAPES[shape]
    fine, coarse = build(), build(per_cell=1)
    shuffled = reordered(coarse)
    for name, (size, off) in sizes.items():
        compared(absolute(f"{shape}: {name} (SI)", expected=size, got=read(name, fine).value, within=off))
        expected, got = (read(name, each).value for each in (coarse, shuffled))
        compared(relative(f"{shape}: {name}, particles in another order", expected=expected, got=got, within=SAME))
