"""Pieces of matter that hang together through neighbouring cells."""

from itertools import product

import numpy as np


def connected(cell: np.ndarray) -> np.ndarray:
    """Number (n,) of the connected piece of each particle, by its cell (n, 3): cells touch at corners too.

    The work grows with the number of particles, however far apart they are.
    """
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import connected_components

    if not cell.size:
        return np.zeros(0, np.int64)
    cell = cell - cell.min(axis=0) + 1
    size = cell.max(axis=0) + 2
    stride = np.array([size[1] * size[2], size[2], 1])
    occupied, of = np.unique(cell @ stride, return_inverse=True)
    pairs = []
    # Half of the neighbours: the others see the pair from their side.
    for offset in [step for step in product((-1, 0, 1), repeat=3) if step > (0, 0, 0)]:
        wanted = occupied + np.array(offset) @ stride
        place = np.searchsorted(occupied, wanted)
        found = np.flatnonzero(occupied[np.minimum(place, occupied.size - 1)] == wanted)
        pairs.append(np.stack([found, place[found]]))
    first, second = np.concatenate(pairs, axis=1)
    graph = coo_array((np.ones(first.size, bool), (first, second)), shape=(occupied.size,) * 2)
    piece: np.ndarray = connected_components(graph, directed=False)[1]
    return piece[of.ravel()].astype(np.int64)
