"""The smoothing function W(r, h) = s h^-d w(r / h) with the support 2 h, in d = 1 to 3 dimensions.

The cubic B-spline: Monaghan and Lattanzio (1985), Astron. Astrophys. 149, 135.
"""

import math

from solver.jit import device
from solver.vectors import maximum, sqrt, where

SUPPORT = 2.0  # smoothing lengths


@device
def factor(dimensions):
    """s, which makes the integral of W one."""
    return by_dimension(dimensions, 2.0 / 3.0, 10.0 / (7.0 * math.pi), 1.0 / math.pi)


@device
def height(q):
    """w at q = r / h, 0 from 2 on."""
    rest = maximum(SUPPORT - q, 0.0)
    inner = 1.0 - 1.5 * q * q + 0.75 * q * q * q
    return where(q < 1.0, inner, 0.25 * rest * rest * rest)


@device
def slope(q):
    """w' / q at q = r / h, finite at 0 and 0 from 2 on."""
    rest = maximum(SUPPORT - q, 0.0)
    return where(q < 1.0, 2.25 * q - 3.0, -0.75 * rest * rest / maximum(q, 1.0))


@device
def by_dimension(dimensions, line, plane, space):
    """The first, second or third of three values, for one to three dimensions."""
    return where(dimensions == 1, line, where(dimensions == 2, plane, space))


@device
def gradient_factor(dimensions, squared, length):
    """F of the gradient F (x_i - x_j) of W at particle i, and q, from the squared distance and the smoothing length."""
    inverse = 1.0 / length
    square = inverse * inverse
    q = sqrt(squared) * inverse
    scale = by_dimension(dimensions, square * inverse, square * square, square * square * inverse)
    return factor(dimensions) * scale * slope(q), q
