"""Smoothing functions W(r, h) = s h^-d w(r / h) with the support 2 h, in d = 1 to 3 dimensions.

Another one is a record and three texts for its type, here.
"""

import math
from typing import NamedTuple

from solver.jit import device, generic, implements
from solver.vectors import maximum, sqrt, where

SUPPORT = 2.0  # smoothing lengths


class CubicSpline(NamedTuple):
    """The cubic B-spline: Monaghan and Lattanzio (1985), Astron. Astrophys. 149, 135."""

    order: int = 3


class WendlandC2(NamedTuple):
    """The function of Wendland (1995) with continuous curvature; it never clumps: Dehnen and Aly (2012).

    Mon. Not. R. Astron. Soc. 425, 1068, Table 1. It wants more neighbours than the spline.
    """

    order: int = 2


@generic
def factor(function, dimensions):
    """s, which makes the integral of W one."""


@generic
def height(function, dimensions, q):
    """w at q = r / h, 0 from 2 on."""


@generic
def slope(function, dimensions, q):
    """w' / q at q = r / h, finite at 0 and 0 from 2 on."""


@implements(factor, CubicSpline)
def factor_of_cubic_spline(function, dimensions):
    return by_dimension(dimensions, 2.0 / 3.0, 10.0 / (7.0 * math.pi), 1.0 / math.pi)


@implements(height, CubicSpline)
def height_of_cubic_spline(function, dimensions, q):
    rest = maximum(SUPPORT - q, 0.0)
    inner = 1.0 - 1.5 * q * q + 0.75 * q * q * q
    return where(q < 1.0, inner, 0.25 * rest * rest * rest)


@implements(slope, CubicSpline)
def slope_of_cubic_spline(function, dimensions, q):
    rest = maximum(SUPPORT - q, 0.0)
    return where(q < 1.0, 2.25 * q - 3.0, -0.75 * rest * rest / maximum(q, 1.0))


@implements(factor, WendlandC2)
def factor_of_wendland(function, dimensions):
    return by_dimension(dimensions, 5.0 / 8.0, 7.0 / (4.0 * math.pi), 21.0 / (16.0 * math.pi))


@implements(height, WendlandC2)
def height_of_wendland(function, dimensions, q):
    rest = maximum(1.0 - 0.5 * q, 0.0)
    cubed = rest * rest * rest
    return where(dimensions == 1, cubed * (1.0 + 1.5 * q), cubed * rest * (1.0 + 2.0 * q))


@implements(slope, WendlandC2)
def slope_of_wendland(function, dimensions, q):
    rest = maximum(1.0 - 0.5 * q, 0.0)
    squared = rest * rest
    return where(dimensions == 1, -3.0 * squared, -5.0 * squared * rest)


@device
def by_dimension(dimensions, line, plane, space):
    """The first, second or third of three values, for one to three dimensions."""
    return where(dimensions == 1, line, where(dimensions == 2, plane, space))


@device
def gradient_factor(function, dimensions, squared, length):
    """F of the gradient F (x_i - x_j) of W at particle i, and q, from the squared distance and the smoothing length."""
    inverse = 1.0 / length
    square = inverse * inverse
    q = sqrt(squared) * inverse
    scale = by_dimension(dimensions, square * inverse, square * square, square * square * inverse)
    return factor(function, dimensions) * scale * slope(function, dimensions, q), q
