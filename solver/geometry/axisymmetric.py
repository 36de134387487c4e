"""A body of revolution without swirl: coordinates r, z, theta; every extensive quantity is per radian.

The hoop part of the gradient is N / r at the particle, so that a velocity v_r gives the hoop rate sum(v_r N) / r and a
hoop stress pulls its nodes inwards by V sigma_theta N / r: Sulsky and Schreyer (1996), Comput. Methods Appl. Mech.
Eng. 139, 409. Particles never sit on the axis (r = 0), whose nodes are held by the symmetric face.
"""

from typing import Any, NamedTuple

from solver.geometry import (
    PACK,
    WIDEST,
    columns,
    conserved_axes,
    dimensions,
    gather,
    hoop_factor,
    impact_axis,
    lattice_measure,
    scatter,
    scatter_weighted,
    set_columns,
    set_sources,
    unpacked,
    velocity_gradient,
)
from solver.jit import implements
from solver.shapes import width
from solver.state import BLOCK
from solver.tensor import PlaneGradient
from solver.vectors import element, line, mark, number, set_line, spread


class Axisymmetric(NamedTuple):
    """A grid of square cells in the r-z half plane; the lower corner has r = 0."""

    lower: Any  # (3,) m; arrays, and tuples in inner loops
    spacing: float  # m
    cells: Any  # (3,) int64, of the domain
    nodes: Any  # (3,) int64, ghosts included


@implements(unpacked, Axisymmetric)
def _(geometry):
    lower, cells, nodes = geometry.lower, geometry.cells, geometry.nodes
    return Axisymmetric(
        (lower[0], lower[1], lower[2]), geometry.spacing, (cells[0], cells[1], cells[2]), (nodes[0], nodes[1], nodes[2])
    )


@implements(dimensions, Axisymmetric)
def _(geometry):
    return 2


@implements(hoop_factor, Axisymmetric)
def _(geometry, first):
    return 1.0 / first


@implements(set_sources, Axisymmetric)
def _(geometry, lines, k, mass, momentum, force, hoop):
    none = spread(0.0)
    set_columns(lines, k, mass, momentum[0], momentum[1], momentum[2], force[2] * hoop, none, none, none)
    set_columns(lines, PACK + k, none, none, none, none, force[0], force[3], none, none)
    set_columns(lines, 2 * PACK + k, none, none, none, none, force[3], force[1], none, none)


@implements(scatter, Axisymmetric)
def _(geometry, shape, k, pack, table, touched):
    weight, slope = pack.weight, pack.slope
    whole, along, across = (line(pack.lines, k), line(pack.lines, PACK + k), line(pack.lines, 2 * PACK + k))
    row = element(pack.first, k)
    for a in range(width(shape)):
        valued = number(weight, a, k) * whole + number(slope, a, k) * along
        sloped = number(weight, a, k) * across
        for b in range(width(shape)):
            share = number(weight, WIDEST + b, k) * valued + number(slope, WIDEST + b, k) * sloped
            set_line(table, row + b, line(table, row + b) + share)
        mark(touched, row // BLOCK)
        mark(touched, (row + width(shape) - 1) // BLOCK)
        row += geometry.nodes[1]


@implements(scatter_weighted, Axisymmetric)
def _(geometry, shape, k, pack, table):
    weight = pack.weight
    whole = line(pack.lines, k)
    row = element(pack.first, k)
    for a in range(width(shape)):
        valued = number(weight, a, k) * whole
        for b in range(width(shape)):
            share = number(weight, WIDEST + b, k) * valued
            set_line(table, row + b, line(table, row + b) + share)
        row += geometry.nodes[1]


@implements(gather, Axisymmetric)
def _(geometry, shape, k, pack, table, lines):
    weight, slope = pack.weight, pack.slope
    whole = along = across = spread(0.0)
    row = element(pack.first, k)
    for a in range(width(shape)):
        valued = sloped = spread(0.0)
        for b in range(width(shape)):
            node = line(table, row + b)
            valued = valued + number(weight, WIDEST + b, k) * node
            sloped = sloped + number(slope, WIDEST + b, k) * node
        whole = whole + number(weight, a, k) * valued
        along = along + number(slope, a, k) * valued
        across = across + number(weight, a, k) * sloped
        row += geometry.nodes[1]
    set_line(lines, k, whole)
    set_line(lines, PACK + k, along)
    set_line(lines, 2 * PACK + k, across)


@implements(velocity_gradient, Axisymmetric)
def _(geometry, lines, k, hoop):
    none = spread(0.0)
    whole, along, across = columns(lines, k), columns(lines, PACK + k), columns(lines, 2 * PACK + k)
    return PlaneGradient((along[1], across[1], none), (along[2], across[2], none), (none, none, whole[1] * hoop))


@implements(lattice_measure, Axisymmetric)
def _(geometry, position, spacing):
    return position[0] * spacing[0] * spacing[1]


@implements(conserved_axes, Axisymmetric)
def _(geometry):
    return (0.0, 1.0, 0.0)


@implements(impact_axis, Axisymmetric)
def _(geometry):
    return 1
