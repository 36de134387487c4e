"""Shape functions along one axis; the geometry multiplies them together.

A file adds one: a parameter record under ``SHAPE`` and the two functions below for its type. Contract: weights sum to
one, slopes to zero, and the weighted node coordinates to the particle's own.
"""

from typing import NamedTuple

from solver.jit import generic


class ShapeEntry(NamedTuple):
    """What a file of this folder offers as ``SHAPE``."""

    name: str
    record: type


@generic
def width(shape):
    """Nodes that a particle touches along one axis."""


@generic
def weights(shape, place):
    """(first, weights, slopes) along one axis of particles at coordinates counted in cells.

    The index of the first node, as whole numbers among the reals; the weight of each node; its slope, per cell.
    """
