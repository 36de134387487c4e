"""Small problems of copper that several tests share: a lattice in a box, and an impact with few particles.

All copper has the same types of laws, so that each geometry and shape compiles one kind of kernels.
"""

import math
from functools import cache
from typing import Any, NamedTuple

import numpy as np
import pytest

from solver.audit import Audit
from solver.grid.nodes import node_strides
from solver.grid.shapes import width
from solver.matter.eos.mie_grueneisen import mie_grueneisen
from solver.matter.laws import Matter
from solver.matter.strength.johnson_cook import JohnsonCook
from solver.matter.tension.recoverable import RecoverableTension
from solver.problem import Body, Face, Problem
from solver.problem.geometry import Axisymmetric, Cartesian3D, dimensions, grid, hoop_factor, lattice_measure
from solver.registry import entries
from solver.simulation import Simulation, start
from solver.state import Particles, empty_table, views
from solver.steps.space import WIDEST, find_nodes, new_pack

DENSITY, SOUND_SPEED, SHEAR_MODULUS = 8930.0, 3940.0, 47.7e9
ROOM, MELT = 298.0, 1356.0
CONSTANTS = {
    "density": DENSITY,
    "c0": SOUND_SPEED,
    "s": 1.489,
    "gamma0": 1.99,
    "heat_capacity": 383.0,
    "temperature": ROOM,
}
UNBOUNDED = 1e300  # Pa: no stress comes to such a strength
SPACING = 1e-3  # of the cells, m
FREE = (Face.FREE, Face.FREE)
SYMMETRIC = (Face.SYMMETRIC, Face.SYMMETRIC)
OPEN = (FREE, FREE, FREE)
ABOUT_AXIS = ((Face.SYMMETRIC, Face.FREE), FREE, FREE)

ROUND_OFF = 1e-12  # of sums over a few hundred particles, relative
SHAPES = {name: entry.record() for name, entry in entries("solver.grid.shapes", "SHAPE").items()}
each_shape = pytest.mark.parametrize("shape", SHAPES.values(), ids=SHAPES)
each_kind = pytest.mark.parametrize("kind", ["axisymmetric", "cartesian"])


class Stencil(NamedTuple):
    """The n nodes of a particle, each with the weight N and the gradient G (1/m) of solver/grid/stencils.py."""

    node: np.ndarray  # (n,) indices
    weight: np.ndarray  # (n,)
    gradient: np.ndarray  # (n, 3)


@cache
def elastic_copper() -> Matter:
    """Copper that never yields, melts or parts."""
    return Matter(
        eos=mie_grueneisen(**CONSTANTS),
        strength=JohnsonCook(A=UNBOUNDED, B=0.0, n=1.0, C=0.0, m=1.0, reference_rate=1.0),
        tension=RecoverableTension(UNBOUNDED),
        shear_modulus=SHEAR_MODULUS,
        room_temperature=ROOM,
        melt_temperature=math.inf,
    )


@cache
def real_copper() -> Matter:
    """Copper of Johnson and Cook with a tensile floor."""
    return Matter(
        eos=mie_grueneisen(**CONSTANTS),
        strength=JohnsonCook(90e6, 292e6, 0.31, 0.025, 1.09, 1.0),
        tension=RecoverableTension(1.9e9),
        shear_modulus=SHEAR_MODULUS,
        room_temperature=ROOM,
        melt_temperature=MELT,
    )


def box(*cells: int) -> Any:
    """A grid from the origin: x, y, z of three numbers, r and z of two."""
    record = Axisymmetric if len(cells) == 2 else Cartesian3D
    return grid(record, lower=(0.0, 0.0, 0.0), cells=(*cells, 0)[:3], spacing=SPACING)


def tabulated(particles: Particles) -> np.ndarray:
    """A table (ROWS, n) with the numbers of some particles, as kernels want it."""
    table = empty_table(particles.mass.size)
    copy = views(table, particles.number, particles.alive)
    for name in set(Particles._fields) - {"number", "alive"}:
        getattr(copy, name)[:] = getattr(particles, name)
    return table


def stencil(geometry: Any, shape: Any, place: np.ndarray) -> Stencil:
    """The nodes of a particle at a place (m)."""
    table = empty_table(1)
    views(table).position[0] = place
    pack = new_pack()
    find_nodes(geometry, shape, table, 0, 1, pack)
    index, weight, slope = pack.first, pack.weight, pack.slope
    axes, count = dimensions(geometry), width(shape)
    along = np.array(list(np.ndindex((count,) * axes)))  # (n, axes) which node along each axis
    lines = WIDEST * np.arange(axes) + along
    weights, slopes = weight[lines, 0], slope[lines, 0]
    strides = node_strides(geometry)[:axes]
    gradient = np.zeros((len(along), 3))
    for axis in range(axes):
        others = np.arange(axes) != axis
        gradient[:, axis] = slopes[:, axis] * weights[:, others].prod(axis=1)
    whole = weights.prod(axis=1)
    if axes == 2:
        gradient[:, 2] = whole * hoop_factor(geometry, place[0])
    return Stencil(index[0] + along @ strides, whole, gradient)


def lattice(geometry: Any, lower: tuple[float, ...], upper: tuple[float, ...]) -> tuple[np.ndarray, np.ndarray]:
    """Positions and masses of two particles per cell and direction between two corners, counted in cells."""
    step = 0.5 * SPACING
    lines = [
        low * SPACING + step * (np.arange(round(2.0 * (high - low))) + 0.5)
        for low, high in zip(lower, upper, strict=True)
    ]
    lines += [np.zeros(1)] * (3 - len(lines))
    position = np.stack([axis.ravel() for axis in np.meshgrid(*lines, indexing="ij")], axis=-1)
    measure = lattice_measure(geometry, position.T, (step, step, step))
    return position, DENSITY * measure * np.ones(len(position))


def block(
    geometry: Any,
    lower: tuple[float, ...],
    upper: tuple[float, ...],
    *,
    velocity: tuple[float, float, float] = (0.0, 0.0, 0.0),
    name: str = "block",
    matter: Matter | None = None,
) -> Body:
    """A box of copper between two corners, counted in cells."""
    position, mass = lattice(geometry, lower, upper)
    return Body(
        name=name,
        matter=matter or elastic_copper(),
        position=position,
        velocity=np.array(velocity),
        mass=mass,
        density=DENSITY,
        spacing=(0.5 * SPACING,) * 3,
    )


def along(kind: str, speed: float) -> tuple[float, float, float]:
    """A velocity along the last axis of a kind of geometry."""
    return (0.0, speed, 0.0) if kind == "axisymmetric" else (0.0, 0.0, speed)


def two_blocks(kind: str, *, speed: float = 2000.0, **changes: Any) -> Problem:
    """A block that flies along the last axis into one at rest: touching, all faces free but the axis."""
    flat = kind == "axisymmetric"
    geometry = box(12, 16) if flat else box(12, 6, 16)
    low, high = ((0.0,), (3.0,)) if flat else ((3.0, 1.0), (6.0, 4.0))
    wide_low, wide_high = ((0.0,), (9.0,)) if flat else ((1.0, 1.0), (11.0, 5.0))
    bodies = (
        block(geometry, (*low, 4.0), (*high, 7.0), velocity=along(kind, speed), name="flyer", matter=real_copper()),
        block(geometry, (*wide_low, 7.0), (*wide_high, 9.0), name="plate", matter=real_copper()),
    )
    return Problem(
        **{"geometry": geometry, "bodies": bodies, "faces": ABOUT_AXIS if flat else OPEN, "end_time": 1e-6, **changes}
    )


def leaving(kind: str, speed: float = 3000.0, **changes: Any) -> Problem:
    """A block that leaves through the free upper face, and one that stands still."""
    flat = kind == "axisymmetric"
    geometry = box(6, 10) if flat else box(6, 6, 10)
    low, high = ((1.0,), (4.0,)) if flat else ((1.0, 2.0), (4.0, 4.0))
    bodies = (
        block(geometry, (*low, 1.0), (*high, 2.0), name="stays"),
        block(geometry, (*low, 6.0), (*high, 9.0), velocity=along(kind, speed), name="goes"),
    )
    faces = ABOUT_AXIS if flat else OPEN
    return Problem(geometry, bodies, faces, **{"end_time": 3e-6, **changes})


def after(problem: Problem, steps: int, *, threads: int = 1, shares: int = 0) -> Simulation:
    simulation = start(problem, threads=threads, shares=shares)
    for _ in range(steps):
        simulation.advance()
    return simulation


def assert_same_bits(particles: Particles, other: Particles) -> None:
    """Compare particles field by field; NaN is equal to itself here."""
    for name in Particles._fields:
        assert getattr(particles, name).tobytes() == getattr(other, name).tobytes(), name


def assert_balanced(audit: Audit) -> None:
    """Mass, momentum and energy are kept to round-off."""
    assert audit.mass_error <= ROUND_OFF
    assert audit.momentum_error <= ROUND_OFF
    assert abs(audit.energy_drift) <= ROUND_OFF
