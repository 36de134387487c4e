"""Linear (tent) shape functions, the thesis' form: Ma (2005), section 2.1."""

from typing import NamedTuple

from solver.grid.shapes import ShapeEntry
from solver.vectors import floor, maximum, minimum

# Cells. A particle on a node would have no weight in the next one and yet pull at it: that node would have a force and
# no mass. It counts as so far beside the node.
BESIDE = 1e-12


class Linear(NamedTuple):
    """Tent functions over two nodes an axis."""

    order: int = 1

    def width(self):
        return 2

    def weights(self, place):
        first = floor(place)
        part = minimum(maximum(place - first, BESIDE), 1.0 - BESIDE)
        return first, (1.0 - part, part), (-1.0, 1.0)


SHAPE = ShapeEntry("linear", Linear, lambda _: Linear(), flat_cost=0.094e-6, box_cost=0.204e-6)
