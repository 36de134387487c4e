"""Particles without a grid as a geometry of ``stress.update_particles``: their velocity gradients are there already."""

from typing import Any, NamedTuple

from solver.geometry import PACK, dimensions, gather, hoop_factor, unpacked, velocity_gradient
from solver.geometry.cartesian3d import Cartesian3D
from solver.jit import implements
from solver.transfer import find_nodes
from solver.vectors import LANES, element, line, set_line, spread, store_whole

AXES = 3


class Scattered(NamedTuple):
    """The box that particles stay in; the first so many axes have extent."""

    lower: Any  # (3,) m; arrays, and tuples in inner loops
    spacing: float  # m, of the problem's cells
    cells: Any  # (3,) int64
    axes: int


@implements(unpacked, Scattered)
def _(geometry):
    lower, cells = geometry.lower, geometry.cells
    return Scattered((lower[0], lower[1], lower[2]), geometry.spacing, (cells[0], cells[1], cells[2]), geometry.axes)


@implements(dimensions, Scattered)
def _(geometry):
    return geometry.axes


@implements(hoop_factor, Scattered)
def _(geometry, first):
    return 0.0


@implements(find_nodes, Scattered)
def _(geometry, shape, table, start, stop, pack):
    """No nodes: each eight remember the first of them."""
    for p in range(start, stop, LANES):
        store_whole(pack.first, p - start, spread(float(p)))


@implements(gather, Scattered)
def _(geometry, shape, k, pack, table, lines):
    """Each particle's own three lines, one for each axis."""
    own = AXES * (element(pack.first, k) + k % LANES)
    for axis in range(AXES):
        set_line(lines, (axis + 1) * PACK + k, line(table, own + axis))


implements(velocity_gradient, Scattered)(velocity_gradient.texts[Cartesian3D])  # type: ignore[attr-defined]
