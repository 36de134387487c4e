"""Uniform generalised interpolation: tent functions averaged over the initial width of a particle.

Bardenhagen and Kober (2004), Comput. Model. Eng. Sci. 5, 477. The width stays that of the undeformed particle, along
the axes; it is part of the shape, because all bodies of a problem are sampled alike.
"""

from typing import NamedTuple

from solver.jit import device, implements
from solver.shapes import ShapeEntry, fill_line, width


class Gimp(NamedTuple):
    """Tents convolved with a box of twice ``half`` cells, over three nodes an axis."""

    half: float = (
        0.25  # of a particle's width, in cells, at most 1/2; 1/4 is two particles per cell
    )


SHAPE = ShapeEntry("gimp", Gimp)


@implements(width, Gimp)
def _(shape):
    return 3


@device
def _area(x):
    """Integral of the tent over -1..1 from its left foot to x."""
    inside = min(max(x, -1.0), 1.0)
    return 0.5 + inside - 0.5 * inside * abs(inside)


@device
def _tent(x):
    return 1.0 - min(abs(x), 1.0)


@implements(fill_line, Gimp)
def _(shape, place, spacing, stencil, axis):
    first = int(place - shape.half)
    for k in range(3):
        left = place - (first + k) - shape.half
        right = left + 2.0 * shape.half
        stencil.line_weight[axis, k] = (_area(right) - _area(left)) / (2.0 * shape.half)
        stencil.line_slope[axis, k] = (_tent(right) - _tent(left)) / (2.0 * shape.half * spacing)
    return first
