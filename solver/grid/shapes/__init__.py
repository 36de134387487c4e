"""Shape functions along one axis; the geometry multiplies them together.

A file adds one: a parameter record under ``SHAPE`` with the two functions below as methods. A sweep chooses it by name
in ``shape``. Contract: weights sum to one, slopes to zero, and the weighted node coordinates to the particle's own.
"""

from collections.abc import Callable
from typing import NamedTuple

from solver.jit import Record, generic


class ShapeEntry(NamedTuple):
    """Entry that a file of this folder offers as ``SHAPE``."""

    name: str  # as ``shape`` in a sweep names it
    record: type
    make: Callable[[int], Record]  # the record for so many particles per cell along each direction
    flat_cost: float  # s per particle-step in axisymmetry, for estimates
    box_cost: float  # s per particle-step in three dimensions

    # Costs are processor time on one core of the problems of ``make bench``, copper with Johnson-Cook, 2026-11-22. A
    # particle in three dimensions reaches 27 nodes with a wide shape, 8 with a linear one.


@generic
def width(shape):
    """Nodes that a particle touches along one axis."""


@generic
def weights(shape, place):
    """(first, weights, slopes) along one axis of particles at coordinates counted in cells.

    The index of the first node, as whole numbers among the reals; the weight of each node; its slope, per cell.
    """
