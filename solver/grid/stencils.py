"""The way from the lines of a particle to its nodes and back, in a box and in a body of revolution.

A body of revolution has the hoop part of the gradient too, N / r at the particle, so that a velocity v_r gives the hoop
rate sum(v_r N) / r and a hoop stress pulls its nodes inwards by V sigma_theta N / r: Sulsky and Schreyer (1996),
Comput. Methods Appl. Mech. Eng. 139, 409.
"""

from solver.grid.nodes import BLOCK, node_strides
from solver.grid.shapes import width
from solver.jit import generic, implements
from solver.problem.geometry import Axisymmetric, Cartesian3D
from solver.steps.space import PACK, WIDEST, gather, set_columns
from solver.vectors import element, line, mark, number, set_line, spread


@generic
def set_sources(geometry, lines, k, mass, momentum, force, hoop):
    """Write the contributions of eight particles to their nodes, as lines of the table of ``state``.

    Row k of ``lines`` (4 PACK, 8), and the seven after it, are multiplied by the weight of a node, those PACK rows
    farther on by its slope along the first axis, and so on. ``momentum`` (3,), ``force`` minus volume times stress (6
    components), ``hoop`` times the volume's stress as the ``hoop_factor`` has it.
    """


@implements(set_sources, Cartesian3D)
def set_sources_of_box(geometry, lines, k, mass, momentum, force, hoop):
    none = spread(0.0)
    set_columns(lines, k, mass, momentum[0], momentum[1], momentum[2], none, none, none, none)
    set_columns(lines, PACK + k, none, none, none, none, force[0], force[3], force[5], none)
    set_columns(lines, 2 * PACK + k, none, none, none, none, force[3], force[1], force[4], none)
    set_columns(lines, 3 * PACK + k, none, none, none, none, force[5], force[4], force[2], none)


@implements(set_sources, Axisymmetric)
def set_sources_of_axisymmetric(geometry, lines, k, mass, momentum, force, hoop):
    none = spread(0.0)
    set_columns(lines, k, mass, momentum[0], momentum[1], momentum[2], force[2] * hoop, none, none, none)
    set_columns(lines, PACK + k, none, none, none, none, force[0], force[3], none, none)
    set_columns(lines, 2 * PACK + k, none, none, none, none, force[3], force[1], none, none)


@generic
def scatter(geometry, shape, k, pack, table, touched):
    """Add the lines of particle ``k`` of a pack to its nodes in a table, and mark the blocks that it touched."""


@implements(scatter, Cartesian3D)
def scatter_of_box(geometry, shape, k, pack, table, touched):
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
                given = number(weight, 2 * WIDEST + c, k) * valued
                given = given + number(slope, 2 * WIDEST + c, k) * sloped
                node = row + c * along_third
                set_line(table, node, line(table, node) + given)
            row += along_second
        # Those along the second axis are neighbours: the blocks of the first and the last hold the ones between.
        for c in range(width(shape)):
            node = plane + c * along_third
            mark(touched, node // BLOCK)
            mark(touched, (node + (width(shape) - 1) * along_second) // BLOCK)
        plane += along_first


@implements(scatter, Axisymmetric)
def scatter_of_axisymmetric(geometry, shape, k, pack, table, touched):
    weight, slope = pack.weight, pack.slope
    whole, along, across = (line(pack.lines, k), line(pack.lines, PACK + k), line(pack.lines, 2 * PACK + k))
    row = element(pack.first, k)
    for a in range(width(shape)):
        valued = number(weight, a, k) * whole + number(slope, a, k) * along
        sloped = number(weight, a, k) * across
        for b in range(width(shape)):
            given = number(weight, WIDEST + b, k) * valued + number(slope, WIDEST + b, k) * sloped
            set_line(table, row + b, line(table, row + b) + given)
        mark(touched, row // BLOCK)
        mark(touched, (row + width(shape) - 1) // BLOCK)
        row += geometry.nodes[1]


@generic
def scatter_weighted(geometry, shape, k, pack, table):
    """Add the first line of particle ``k`` of a pack, times the weight of each node, to its nodes in a table."""


@implements(scatter_weighted, Cartesian3D)
def scatter_weighted_of_box(geometry, shape, k, pack, table):
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
                given = number(weight, 2 * WIDEST + c, k) * valued
                node = row + c * along_third
                set_line(table, node, line(table, node) + given)
            row += along_second
        plane += along_first


@implements(scatter_weighted, Axisymmetric)
def scatter_weighted_of_axisymmetric(geometry, shape, k, pack, table):
    weight = pack.weight
    whole = line(pack.lines, k)
    row = element(pack.first, k)
    for a in range(width(shape)):
        valued = number(weight, a, k) * whole
        for b in range(width(shape)):
            given = number(weight, WIDEST + b, k) * valued
            set_line(table, row + b, line(table, row + b) + given)
        row += geometry.nodes[1]


@implements(gather, Cartesian3D)
def gather_of_box(geometry, shape, k, pack, table, lines):
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


@implements(gather, Axisymmetric)
def gather_of_axisymmetric(geometry, shape, k, pack, table, lines):
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
