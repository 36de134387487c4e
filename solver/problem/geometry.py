"""Geometry: a box in space, or a body of revolution without swirl.

A particle is always a three-dimensional point with a three-dimensional stress. What differs is the meaning of the
coordinates, of the gradient that the stencil hands out, and of the measure that turns an area of lattice into volume:

==============  =====================  ============================  ==================
geometry        coordinates (1, 2, 3)  gradient G of a node           mass, force, energy
==============  =====================  ============================  ==================
``Cartesian3D``   x, y, z                (dN/dx, dN/dy, dN/dz)         whole
``Axisymmetric``  r, z, theta            (dN/dr, dN/dz, N/r)           per radian
==============  =====================  ============================  ==================

Particles never sit on the axis (r = 0), whose nodes are held by the symmetric face. Outside each face stands one layer
of ghost nodes, because wide shapes reach over it; what they receive is folded back where the face is closed
(``grid/faces.py``), and stays where it is free. The node (i, j, k), counted from the ghosts on, stands at index
(k * nodes[0] + i) * nodes[1] + j: plates lie across the third axis, and so their nodes lie together in memory.
"""

from typing import NamedTuple

import numpy as np

from solver.jit import device, generic

AXES = 3
MARGIN = 1  # layers of ghost nodes outside a face: what the widest shape reaches


class Cartesian3D(NamedTuple):
    """A grid of cubes, in coordinates x, y, z."""

    lower: np.ndarray  # (3,) m; in inner loops all arrays are tuples
    spacing: float  # m
    cells: np.ndarray  # (3,) int64, of the domain; 0 along an axis without extent
    nodes: np.ndarray  # (3,) int64, ghosts included

    def impact_axis(self):
        return 2

    def conserved_axes(self):
        return (1.0, 1.0, 1.0)

    def hoop_factor(self, first):
        return 0.0

    def dimensions(self):
        return 3

    def unpacked(self):
        return Cartesian3D(triple(self.lower), self.spacing, triple(self.cells), triple(self.nodes))

    def lattice_measure(self, position, spacing):
        return spacing[0] * spacing[1] * spacing[2]


class Axisymmetric(NamedTuple):
    """A grid of square cells in the r-z half plane, whose lower corner has r = 0; the fields are those of a box."""

    lower: np.ndarray
    spacing: float
    cells: np.ndarray
    nodes: np.ndarray

    def impact_axis(self):
        return 1

    def conserved_axes(self):
        return (0.0, 1.0, 0.0)

    def dimensions(self):
        return 2

    def unpacked(self):
        return Axisymmetric(triple(self.lower), self.spacing, triple(self.cells), triple(self.nodes))

    def hoop_factor(self, first):
        return 1.0 / first

    def lattice_measure(self, position, spacing):
        return position[0] * spacing[0] * spacing[1]


Geometry = Cartesian3D | Axisymmetric


def node_count(geometry):
    """Nodes of the grid."""
    return int(np.prod(geometry.nodes))


def grid(record, *, lower, cells, spacing):
    """A geometry from its lower corner (m), its cells along each axis (0: no extent) and their size (m)."""
    cells = np.array(cells, dtype=np.int64)
    nodes = cells + 1 + 2 * MARGIN * (cells > 0)
    return record(np.array(lower, dtype=float), float(spacing), cells, nodes)


@generic
def unpacked(geometry):
    """The geometry with tuples in place of arrays, for inner loops: tuples need no reference counts."""


@device
def triple(array):
    """The three numbers of an array as a tuple."""
    return array[0], array[1], array[2]


@generic
def dimensions(geometry):
    """Axes along which the grid has extent."""


@generic
def hoop_factor(geometry, first):
    """1 / r of particles whose first coordinate is given, 0 where no coordinate is a radius; 1/m."""


@generic
def lattice_measure(geometry, position, spacing):
    """Volume of a lattice point (3,) with the given spacings (3,), in the geometry's measure (m3, or m3 per radian)."""


@generic
def conserved_axes(geometry):
    """For each axis 1.0 where total momentum is conserved without boundaries, else 0.0."""


@generic
def impact_axis(geometry):
    """Index of the coordinate along the line of flight of the scenarios: z."""
