"""Geometry: the only module that distinguishes a box from a body of revolution.

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
where it is free. The node (i, j, k), counted from the ghosts on, stands at index (k * nodes[0] + i) * nodes[1] + j:
plates lie across the third axis, and so their nodes lie together in memory.
"""

from typing import NamedTuple

import numpy as np

from solver.jit import device, generic, implements
from solver.vectors import bare, line, set_line, transposed

AXES = 3
MARGIN = 1  # layers of ghost nodes outside a face: what the widest shape reaches


# Particles whose weights and lines are prepared together: what they need stays in the processor's first cache.
PACK = 32
WIDEST = 3  # nodes that any shape touches along an axis


class Pack(NamedTuple):
    """Scratch of a pack of particles."""

    first: np.ndarray  # (PACK,) index of the first node of each
    weight: np.ndarray  # (3 WIDEST, PACK) along each axis
    slope: np.ndarray  # (3 WIDEST, PACK) 1/m
    lines: np.ndarray  # (4 PACK, 8) to and from nodes
    smooth: np.ndarray  # (4 PACK, 8) from nodes, with damping of second order


@device
def opened(pack):
    """The scratch as bare arrays for inner loops: without reference counts."""
    return Pack(bare(pack.first), bare(pack.weight), bare(pack.slope), bare(pack.lines), bare(pack.smooth))


@generic
def unpacked(geometry):
    """The geometry with tuples in place of arrays, for inner loops: tuples need no reference counts."""


@generic
def dimensions(geometry):
    """Axes along which the grid has extent."""


@generic
def hoop_factor(geometry, first):
    """1 / r of particles whose first coordinate is given, 0 where no coordinate is a radius; 1/m."""


@generic
def own_length(geometry, p, lanes):
    """The length over which eight particles smear shocks and which signals cross in a step, m: by default a cell."""


@implements(own_length, object)
def _(geometry, p, lanes):
    return geometry.spacing


@generic
def set_sources(geometry, lines, k, mass, momentum, force, hoop):
    """Write the contributions of eight particles to their nodes, as lines of the table of ``state``.

    Row k of ``lines`` (4 PACK, 8), and the seven after it, are multiplied by the weight of a node, those PACK rows
    farther on by its slope along the first axis, and so on. ``momentum`` (3,), ``force`` minus volume times stress (6
    components), ``hoop`` times the volume's stress as the ``hoop_factor`` has it.
    """


@generic
def scatter(geometry, shape, k, pack, table, touched):
    """Add the lines of particle ``k`` of a pack to its nodes in a table, and mark the blocks that it touched."""


@generic
def scatter_weighted(geometry, shape, k, pack, table):
    """Add the first line of particle ``k`` of a pack, times the weight of each node, to its nodes in a table."""


@generic
def gather(geometry, shape, k, pack, table, lines):
    """Write sums over the nodes of particle ``k`` to ``lines``: times weights, and times slopes along each axis."""


@generic
def velocity_gradient(geometry, lines, k, hoop):
    """Velocity gradients of eight particles from their gathered lines of velocities, from row ``k`` on; 1/s.

    Three rows of three vectors, v_j,k at [j][k].
    """


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
def node_strides(geometry):
    """From a node to the next along each axis, in indices."""
    return geometry.nodes[1], 1, geometry.nodes[0] * geometry.nodes[1]


@device
def node_place(geometry, node, axis):
    """Where a node stands along an axis with extent, in cells from the lower face."""
    return node // node_strides(geometry)[axis] % geometry.nodes[axis] - MARGIN


@device
def columns(lines, row):
    """Eight lines from a row on, as eight vectors: the first numbers of all, the second ones, and so on."""
    return transposed(
        line(lines, row),
        line(lines, row + 1),
        line(lines, row + 2),
        line(lines, row + 3),
        line(lines, row + 4),
        line(lines, row + 5),
        line(lines, row + 6),
        line(lines, row + 7),
    )


@device
def set_columns(lines, row, a, b, c, d, e, f, g, h):
    """Write eight lines from a row on, given the first numbers of all, the second ones, and so on."""
    turned = transposed(a, b, c, d, e, f, g, h)
    set_line(lines, row, turned[0])
    set_line(lines, row + 1, turned[1])
    set_line(lines, row + 2, turned[2])
    set_line(lines, row + 3, turned[3])
    set_line(lines, row + 4, turned[4])
    set_line(lines, row + 5, turned[5])
    set_line(lines, row + 6, turned[6])
    set_line(lines, row + 7, turned[7])


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
    """Indices (n,) of the nodes ``depth`` layers inside a face (-1: its ghosts), ascending; side 0 is the lower one.

    Ghosts of the faces of other axes belong to the layer.
    """
    place = MARGIN + depth if side == 0 else geometry.nodes[axis] - 1 - MARGIN - depth
    strides = node_strides(geometry)
    first, second = (np.arange(geometry.nodes[other]) * strides[other] for other in range(AXES) if other != axis)
    return np.sort(np.add.outer(first, second), axis=None) + place * strides[axis]


def face_nodes(geometry, axis, side):
    """Indices of the nodes on a face; side 0 is the lower one."""
    return layer_nodes(geometry, axis, side, 0)


def node_positions(geometry):
    """Coordinates of all nodes, (nodes, 3)."""
    index = np.arange(node_count(geometry))
    place = np.stack([node_place(geometry, index, axis) for axis in range(AXES)], axis=1)
    return geometry.lower + geometry.spacing * np.where(geometry.cells > 0, place, 0)


def grid(record, *, lower, cells, spacing):
    """A geometry from its lower corner (m), its cells along each axis (0: no extent) and their size (m)."""
    cells = np.array(cells, dtype=np.int64)
    nodes = cells + 1 + 2 * MARGIN * (cells > 0)
    return record(np.array(lower, dtype=float), float(spacing), cells, nodes)
