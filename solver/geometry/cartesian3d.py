"""A box in space: coordinates x, y, z."""

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
    node_strides,
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
from solver.vectors import element, line, mark, number, set_line, spread


class Cartesian3D(NamedTuple):
    """A grid of cubes."""

    lower: Any  # (3,) m; arrays, and tuples in inner loops
    spacing: float  # m
    cells: Any  # (3,) int64, of the domain
    nodes: Any  # (3,) int64, ghosts included


@implements(unpacked, Cartesian3D)
def _(geometry):
    lower, cells, nodes = geometry.lower, geometry.cells, geometry.nodes
    return Cartesian3D(
        (lower[0], lower[1], lower[2]), geometry.spacing, (cells[0], cells[1], cells[2]), (nodes[0], nodes[1], nodes[2])
    )


@implements(dimensions, Cartesian3D)
def _(geometry):
    return 3


@implements(hoop_factor, Cartesian3D)
def _(geometry, first):
    return 0.0


@implements(set_sources, Cartesian3D)
def _(geometry, lines, k, mass, momentum, force, hoop):
    none = spread(0.0)
    set_columns(lines, k, mass, momentum[0], momentum[1], momentum[2], none, none, none, none)
    set_columns(lines, PACK + k, none, none, none, none, force[0], force[3], force[5], none)
    set_columns(lines, 2 * PACK + k, none, none, none, none, force[3], force[1], force[4], none)
    set_columns(lines, 3 * PACK + k, none, none, none, none, force[5], force[4], force[2], none)


@implements(scatter, Cartesian3D)
def _(geometry, shape, k, pack, table, touched):
    weight, slope = pack.weight, pack.slope
    whole, first = line(pack.lines, k), line(pack.lines, PACK + k)
    second, third = line(pack.lines, 2 * PACK + k), line(pack.lines, 3 * PACK + k)
    plane = element(pack.first, k)
    along_first, along_second, along_third = node_strides(geometry)
    for a in range(width(shape)):
        flat = number(weight, a, k) * whole + number(slope, a, k) * first
        flat2, flat3 = number(weight, a, k) * second, number(weight, a, k) * third
        row = plane
        for b in range(width(shape)):
            valued = number(weight, WIDEST + b, k) * flat + number(slope, WIDEST + b, k) * flat2
            sloped = number(weight, WIDEST + b, k) * flat3
            for c in range(width(shape)):
                share = number(weight, 2 * WIDEST + c, k) * valued
                share = share + number(slope, 2 * WIDEST + c, k) * sloped
                node = row + c * along_third
                set_line(table, node, line(table, node) + share)
            row += along_second
        # Those along the second axis are neighbours: the blocks of the first and the last hold the ones between.
        for c in range(width(shape)):
            node = plane + c * along_third
            mark(touched, node // BLOCK)
            mark(touched, (node + (width(shape) - 1) * along_second) // BLOCK)
        plane += along_first


@implements(scatter_weighted, Cartesian3D)
def _(geometry, shape, k, pack, table):
    weight = pack.weight
    whole = line(pack.lines, k)
    plane = element(pack.first, k)
    along_first, along_second, along_third = node_strides(geometry)
    for a in range(width(shape)):
        flat = number(weight, a, k) * whole
        row = plane
        for b in range(width(shape)):
            valued = number(weight, WIDEST + b, k) * flat
            for c in range(width(shape)):
                share = number(weight, 2 * WIDEST + c, k) * valued
                node = row + c * along_third
                set_line(table, node, line(table, node) + share)
            row += along_second
        plane += along_first


@implements(gather, Cartesian3D)
def _(geometry, shape, k, pack, table, lines):
    weight, slope = pack.weight, pack.slope
    whole = first = second = third = spread(0.0)
    plane = element(pack.first, k)
    along_first, along_second, along_third = node_strides(geometry)
    for a in range(width(shape)):
        flat = flat2 = flat3 = spread(0.0)
        row = plane
        for b in range(width(shape)):
            valued = sloped = spread(0.0)
            for c in range(width(shape)):
                node = line(table, row + c * along_third)
                valued = valued + number(weight, 2 * WIDEST + c, k) * node
                sloped = sloped + number(slope, 2 * WIDEST + c, k) * node
            flat = flat + number(weight, WIDEST + b, k) * valued
            flat2 = flat2 + number(slope, WIDEST + b, k) * valued
            flat3 = flat3 + number(weight, WIDEST + b, k) * sloped
            row += along_second
        whole = whole + number(weight, a, k) * flat
        first = first + number(slope, a, k) * flat
        second = second + number(weight, a, k) * flat2
        third = third + number(weight, a, k) * flat3
        plane += along_first
    set_line(lines, k, whole)
    set_line(lines, PACK + k, first)
    set_line(lines, 2 * PACK + k, second)
    set_line(lines, 3 * PACK + k, third)


@implements(velocity_gradient, Cartesian3D)
def _(geometry, lines, k, hoop):
    first, second = columns(lines, PACK + k), columns(lines, 2 * PACK + k)
    third = columns(lines, 3 * PACK + k)
    return ((first[1], second[1], third[1]), (first[2], second[2], third[2]), (first[3], second[3], third[3]))


@implements(lattice_measure, Cartesian3D)
def _(geometry, position, spacing):
    return spacing[0] * spacing[1] * spacing[2]


@implements(conserved_axes, Cartesian3D)
def _(geometry):
    return (1.0, 1.0, 1.0)


@implements(impact_axis, Cartesian3D)
def _(geometry):
    return 2
