"""Geometry: the only place that knows whether the world is a box or a body of revolution.

A particle is always a three-dimensional point with a three-dimensional stress. What differs is the meaning of the
coordinates, of the gradient that the stencil hands out, and of the measure that turns an area of lattice into volume:

==============  =====================  ============================  ==================
geometry        coordinates (1, 2, 3)  gradient G of a node           mass, force, energy
==============  =====================  ============================  ==================
``Cartesian3D``   x, y, z                (dN/dx, dN/dy, dN/dz)         whole
``Axisymmetric``  r, z, theta            (dN/dr, dN/dz, N/r)           per radian
==============  =====================  ============================  ==================

Both records have the same fields: ``lower`` corner of the domain (m), ``spacing`` of the cells (m), ``cells`` along
each axis (none along the third in axisymmetry) and ``nodes``. Outside each face stands one layer of ghost nodes,
because wide shapes reach over it; what they receive is folded back where the face is closed (``faces.py``), and stays
where it is free. The node (i, j, k), counted from the ghosts on, stands at index (i * nodes[1] + j) * nodes[2] + k.
"""

from typing import NamedTuple

import numpy as np

from solver.jit import device, generic

AXES = 3
MARGIN = 1  # layers of ghost nodes outside a face: what the widest shape reaches


class Stencil(NamedTuple):
    """Scratch of one particle's neighbourhood; n is the size of the stencil."""

    node: np.ndarray  # (n,) index of each node
    weight: np.ndarray  # (n,) N
    gradient: np.ndarray  # (n, 3) G in the geometry's own sense, 1/m
    line_weight: np.ndarray  # (3, width) one-dimensional weights along each axis
    line_slope: np.ndarray  # (3, width) their slopes, 1/m


@generic
def stencil_size(geometry, shape):
    """Nodes that a particle touches."""


@generic
def fill_stencil(geometry, shape, position, p, stencil):
    """Nodes, weights and gradients of particle ``p`` of ``position`` (n, 3), which lies inside the grid."""


@generic
def internal_force(geometry, stress, gradient, a):
    """Stress (6 components) times row ``a`` of the gradients (n, 3): minus the force per particle volume, (3,)."""


@generic
def add_velocity_gradient(geometry, velocity_gradient, velocity, i, gradient, a):
    """Add the part of node ``i`` of ``velocity`` (m, 3) to the velocity gradient (3, 3), v_j,k at [j, k]."""


@generic
def lattice_measure(geometry, position, spacing):
    """Volume of a lattice point (3,) with the given spacings (3,), in the geometry's measure (m3, or m3 per radian)."""


@generic
def conserved_axes(geometry):
    """For each axis 1.0 where total momentum is conserved without boundaries, else 0.0."""


@generic
def impact_axis(geometry):
    """Index of the coordinate along the line of flight of the scenarios: z."""


@device
def position_in_cells(geometry, position, p, axis):
    """Coordinate of particle ``p`` along an axis, counted in cells from the first node, which is a ghost."""
    return (position[p, axis] - geometry.lower[axis]) / geometry.spacing + MARGIN


@device
def exit_face(geometry, position, p):
    """The face through which particle ``p`` of ``position`` (n, 3) lies outside the grid, as 2 axis + side, or -1."""
    inverse = 1.0 / geometry.spacing
    for axis in range(3):
        last = geometry.cells[axis]
        if last > 0:
            place = (position[p, axis] - geometry.lower[axis]) * inverse
            if place < 0.0:
                return 2 * axis
            if place >= last:
                return 2 * axis + 1
    return -1


def node_count(geometry):
    """Nodes of the grid."""
    return int(np.prod(geometry.nodes))


def layer_nodes(geometry, axis, side, depth):
    """Indices of the nodes ``depth`` layers inside a face (-1: its ghosts); side 0 is the lower one.

    Ghosts of the faces of other axes belong to the layer.
    """
    index = np.arange(node_count(geometry)).reshape(tuple(geometry.nodes))
    place = MARGIN + depth if side == 0 else geometry.nodes[axis] - 1 - MARGIN - depth
    return np.ascontiguousarray(np.take(index, place, axis=axis).ravel())


def face_nodes(geometry, axis, side):
    """Indices of the nodes on a face; side 0 is the lower one."""
    return layer_nodes(geometry, axis, side, 0)


def node_positions(geometry):
    """Coordinates of all nodes, (nodes, 3)."""
    axes = [
        geometry.lower[axis]
        + geometry.spacing * (np.arange(geometry.nodes[axis]) - MARGIN * (geometry.cells[axis] > 0))
        for axis in range(AXES)
    ]
    return np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, AXES)


def grid(record, *, lower, cells, spacing):
    """A geometry from its lower corner (m), its cells along each axis (0: no extent) and their size (m)."""
    cells = np.array(cells, dtype=np.int64)
    nodes = cells + 1 + 2 * MARGIN * (cells > 0)
    return record(np.array(lower, dtype=float), float(spacing), cells, nodes)
