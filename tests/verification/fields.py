"""Particle fields with a known answer on the grid: a uniform pressure, a uniform expansion."""

from typing import Any, NamedTuple

import numpy as np

from solver.faces import closed_layers, fold_state, hold_state, mirror_velocity
from solver.geometry import grid, lattice_measure, node_count, node_positions
from solver.geometry.axisymmetric import Axisymmetric
from solver.geometry.cartesian3d import Cartesian3D
from solver.problem import Face, clamp
from solver.shapes.linear import Linear
from solver.state import Nodes, Particles, empty_nodes, empty_particles
from solver.step import solve_momentum
from solver.transfer import (
    gather_velocity_gradient,
    new_stencil,
    scatter_state,
    slab_count,
    sort_into_slabs,
)

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
    particles = empty_particles(points[0].size)
    particles.position[:] = np.stack([axis.ravel() for axis in points], axis=-1)
    particles.density[:] = 8930.0
    step = 0.5 * SPACING
    measure = lattice_measure(geometry, particles.position.T, (step, step, step))
    particles.mass[:] = 8930.0 * measure
    return geometry, particles


def scattered(geometry: Any, particles: Particles, shape: Any = LINEAR) -> Nodes:
    """The nodes after mass, momentum and force of the particles were put on them."""
    nodes = empty_nodes(node_count(geometry))
    order = np.empty(particles.mass.size, np.int64)
    start = np.zeros(slab_count(geometry) + 1, np.int64)
    sort_into_slabs(geometry, particles, 0, particles.mass.size, order, start)
    slabs = np.arange(slab_count(geometry))
    scatter_state(geometry, shape, particles, order, start, slabs, nodes)
    return nodes


def closed(geometry: Any, nodes: Nodes, faces: tuple[tuple[Face, Face], ...]) -> np.ndarray:
    """Ghosts folded and faces held, as a step does it; returns the impulse of one second."""
    impulse = np.zeros(3)
    for axis in closed_layers(geometry, faces, clamp()):
        for layer in axis:
            fold_state(layer, nodes)
        for layer in axis:
            hold_state(layer, nodes, 1.0, impulse)
    return impulse


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
    nodes = scattered(geometry, particles, shape)
    faces = (MIRROR, MIRROR, MIRROR)
    closed(geometry, nodes, faces)
    inner = inner_nodes(geometry, faces, 2.0)
    column = np.rint(node_positions(geometry)[inner, 0] / SPACING)
    force = nodes.force[inner[column >= first_column]]
    return float(np.abs(force).max() / (PRESSURE * SPACING**2))


def expansion_error(kind: str, shape: Any = LINEAR) -> Expansion:
    """The volume rate that particles see when each moves with v = k x (r and z in axisymmetry)."""
    geometry, particles = block(kind)
    particles.velocity[:] = RATE * particles.position
    nodes = scattered(geometry, particles, shape)
    faces = (MIRROR, MIRROR, MIRROR)
    closed(geometry, nodes, faces)
    solve_momentum(nodes, 0, nodes.mass.size, 0.0)
    for axis in reversed(closed_layers(geometry, faces, clamp())):
        for layer in axis:
            mirror_velocity(layer, nodes)
    rate = np.array(
        [_volume_rate(geometry, shape, particles, nodes, p) for p in range(particles.mass.size)]
    )
    cells = particles.position / SPACING
    inside = (cells < CELLS - 2.5) | (geometry.cells == 0)
    keep = inside.all(axis=1)
    return Expansion(np.abs(rate[keep] / (3.0 * RATE) - 1.0), cells[keep, 0])


def _volume_rate(geometry: Any, shape: Any, particles: Particles, nodes: Nodes, p: int) -> float:
    stencil = new_stencil(geometry, shape)
    gradient = np.zeros((3, 3))
    gather_velocity_gradient(geometry, shape, particles.position, p, nodes, stencil, gradient)
    return float(np.trace(gradient))
