"""Where the middle of the hole of an oblique shot is: on the plane of symmetry, not at the first touch."""

import numpy as np

OPEN = 0.5  # of the nominal areal density, below which a cell is open: the edge of a hole


def centre_of_hole(
    plane: np.ndarray, mass: np.ndarray, *, areal_density: float, radius: float, cell: float
) -> np.ndarray:
    """Centroid (2,) of the largest opening in a half model (m); the origin where there is none within the rim.

    ``plane`` (n, 2) and ``mass`` (n,) are the connected plate, square with half width ``radius``, above y = 0.
    """
    count = int(radius / cell + 1e-9)  # whole cells, whatever the round-off
    edges = cell * np.arange(-count, count + 1)
    found, _, _ = np.histogram2d(
        plane[:, 0], plane[:, 1], bins=(edges, edges[count:]), weights=mass
    )
    from scipy import ndimage

    label, _ = ndimage.label(found < OPEN * areal_density * cell**2)
    size = np.bincount(label.ravel())
    size[0] = 0
    size[np.concatenate([label[0], label[-1], label[:, -1]])] = 0  # open to the rim
    if not size.any():
        return np.zeros(2)
    column = np.nonzero(label == np.argmax(size))[0]
    return np.array([edges[0] + cell * (column.mean() + 0.5), 0.0])
