"""What neighbours see of a particle: rows of eight numbers, for the n particles, their images and one without mass."""

from typing import NamedTuple

import numpy as np

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
