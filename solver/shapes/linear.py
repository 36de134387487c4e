"""Linear (tent) shape functions, the thesis' form: Ma (2005), section 2.1."""

from typing import NamedTuple

from solver.jit import implements
from solver.shapes import ShapeEntry, fill_line, width

# Cells. A particle on a node would have no share in the next one and yet pull at it: that node would have a force and
# no mass. It counts as so far beside the node.
BESIDE = 1e-12


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
    part = min(max(place - base, BESIDE), 1.0 - BESIDE)
    stencil.line_weight[axis, 0] = 1.0 - part
    stencil.line_weight[axis, 1] = part
    stencil.line_slope[axis, 0] = -1.0 / spacing
    stencil.line_slope[axis, 1] = 1.0 / spacing
    return base
