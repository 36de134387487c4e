"""Uniform generalised interpolation: tent functions averaged over the initial width of a particle.

Bardenhagen and Kober (2004), Comput. Model. Eng. Sci. 5, 477. The width stays that of the undeformed particle, along
the axes; it is part of the shape, because all bodies of a problem are sampled alike.
"""

from typing import NamedTuple

from solver.grid.shapes import ShapeEntry
from solver.jit import device
from solver.units import Dimensionless
from solver.vectors import absolute, floor, maximum, minimum


class Gimp(NamedTuple):
    """Tents convolved with a box of twice ``half`` cells, over three nodes an axis."""

    half: Dimensionless = 0.25  # of a particle's width, in cells, at most 1/2

    def width(self):
        return 3

    def weights(self, place):
        first = floor(place - self.half)
        left = place - first - self.half
        w0, s0 = _node(self, left)
        w1, s1 = _node(self, left - 1.0)
        w2, s2 = _node(self, left - 2.0)
        return first, (w0, w1, w2), (s0, s1, s2)


def gimp(particles_per_cell):
    """Boxes that fill a cell side by side."""
    return Gimp(half=0.5 / particles_per_cell)


SHAPE = ShapeEntry("gimp", Gimp, gimp, flat_cost=0.122e-6, box_cost=0.269e-6)


@device
def _area(x):
    """Integral of the tent over -1..1 from its left foot to x."""
    inside = minimum(maximum(x, -1.0), 1.0)
    return 0.5 + inside - 0.5 * inside * absolute(inside)


@device
def _tent(x):
    return 1.0 - minimum(absolute(x), 1.0)


@device
def _node(shape, left):
    """Weight and slope of a node that lies ``left`` cells, rightwards, of a particle's left end."""
    right = left + 2.0 * shape.half
    inverse = 0.5 / shape.half
    return (_area(right) - _area(left)) * inverse, (_tent(right) - _tent(left)) * inverse
