"""Quadratic B-splines: slopes without jumps, so that a particle that changes cells changes no force.

Steffen, Kirby and Berzins (2008), Int. J. Numer. Methods Eng. 76, 922.
"""

from typing import NamedTuple

from solver.grid.shapes import ShapeEntry
from solver.vectors import floor


class QuadraticBSpline(NamedTuple):
    """Splines over three nodes an axis, the nearest one in the middle."""

    order: int = 2

    def width(self):
        return 3

    def weights(self, place):
        middle = floor(place + 0.5)
        part = place - middle  # -1/2 .. 1/2
        left, right = 0.5 - part, 0.5 + part
        return (middle - 1.0, (0.5 * left * left, 0.75 - part * part, 0.5 * right * right), (-left, -2.0 * part, right))


SHAPE = ShapeEntry(
    "quadratic-bspline", QuadraticBSpline, lambda _: QuadraticBSpline(), flat_cost=0.106e-6, box_cost=0.237e-6
)
