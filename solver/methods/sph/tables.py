"""What neighbours see of a particle: rows of eight numbers, for the n particles, their images and one without mass.

Behind a face with the reflection R the velocity of an image is M v, with M = R at a symmetric face and M = -1 at a
fixed one. Its T = sigma B / rho^2 is M T R: then the forces between particles and images are the adjoint of the
gradients too (``rates``), and in the sum over a pair and its mirror image the energy is kept.
"""

from typing import NamedTuple

import numpy as np

from solver.problem import Face
from solver.state import lines

# Columns of ``place``: coordinates, smoothing length (m), mass (kg), velocity at n (m/s).
LENGTH, HEAVY, SPEED = 3, 4, 5
# Columns of ``stress``: T = sigma B / rho^2 row by row but for its last component, which is the first of ``other``.
# Then sound speed, density, velocity at n+1, and 1 for an image.
T33, SOUND, RHO, MOVED, IMAGE = 0, 1, 2, 4, 7


class Tables(NamedTuple):
    """Rows of eight numbers; the last one is a particle without mass."""

    place: np.ndarray  # (n + images + 1, 8)
    stress: np.ndarray  # (n + images + 1, 8)
    other: np.ndarray  # (n + images + 1, 8)
    # Artificial stress: its components 11, 22, 33, 12, 23, 31; without rows where there is none.
    tensile: np.ndarray


def tables_of(memory, count):
    """Tables of ``count`` rows and the one without mass, in memory of at least as many rows."""
    tables = Tables(*(table[: count + 1] for table in memory))
    for table in tables:
        table[count:] = 0.0
    tables.place[count, LENGTH] = tables.place[0, LENGTH]
    tables.other[count, RHO] = 1.0
    return tables


def new_memory(rows, tensile=False):
    """Memory for so many rows of each table; those of the artificial stress where there is one."""
    return Tables(lines(rows), lines(rows), lines(rows), lines(rows if tensile else 0))


class Images(NamedTuple):
    """The g images of particles."""

    source: np.ndarray  # (g,) the particle of each
    position: np.ndarray  # (g, 3) m
    turned: np.ndarray  # (g, 3) diagonal of R, of all faces that it was mirrored at
    moved: np.ndarray  # (g, 3) diagonal of M


def images_of(problem, axes, position, length):
    """Images of particles at ``position`` (n, 3) with smoothing lengths (n,) at the closed faces of a problem.

    An image is mirrored at the faces of the axes that follow, so that edges and corners are full.
    """
    none = np.zeros(0, np.int64)
    found = Images(none, np.zeros((0, 3)), np.zeros((0, 3)), np.zeros((0, 3)))
    geometry = problem.geometry
    farthest = float(length.max(initial=0.0))
    for axis in range(axes):
        more = []
        for side, face in enumerate(problem.faces[axis]):
            if face == Face.FREE:
                continue
            wall = geometry.lower[axis] + side * geometry.cells[axis] * geometry.spacing
            near = np.flatnonzero((np.abs(position[:, axis] - wall) < length + farthest) & (length > 0.0))
            if face == Face.FIXED:
                near = near[problem.clamp.holds(position[near], axis)]
            ones = np.ones((near.size, 3))
            again = np.flatnonzero(np.abs(found.position[:, axis] - wall) < length[found.source] + farthest)
            if face == Face.FIXED:
                again = again[problem.clamp.holds(found.position[again], axis)]
            source = np.concatenate([near, found.source[again]])
            place = np.concatenate([position[near], found.position[again]])
            turned = np.concatenate([ones, found.turned[again]])
            moved = np.concatenate([ones, found.moved[again]])
            place[:, axis] = 2.0 * wall - place[:, axis]
            turned[:, axis] *= -1.0
            if face == Face.FIXED:
                moved *= -1.0
            else:
                moved[:, axis] *= -1.0
            more.append(Images(source, place, turned, moved))
        found = Images(*map(np.concatenate, zip(found, *more, strict=True)))
    return found


def set_places(tables: Tables, images: Images, count: int) -> None:
    """Rows of the images, behind those of ``count`` particles, before the forces."""
    rows = slice(count, count + images.source.size)
    place, other = tables.place[images.source], tables.other[images.source]
    place[:, :LENGTH] = images.position
    place[:, SPEED:] *= images.moved
    other[:, IMAGE] = 1.0
    tables.place[rows], tables.other[rows] = place, other


def set_stresses(tables: Tables, images: Images, count: int) -> None:
    """Stress of the images: M T R."""
    rows = slice(count, count + images.source.size)
    sign = (images.moved[:, :, None] * images.turned[:, None, :]).reshape(-1, 9)
    tables.stress[rows] = tables.stress[images.source] * sign[:, :8]
    tables.other[rows, T33] = tables.other[images.source, T33] * sign[:, 8]
    if tables.tensile.size:
        # The artificial stress, which is symmetric, is mirrored as matter is.
        turned = images.turned
        sign = turned[:, [0, 1, 2, 0, 1, 2]] * turned[:, [0, 1, 2, 1, 2, 0]]
        tables.tensile[rows, :6] = tables.tensile[images.source, :6] * sign


def set_velocities(tables: Tables, images: Images, count: int) -> None:
    """Velocities of the images after the forces."""
    rows = slice(count, count + images.source.size)
    moved = tables.other[images.source, MOVED : MOVED + 3]
    tables.other[rows, MOVED : MOVED + 3] = moved * images.moved
