"""Quadratic B-splines: slopes without jumps, so that a particle that changes cells changes no force.

Steffen, Kirby and Berzins (2008), Int. J. Numer. Methods Eng. 76, 922.
"""

from typing import NamedTuple

from solver.jit import implements
from solver.shapes import ShapeEntry, fill_line, width


class QuadraticBSpline(NamedTuple):
    """Splines over three nodes an axis, the nearest one in the middle."""

    order: int = 2


SHAPE = ShapeEntry("quadratic-bspline", QuadraticBSpline)


@implements(width, QuadraticBSpline)
def _(shape):
    return 3


@implements(fill_line, QuadraticBSpline)
def _(shape, place, spacing, stencil, axis):
    nearest = int(place + 0.5)
    part = place - nearest  # -1/2 .. 1/2
    stencil.line_weight[axis, 0] = 0.5 * (0.5 - part) * (0.5 - part)
    stencil.line_weight[axis, 1] = 0.75 - part * part
    stencil.line_weight[axis, 2] = 0.5 * (0.5 + part) * (0.5 + part)
    stencil.line_slope[axis, 0] = (part - 0.5) / spacing
    stencil.line_slope[axis, 1] = -2.0 * part / spacing
    stencil.line_slope[axis, 2] = (part + 0.5) / spacing
    return nearest - 1
