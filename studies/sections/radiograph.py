"""A synthetic radiograph: the areal density of all matter, seen from the side, right-angled to the line of flight.

The picture is symmetric about the axis, so that one half of it is kept, in square pixels. A particle of a body of
revolution is a ring: of its mass the share (asin(y2 / r) - asin(y1 / r)) 2 / pi lies between the distances y1 and y2
from the axis, on both sides. Particles are spread over their initial width, by points in it; rings that stretched
matter has moved apart, over the distance to their neighbours, so that they draw no stripes.
"""

import math
from dataclasses import dataclass
from statistics import NormalDist

import numpy as np
from scipy.spatial import cKDTree

from solver.grid.debris import flown
from solver.problem import Problem
from solver.problem.geometry import impact_axis
from solver.state import Snapshot

AREAL_DENSITY = "areal_density"  # the field of a picture that is a radiograph
PIXELS = 24.0  # across the projectile
NEIGHBOURS = 8  # nearest rings, over whose distance a ring is spread
LATTICE = 2.0  # distance of these in whole matter, in widths of a particle
WIDEST = 20.0  # pixels over which a ring is spread
SCATTERED, MOST_SCATTERED = (8, 96), 200_000  # points of a ring that is spread, and of all together
GOLDEN = 0.6180339887498949  # fills an interval evenly


@dataclass(frozen=True)
class Radiograph:
    """Areal density on one side of the axis."""

    density: np.ndarray  # (rows along the flight, columns away from the axis) kg/m2
    origin: float  # where the first row begins, along the flight, m
    pixel: float  # m


def radiograph(problem: Problem, snapshot: Snapshot, *, pixel: float, whole: float) -> Radiograph:
    """The radiograph of a state with what departed; pixels cover the grid, ``whole`` is whole bodies over the model."""
    geometry, axis = problem.geometry, impact_axis(problem.geometry)
    particles, departed = snapshot.particles, snapshot.departed
    living = particles.alive == 1
    place = np.concatenate([particles.position[living], flown(problem, departed, snapshot.time)])
    mass = whole * np.concatenate([particles.mass[living], departed.mass])
    width = max(float(body.spacing[axis]) for body in problem.bodies)
    extent = geometry.cells * geometry.spacing
    across = 0 if axis == 1 else 1
    shape = tuple(math.ceil(extent[k] / pixel - 1e-9) for k in (axis, across))
    origin = float(geometry.lower[axis])
    apart = _apart(place, width, pixel) if axis == 1 else np.zeros(mass.size)
    points, loose = _within(width, pixel), apart > 0.0
    total = np.zeros(shape)

    def rows_of(along: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        row = np.floor((along - origin) / pixel).astype(np.int64)
        inside = (row >= 0) & (row < shape[0])
        return row[inside], inside

    for along in points:
        row, inside = rows_of(place[~loose, axis] + along)
        of_row, share = place[~loose][inside], mass[~loose][inside] / points.size
        if axis == 1:
            _add_rings(total, row, of_row[:, 0], share, pixel)
        else:
            _add_points(total, row, of_row[:, 1], share, pixel, points)
    offsets = _scattered(int(np.clip(MOST_SCATTERED / max(1, loose.sum()), *SCATTERED)))
    ends = (origin, origin + shape[0] * pixel), (0.0, shape[1] * pixel)
    for along, beside in offsets:
        row, inside = rows_of(_within_ends(place[loose, 1], along * apart[loose], *ends[0]))
        radius = _within_ends(place[loose, 0], beside * apart[loose], *ends[1])[inside]
        _add_rings(total, row, radius, mass[loose][inside] / len(offsets), pixel)
    return Radiograph(0.5 * total / pixel**2, origin, pixel)


def _apart(place: np.ndarray, width: float, pixel: float) -> np.ndarray:
    """How far rings (n, 2) lie from their neighbours, m; 0 of those that are as near as particles are wide."""
    count = min(NEIGHBOURS + 1, len(place))  # each is its own nearest
    if count < 2:
        return np.zeros(len(place))
    distance = cKDTree(place).query(place, k=count)[0][:, -1]
    # Of a lattice the nearest eight are within a diagonal.
    return np.where(distance > LATTICE * width, np.minimum(distance, WIDEST * pixel), 0.0)


def _within_ends(place: np.ndarray, offset: np.ndarray, low: float, high: float) -> np.ndarray:
    """Places with their offsets, reflected where these lead out of the picture."""
    is_out = (place + offset < low) | (place + offset >= high)
    moved: np.ndarray = np.where(is_out, place - offset, place + offset)
    return np.where((place >= low) & (place < high), np.clip(moved, low, np.nextafter(high, low)), moved)


def _scattered(count: int) -> list[tuple[float, float]]:
    """Points of a normal distribution in two directions, whose deviation is a half."""
    shares = ((place + 0.5) / count for place in range(count))
    normal = NormalDist(sigma=0.5).inv_cdf
    return [(normal(share), normal(share * count * GOLDEN % 1.0)) for share in shares]


def _within(width: float, pixel: float) -> np.ndarray:
    """Offsets (k,) of evenly spaced points in a width, at least two in a pixel."""
    count = max(2, math.ceil(2.0 * width / pixel))
    offsets: np.ndarray = ((np.arange(count) + 0.5) / count - 0.5) * width
    return offsets


def _add_rings(total: np.ndarray, row: np.ndarray, radius: np.ndarray, mass: np.ndarray, pixel: float) -> None:
    """Add rings to the mass of each pixel, of both sides."""
    below = np.zeros(radius.size)
    for column in range(total.shape[1]):
        edge = np.clip((column + 1) * pixel / np.maximum(radius, 1e-300), 0.0, 1.0)
        inside = 2.0 / math.pi * np.arcsin(edge)
        total[:, column] += np.bincount(row, mass * (inside - below), minlength=total.shape[0])
        below = inside


def _add_points(
    total: np.ndarray, row: np.ndarray, across: np.ndarray, mass: np.ndarray, pixel: float, points: np.ndarray
) -> None:
    """Add points to the mass of each pixel, of both sides; what lies beyond the axis is mirrored."""
    for offset in points:
        column = np.floor(np.abs(across + offset) / pixel).astype(np.int64)
        inside = column < total.shape[1]
        place = row[inside] * total.shape[1] + column[inside]
        added = np.bincount(place, mass[inside] / points.size, minlength=total.size)
        total += added.reshape(total.shape)
