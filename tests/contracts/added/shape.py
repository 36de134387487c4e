"""Tents over two nodes, as another distribution would add them."""

from typing import NamedTuple

from solver.grid.shapes import ShapeEntry
from solver.vectors import floor


class Tent(NamedTuple):
    """Tent functions."""

    order: int = 1

    def width(self):
        return 2

    def weights(self, place):
        first = floor(place)
        part = place - first
        return first, (1.0 - part, part), (-1.0, 1.0)


def tent(particles_per_cell):
    """The same tents for any number of particles."""
    return Tent()


SHAPE = ShapeEntry("tent", Tent, tent, flat_cost=1e-7, box_cost=2e-7)
