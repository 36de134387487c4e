"""Linear (tent) shape functions, the thesis' form: Ma (2005), section 2.1."""

from typing import NamedTuple

from solver.jit import implements
from solver.shapes import ShapeEntry, fill_line, width


class Linear(NamedTuple):
    """Tent functions over two nodes an axis."""

    order: int = 1


SHAPE = ShapeEntry("linear", Linear)


@implements(width, Linear)
def _(shape):
    return 2


@implements(fill_line, Linear)
def _(shape, place, spacing, stencil, axis):
    base = int(place)
    part = place - base
    stencil.line_weight[axis, 0] = 1.0 - part
    stencil.line_weight[axis, 1] = part
    stencil.line_slope[axis, 0] = -1.0 / spacing
    stencil.line_slope[axis, 1] = 1.0 / spacing
    return base
