"""Particle fields with a known answer on the grid: a uniform pressure, a uniform expansion."""

from typing import Any, NamedTuple

import numpy as np

from solver.faces import hold_face
from solver.geometry import face_nodes, grid, lattice_measure, node_count, node_positions
from solver.geometry.axisymmetric import Axisymmetric
from solver.geometry.cartesian3d import Cartesian3D
from solver.problem import Face
from solver.shapes.linear import Linear
from solver.state import Nodes, Particles, empty_nodes, empty_particles
from solver.step import finish_nodes
from solver.transfer import (
    gather_velocity_gradient,
    new_stencil,
    scatter_state,
    slab_count,
    sort_into_slabs,
)

CELLS, SPACING = 12, 0.7e-3
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


def scattered(geometry: Any, particles: Particles) -> Nodes:
    """The nodes after mass, momentum and force of the particles were put on them."""
    nodes = empty_nodes(node_count(geometry))
    order = np.empty(particles.mass.size, np.int64)
    start = np.zeros(slab_count(geometry) + 1, np.int64)
    sort_into_slabs(geometry, particles, order, start)
    slabs = np.arange(slab_count(geometry))
    scatter_state(geometry, Linear(), particles, order, start, slabs, nodes)
    return nodes


def inner_nodes(geometry: Any) -> np.ndarray:
    """Indices of the nodes on no face of the grid."""
    place = np.rint((node_positions(geometry) - geometry.lower) / geometry.spacing)
    wide = geometry.nodes > 1
    return np.flatnonzero(((place > 0) & (place < geometry.nodes - 1))[:, wide].all(axis=1))


def force_of_uniform_pressure(kind: str) -> float:
    """Largest force on an inner node over that of the pressure on a cell's face (times r per radian)."""
    geometry, particles = block(kind)
    particles.pressure[:] = PRESSURE
    force = scattered(geometry, particles).force[inner_nodes(geometry)]
    return float(np.abs(force).max() / (PRESSURE * SPACING**2))


def expansion_error(kind: str) -> Expansion:
    """The volume rate that particles see when each moves with v = k x (r and z in axisymmetry)."""
    geometry, particles = block(kind)
    particles.velocity[:] = RATE * particles.position
    nodes = scattered(geometry, particles)
    if kind == "axisymmetric":  # the axis, as the symmetric face holds it in every step
        hold_face(nodes, face_nodes(geometry, 0, 0), 0, 0, int(Face.SYMMETRIC), 0.0, np.zeros(3))
    finish_nodes(nodes, 0, nodes.mass.size)
    rate = np.array(
        [_volume_rate(geometry, particles, nodes, p) for p in range(particles.mass.size)]
    )
    cells = particles.position / SPACING
    inside = ((cells > 1.0) & (cells < CELLS - 1.0)) | (geometry.nodes == 1)
    if kind == "axisymmetric":
        inside[:, 0] = cells[:, 0] < CELLS - 1.0
    keep = inside.all(axis=1)
    return Expansion(np.abs(rate[keep] / (3.0 * RATE) - 1.0), cells[keep, 0])


def _volume_rate(geometry: Any, particles: Particles, nodes: Nodes, p: int) -> float:
    stencil = new_stencil(geometry, Linear())
    gradient = np.zeros((3, 3))
    gather_velocity_gradient(geometry, Linear(), particles.position, p, nodes, stencil, gradient)
    return float(np.trace(gradient))
