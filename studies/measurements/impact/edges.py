"""Edges of matter along a line: where a density, averaged over one cell, falls to half of its undisturbed value.

The average counts each particle over its own width, so the edge moves continuously when particles do: positions are
finer than a cell, and one stray particle does not move them.
"""

import math
from collections.abc import Callable

import numpy as np

HALF = 0.5  # of the undisturbed density: an edge
SAMPLES_PER_CELL = 16  # of a profile; its crossing is interpolated between samples
# The undisturbed weight between two places, or between those of two arrays.
Nominal = Callable[[np.ndarray, np.ndarray], np.ndarray]


def edge_from_outside(
    place: np.ndarray, weight: np.ndarray, *, width: float, window: float, start: float, stop: float, nominal: Nominal
) -> float:
    """Walk from ``start`` down to ``stop`` and return where matter ends, NaN where it never does.

    ``place`` and ``weight`` (n,) are particles spread evenly over ``width``; ``nominal(a, b)`` is the undisturbed
    weight between two places. Matter ends where the weight within ``window`` falls to half of the nominal one.
    """
    samples = max(2, math.ceil((start - stop) / window * SAMPLES_PER_CELL))
    centre = np.linspace(start, stop, samples)
    share = _share_of_nominal(place, weight, width, window, centre, nominal)
    below = np.flatnonzero(share < HALF)
    if not below.size:
        return math.nan
    first = int(below[0])
    return float(start) if first == 0 else _crossing(centre, share, first)


def edge_from_inside(
    place: np.ndarray, weight: np.ndarray, *, width: float, window: float, start: float, stop: float, nominal: Nominal
) -> float:
    """Walk from ``stop`` up to ``start`` and return where matter begins; ``start`` where it never does.

    As ``edge_from_outside``, from the other end: what is empty beyond the edge does not count. NaN where matter
    stands at ``stop`` itself.
    """
    samples = max(2, math.ceil((start - stop) / window * SAMPLES_PER_CELL))
    centre = np.linspace(start, stop, samples)
    # Most edges lie in the nearer half, and most particles in the other one.
    for first in (samples // 2, 0):
        near = np.flatnonzero(place - 0.5 * width < centre[first] + 0.5 * window)
        share = _share_of_nominal(place[near], weight[near], width, window, centre[first:], nominal)
        solid = np.flatnonzero(share >= HALF)
        if solid.size:
            last = int(solid[-1])
            at_stop = last + 1 == share.size
            return math.nan if at_stop else _crossing(centre[first:], share, last + 1)
    return float(start)


def _share_of_nominal(
    place: np.ndarray, weight: np.ndarray, width: float, window: float, centre: np.ndarray, nominal: Nominal
) -> np.ndarray:
    """Weight within a window about each centre, over the undisturbed one; nothing counts below the last centre."""
    low, high = np.maximum(centre - 0.5 * window, centre[-1]), centre + 0.5 * window
    below = cumulated(place, weight, width, np.concatenate([low, high]))
    return (below[low.size :] - below[: low.size]) / nominal(low, high)


def _crossing(centre: np.ndarray, share: np.ndarray, below: int) -> float:
    """Where the share falls to half, between the sample ``below`` and the one before it."""
    part = (share[below - 1] - HALF) / (share[below - 1] - share[below])
    return float(centre[below - 1] + part * (centre[below] - centre[below - 1]))


def cumulated(place: np.ndarray, weight: np.ndarray, width: float, at: np.ndarray) -> np.ndarray:
    """Weight below each place in ``at``, particles spread evenly over their width."""
    if not place.size:
        return np.zeros_like(at)
    knots, heights = _cumulation(place, weight, width)
    return np.interp(at, knots, heights, left=0.0, right=float(weight.sum()))


def place_holding(place: np.ndarray, weight: np.ndarray, width: float, total: float) -> float:
    """The place below which a total weight lies, particles spread evenly over their width; inf where there is less."""
    if weight.sum() <= total:
        return math.inf
    knots, heights = _cumulation(place, weight, width)
    # Round-off may take a height below the one before it.
    return float(np.interp(total, np.maximum.accumulate(heights), knots))


def _cumulation(place: np.ndarray, weight: np.ndarray, width: float) -> tuple[np.ndarray, np.ndarray]:
    """Places (2 n,), ascending, at which a particle begins or ends, and the weight below each."""
    knots = np.concatenate([place - 0.5 * width, place + 0.5 * width])
    slopes = np.concatenate([weight, -weight]) / width
    order = np.argsort(knots, kind="stable")
    knots = knots[order]
    slope = np.cumsum(slopes[order])
    return knots, np.concatenate([[0.0], np.cumsum(slope[:-1] * np.diff(knots))])


def overlap(centre: np.ndarray, width: float, low: float, high: float) -> np.ndarray:
    """Share of each particle, spread evenly over ``width``, that lies between two places."""
    inside = np.minimum(centre + 0.5 * width, high) - np.maximum(centre - 0.5 * width, low)
    return np.clip(inside / width, 0.0, 1.0)
