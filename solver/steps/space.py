"""The space of material points, as the stress update sees it: where their velocity gradients come from.

Of particles on a grid these are sums over their nodes, for which a pack of them has scratch. Particles without a grid
and integration points of elements have them as lines of a table already (``Gridless``).
"""

from typing import NamedTuple

import numpy as np

from solver.jit import device, generic, implements, overridable
from solver.matter.tensor import PlaneGradient
from solver.problem.geometry import AXES, Axisymmetric, triple
from solver.state import S11, S12, S22, S23, S31, S33, lines
from solver.vectors import LANES, bare, element, line, load, set_line, spread, store_whole, transposed, where

# Particles whose weights and lines are prepared together: what they need stays in the processor's first cache.
PACK = 32
VELOCITY = 1  # column of a line of velocities, to and from nodes, where the velocity begins
WIDEST = 3  # nodes that any shape touches along an axis


class Pack(NamedTuple):
    """Scratch of a pack of particles."""

    first: np.ndarray  # (PACK,) index of the first node of each
    weight: np.ndarray  # (3 WIDEST, PACK) along each axis
    slope: np.ndarray  # (3 WIDEST, PACK) 1/m
    lines: np.ndarray  # (4 PACK, 8) to and from nodes
    smooth: np.ndarray  # (4 PACK, 8) from nodes, with damping of second order


def new_pack():
    """Scratch for one pack after another."""
    return Pack(
        np.zeros(PACK, np.int64),
        np.zeros((3 * WIDEST, PACK)),
        np.zeros((3 * WIDEST, PACK)),
        lines(4 * PACK),
        lines(4 * PACK),
    )


@device
def opened(pack):
    """The scratch as bare arrays for inner loops: without reference counts."""
    return Pack(bare(pack.first), bare(pack.weight), bare(pack.slope), bare(pack.lines), bare(pack.smooth))


@generic
def find_nodes(geometry, shape, table, start, stop, pack):
    """First node, weights and slopes of the particles start..stop of a table, eight at a time."""


@generic
def gather(geometry, shape, k, pack, table, lines):
    """Write sums over the nodes of particle ``k`` to ``lines``: times weights, and times slopes along each axis."""


@overridable
def velocity_gradient(geometry, lines, k, hoop):
    """Velocity gradients of eight particles from their gathered lines of velocities, from row ``k`` on; 1/s.

    Three rows of three vectors, v_j,k at [j][k].
    By default, as of a box.
    """
    first, second = columns(lines, PACK + k), columns(lines, 2 * PACK + k)
    third = columns(lines, 3 * PACK + k)
    return ((first[1], second[1], third[1]), (first[2], second[2], third[2]), (first[3], second[3], third[3]))


@implements(velocity_gradient, Axisymmetric)
def velocity_gradient_of_axisymmetric(geometry, lines, k, hoop):
    none = spread(0.0)
    whole, along, across = columns(lines, k), columns(lines, PACK + k), columns(lines, 2 * PACK + k)
    return PlaneGradient((along[1], across[1], none), (along[2], across[2], none), (none, none, whole[1] * hoop))


@overridable
def own_length(geometry, p, lanes):
    """The length over which eight particles smear shocks and which signals cross in a step, m: by default a cell."""
    return geometry.spacing


@device
def deviator_of(table, p):
    """The six components of the deviator of a point of a table, Pa."""
    return (table[S11, p], table[S22, p], table[S33, p], table[S12, p], table[S23, p], table[S31, p])


@device
def deviators_of(table, p, lanes):
    """The deviators of eight points of a table, six components in Pa."""
    return (
        load(table, S11, p, lanes),
        load(table, S22, p, lanes),
        load(table, S33, p, lanes),
        load(table, S12, p, lanes),
        load(table, S23, p, lanes),
        load(table, S31, p, lanes),
    )


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


class Gridless(NamedTuple):
    """The box of points that have their velocity gradients as lines of a table: particles, or points of elements."""

    lower: np.ndarray  # (3,) m; in inner loops all arrays are tuples
    spacing: float  # m, of the problem's cells
    cells: np.ndarray  # (3,) int64
    axes: int  # so many axes, from the first on, have extent
    lengths: np.ndarray  # (1, n) m, of the element of each point; 0: that of a cell

    def hoop_factor(self, first):
        return 0.0

    def dimensions(self):
        return self.axes

    def unpacked(self):
        return Gridless(triple(self.lower), self.spacing, triple(self.cells), self.axes, bare(self.lengths))

    def own_length(self, p, lanes):
        length = load(self.lengths, 0, p, lanes)
        return where(length > 0.0, length, self.spacing)

    def find_nodes(self, shape, table, start, stop, pack):
        # No nodes: each eight remember the first of them.
        for p in range(start, stop, LANES):
            store_whole(pack.first, p - start, spread(float(p)))

    def gather(self, shape, k, pack, table, lines):
        # Each point's own three lines, one for each axis.
        own = AXES * (element(pack.first, k) + k % LANES)
        for axis in range(AXES):
            set_line(lines, (axis + 1) * PACK + k, line(table, own + axis))
