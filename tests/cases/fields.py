"""Particle fields with a known answer on the grid: a uniform pressure, a uniform expansion."""

from typing import Any, NamedTuple

import numpy as np

from solver.grid.nodes import Nodes, node_positions
from solver.grid.shapes.linear import Linear
from solver.grid.step import Field, bound_kernels
from solver.grid.transfer import scatter_state
from solver.jit import kernel
from solver.problem import Body, Face, Problem
from solver.problem.geometry import Axisymmetric, Cartesian3D, grid, hoop_factor, lattice_measure
from solver.state import Particles, X, empty_table, views
from solver.steps.space import PACK, find_nodes, gather, new_pack, velocity_gradient
from solver.vectors import LANES, first_lanes, load, store
from tests.solver.bodies import elastic_copper, tabulated

CELLS, SPACING = 12, 0.7e-3
LINEAR = Linear()
FREE, MIRROR = (Face.FREE, Face.FREE), (Face.SYMMETRIC, Face.FREE)
PRESSURE, RATE = 3e9, 2e4  # Pa, 1/s


class Expansion(NamedTuple):
    """Error of the volume rate of v = k x at particles that no face disturbs."""

    relative: np.ndarray  # (n,) |tr D - 3 k| / 3 k
    cells_from_axis: np.ndarray  # (n,)


def block(kind: str) -> tuple[Any, Particles]:
    """A grid filled with two particles per cell and direction, one density."""
    flat = kind == "axisymmetric"
    record = Axisymmetric if flat else Cartesian3D
    cells = (CELLS, CELLS, 0 if flat else CELLS)
    geometry = grid(record, lower=(0.0, 0.0, 0.0), cells=cells, spacing=SPACING)
    line = (np.arange(2 * CELLS) + 0.5) * 0.5 * SPACING
    points = np.meshgrid(line, line, np.zeros(1) if flat else line, indexing="ij")
    particles = views(empty_table(points[0].size))
    particles.position[:] = np.stack([axis.ravel() for axis in points], axis=-1)
    particles.density[:] = 8930.0
    step = 0.5 * SPACING
    measure = lattice_measure(geometry, particles.position.T, (step, step, step))
    particles.mass[:] = 8930.0 * measure
    return geometry, particles


def closed(geometry: Any, particles: Particles, faces: tuple[tuple[Face, Face], ...], shape: Any) -> Field:
    """Mass, momentum and force of the particles on the nodes, ghosts folded and faces held, as a step does it."""
    body = Body(
        name="block",
        matter=elastic_copper(),
        position=particles.position,
        velocity=np.zeros(3),
        mass=particles.mass,
        density=8930.0,
        spacing=(0.5 * SPACING,) * 3,
    )
    field = Field(Problem(geometry, (body,), faces, end_time=1.0, shape=shape), slice(0, 1), 1, bound_kernels())
    ranges = np.array([[0, particles.mass.size]])
    table, state = tabulated(particles), field.nodes.state
    scatter_state(geometry, shape, new_pack(), table, ranges, state, field.touched[0])
    field.close(1.0, np.zeros(3))
    return field


def inner_nodes(geometry: Any, faces: tuple[tuple[Face, Face], ...], margin: float) -> np.ndarray:
    """Indices of the nodes on the grid and ``margin`` cells and more away from free faces."""
    place = np.rint((node_positions(geometry) - geometry.lower) / geometry.spacing)
    free = np.array([[kind == Face.FREE for kind in axis] for axis in faces])
    inside = (place >= margin * free[:, 0]) & (place <= geometry.cells - margin * free[:, 1])
    return np.flatnonzero(inside[:, geometry.cells > 0].all(axis=1))


def force_of_uniform_pressure(kind: str, shape: Any = LINEAR, first_column: int = 0) -> float:
    """Largest force on a node over that of the pressure on a cell's face (times r per radian).

    The lower faces mirror; nodes that a free face reaches are left out, and columns before ``first_column``.
    """
    geometry, particles = block(kind)
    particles.pressure[:] = PRESSURE
    faces = (MIRROR, MIRROR, MIRROR)
    nodes = closed(geometry, particles, faces, shape).nodes
    inner = inner_nodes(geometry, faces, 2.0)
    column = np.rint(node_positions(geometry)[inner, 0] / SPACING)
    force = nodes.force[inner[column >= first_column]]
    return float(np.abs(force).max() / (PRESSURE * SPACING**2))


def expansion_error(kind: str, shape: Any = LINEAR) -> Expansion:
    """The volume rate that particles see when each moves with v = k x (r and z in axisymmetry)."""
    geometry, particles = block(kind)
    particles.velocity[:] = RATE * particles.position
    field = closed(geometry, particles, (MIRROR, MIRROR, MIRROR), shape)
    nodes = field.nodes
    solid = nodes.mass > 0.0
    nodes.velocity[solid] = nodes.momentum[solid] / nodes.mass[solid, None]
    field.mirror()
    rate = np.trace(velocity_gradients(geometry, shape, particles, nodes), axis1=1, axis2=2)
    cells = particles.position / SPACING
    inside = (cells < CELLS - 2.5) | (geometry.cells == 0)
    keep = inside.all(axis=1)
    return Expansion(np.abs(rate[keep] / (3.0 * RATE) - 1.0), cells[keep, 0])


def velocity_gradients(geometry: Any, shape: Any, particles: Particles, nodes: Nodes) -> np.ndarray:
    """The velocity gradient of each particle (n, 3, 3), found as the strain update finds it."""
    rows = np.zeros((9, particles.mass.size))
    _gradients(geometry, shape, new_pack(), tabulated(particles), nodes.mapped, rows)
    return rows.T.reshape(-1, 3, 3)


@kernel
def _gradients(geometry, shape, pack, table, velocities, rows):
    count = table.shape[1]
    for start in range(0, count, PACK):
        stop = min(start + PACK, count)
        find_nodes(geometry, shape, table, start, stop, pack)
        for k in range(stop - start):
            gather(geometry, shape, k, pack, velocities, pack.lines)
        for p in range(start, stop, LANES):
            lanes = first_lanes(stop - p)
            hoop = hoop_factor(geometry, load(table, X, p, lanes))
            gradient = velocity_gradient(geometry, pack.lines, p - start, hoop)
            for j in range(3):
                for k in range(3):
                    store(rows, 3 * j + k, p, gradient[j][k], lanes)
