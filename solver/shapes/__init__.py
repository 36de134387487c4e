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
def fill_line(shape, place, spacing, stencil, axis):
    """Weights and slopes (1/m) along one axis for a coordinate counted in cells; returns the first node's index."""
