"""Integration points as a geometry of ``stress.update_particles``: each has its own velocity gradient and length."""

from typing import Any, NamedTuple

from solver.geometry import dimensions, gather, hoop_factor, own_length, unpacked, velocity_gradient
from solver.jit import implements
from solver.scattered import AXES, Scattered
from solver.transfer import find_nodes
from solver.vectors import bare, load, where


class Points(NamedTuple):
    """The box of the problem, and the length of the element of each point."""

    lower: Any  # (3,) m; arrays, and tuples in inner loops
    spacing: float  # m, of the problem's cells
    cells: Any  # (3,) int64
    lengths: Any  # (1, n) m


@implements(unpacked, Points)
def _(geometry):
    lower, cells = geometry.lower, geometry.cells
    return Points(
        (lower[0], lower[1], lower[2]), geometry.spacing, (cells[0], cells[1], cells[2]), bare(geometry.lengths)
    )


@implements(dimensions, Points)
def _(geometry):
    return AXES


@implements(own_length, Points)
def _(geometry, p, lanes):
    length = load(geometry.lengths, 0, p, lanes)
    return where(length > 0.0, length, geometry.spacing)


_AS_SCATTERED: tuple[Any, ...] = (hoop_factor, find_nodes, gather, velocity_gradient)
for _function in _AS_SCATTERED:
    implements(_function, Points)(_function.texts[Scattered])
