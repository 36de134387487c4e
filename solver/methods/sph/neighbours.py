"""Neighbours of each particle by cells as wide as the largest support, and the correction of gradients.

The lists are made anew in each step. A list names neighbours in the order of the cells, and within a cell in that of
their places, so that it is the same for any number of threads. It is filled up to whole eights with a particle without
mass.
"""

from typing import NamedTuple

import numpy as np

from solver.jit import device, kernel
from solver.methods.sph.smoothing import SUPPORT, gradient_factor
from solver.methods.sph.tables import HEAVY, LENGTH, RHO
from solver.vectors import LANES, bare, element, line, number, spread, total, transposed

CELLS_PER_PARTICLE = 4  # at most: matter that has flown far apart gets wider cells

# Gradients of particles are corrected where their neighbours lie around them, at least so far: the determinant of the
# moments over that of the same trace without direction, and the trace over that of whole matter. At a corner of a block
# an eighth of the neighbours is there. Others keep the plain gradient.
ROUND, FULL = 0.1, 0.08


class Cells(NamedTuple):
    """Particles and images sorted into cells."""

    lower: np.ndarray  # (3,) corner of the first cell, m
    inverse: float  # of the width of a cell, 1/m
    counts: np.ndarray  # (3,) int64, along each axis
    begin: np.ndarray  # (cells + 1,) where each cell begins in what follows
    member: np.ndarray  # (m,) places in the tables
    sorted: np.ndarray  # (5, m) their coordinates, smoothing lengths and the numbers of their solids


def sort_into_cells(place, solid, count):
    """The cells of the first ``count`` rows of the table of places, without those of no smoothing length.

    ``solid`` (count,) are the numbers of the solids, whose particles take no part in each other's sums.
    """
    rows = np.flatnonzero(place[:count, LENGTH] > 0.0)
    lower, upper = place[rows, :3].min(axis=0), place[rows, :3].max(axis=0)
    width = SUPPORT * float(place[rows, LENGTH].max())
    while True:
        counts = np.floor((upper - lower) / width).astype(np.int64) + 1
        if counts.prod(dtype=np.float64) <= CELLS_PER_PARTICLE * rows.size + LANES:
            break
        width *= 1.5
    cells = Cells(
        lower,
        1.0 / width,
        counts,
        np.zeros(int(counts.prod()) + 1, np.int64),
        np.zeros(rows.size, np.int32),
        np.zeros((5, rows.size)),
    )
    fill_cells(place, solid, rows, cells)
    return cells


@device
def coordinate(cells, place, p, axis):
    """Index of a particle's cell along an axis."""
    index = int((place[p, axis] - cells.lower[axis]) * cells.inverse)
    return min(index, cells.counts[axis] - 1)


@kernel
def fill_cells(place, solid, rows, cells):
    """Sort some rows by counting; within a cell the order stays."""
    counts, begin, member, ordered = cells.counts, cells.begin, cells.member, cells.sorted
    home = np.empty(rows.size, np.int64)
    for at in range(rows.size):
        p = rows[at]
        cell = coordinate(cells, place, p, 0) * counts[1] + coordinate(cells, place, p, 1)
        home[at] = cell * counts[2] + coordinate(cells, place, p, 2)
        begin[home[at] + 1] += 1
    for cell in range(begin.size - 1):
        begin[cell + 1] += begin[cell]
    free = begin[:-1].copy()
    for at in range(rows.size):
        p = rows[at]
        k = free[home[at]]
        free[home[at]] += 1
        member[k] = p
        for axis in range(3):
            ordered[axis, k] = place[p, axis]
        ordered[3, k] = place[p, LENGTH]
        ordered[4, k] = solid[p]


@kernel
def find_neighbours(smoothing, dimensions, cells, place, solid, other, ranges, neighbours, first, stop, correction):
    """Lists of the particles in ``ranges``, and their corrections; returns -1 where ``neighbours`` is too short.

    ``first`` and ``stop`` (n,) say where a list stands. ``correction`` (n, 8) has the six components of B, the inverse
    of sum V_j (x_j - x_i) grad W with V_j = m_j / rho_i, along the axes that have extent: Bonet and Lok (1999), Eq. 35.
    """
    counts, begin = cells.counts, cells.begin
    member, ordered = bare(cells.member), bare(cells.sorted)
    empty = place.shape[0] - 1
    filled = 0
    for body in range(ranges.shape[0]):
        for i in range(ranges[body, 0], ranges[body, 1]):
            first[i] = filled
            x, y, z, own = place[i, 0], place[i, 1], place[i, 2], place[i, LENGTH]
            if own > 0.0:
                a, b = coordinate(cells, place, i, 0), coordinate(cells, place, i, 1)
                c = coordinate(cells, place, i, 2)
                for column in range(max(a - 1, 0), min(a + 2, counts[0])):
                    for row in range(max(b - 1, 0), min(b + 2, counts[1])):
                        cell = (column * counts[1] + row) * counts[2]
                        low = begin[cell + max(c - 1, 0)]
                        high = begin[cell + min(c + 2, counts[2])]
                        if filled + high - low + LANES > neighbours.size:
                            return -1
                        for k in range(low, high):
                            dx, dy = number(ordered, 0, k) - x, number(ordered, 1, k) - y
                            dz, reach = number(ordered, 2, k) - z, number(ordered, 3, k) + own
                            squared = dx * dx + dy * dy + dz * dz
                            neighbours[filled] = element(member, k)
                            is_near = (squared < reach * reach) & (squared > 0.0)
                            filled += int(is_near & (number(ordered, 4, k) == solid[i]))
                while filled % LANES:
                    neighbours[filled] = empty
                    filled += 1
            stop[i] = filled
    _correct(smoothing, dimensions, place, other, ranges, neighbours, first, stop, correction)
    return filled


@device
def rows(table, neighbours, k):
    """The eight numbers of each of the eight neighbours from k on, as eight vectors."""
    return transposed(
        line(table, element(neighbours, k)),
        line(table, element(neighbours, k + 1)),
        line(table, element(neighbours, k + 2)),
        line(table, element(neighbours, k + 3)),
        line(table, element(neighbours, k + 4)),
        line(table, element(neighbours, k + 5)),
        line(table, element(neighbours, k + 6)),
        line(table, element(neighbours, k + 7)),
    )


@device
def apart(dimensions, own, others):
    """x_i - x_j, squared distance, mean smoothing length, F of the gradient F (x_i - x_j) and q, of eight pairs.

    ``own`` is a row of the table of places, ``others`` eight of them.
    """
    dx, dy, dz = own[0] - others[0], own[1] - others[1], own[2] - others[2]
    squared = dx * dx + dy * dy + dz * dz
    length = 0.5 * (own[3] + others[3])
    force, q = gradient_factor(dimensions, squared, length)
    return (dx, dy, dz), squared, length, force, q


@device
def row(table, p):
    """The eight numbers of a row, each as a vector."""
    return (
        spread(number(table, p, 0)),
        spread(number(table, p, 1)),
        spread(number(table, p, 2)),
        spread(number(table, p, 3)),
        spread(number(table, p, 4)),
        spread(number(table, p, 5)),
        spread(number(table, p, 6)),
        spread(number(table, p, 7)),
    )


@device
def _correct(smoothing, dimensions, place, other, ranges, neighbours, first, stop, correction):
    place, neighbours = bare(place), bare(neighbours)
    for body in range(ranges.shape[0]):
        for i in range(ranges[body, 0], ranges[body, 1]):
            own = row(place, i)
            k11 = k22 = k33 = k12 = k23 = k31 = spread(0.0)
            for k in range(first[i], stop[i] if smoothing.corrected else first[i], LANES):
                near = rows(place, neighbours, k)
                d, _, _, force, _ = apart(dimensions, own, near)
                weight = near[HEAVY] * force
                k11, k22, k33 = (k11 - weight * d[0] * d[0], k22 - weight * d[1] * d[1], k33 - weight * d[2] * d[2])
                k12, k23, k31 = (k12 - weight * d[0] * d[1], k23 - weight * d[1] * d[2], k31 - weight * d[2] * d[0])
            over = 1.0 / other[i, RHO]
            s11, s22, s33 = total(k11) * over, total(k22) * over, total(k33) * over
            s12, s23, s31 = total(k12) * over, total(k23) * over, total(k31) * over
            mean = (s11 + s22 + s33) / dimensions
            if dimensions < 3:
                s33 = 1.0
            if dimensions < 2:
                s22 = 1.0
            c11, c12, c13 = s22 * s33 - s23 * s23, s23 * s31 - s12 * s33, s12 * s23 - s22 * s31
            determinant = s11 * c11 + s12 * c12 + s31 * c13
            correction[i, :] = 0.0
            if mean > FULL and determinant > ROUND * mean**dimensions:
                whole = 1.0 / determinant
                correction[i, 0], correction[i, 3], correction[i, 5] = (c11 * whole, c12 * whole, c13 * whole)
                correction[i, 1] = (s11 * s33 - s31 * s31) * whole
                correction[i, 2] = (s11 * s22 - s12 * s12) * whole
                correction[i, 4] = (s12 * s31 - s11 * s23) * whole
            else:
                # Below the density whose smoothing length it has, 1 / rho would let its gradient run away.
                part, mass = 1.0, number(place, i, HEAVY)
                if mass > 0.0:
                    volume = (number(place, i, LENGTH) / smoothing.ratio) ** dimensions
                    part = min(other[i, RHO] * volume / mass, 1.0)
                correction[i, 0] = correction[i, 1] = correction[i, 2] = part
