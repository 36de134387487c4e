"""A film as sections: its particles in the plane through the axis, frame by frame."""

import numpy as np
from scipy.spatial import cKDTree
from xarray import Dataset

from studies.sections.section import Section, Sections


def sections_of(film: Dataset) -> Sections:
    """The section of each frame, by its number; a film in three dimensions shows the layer beside y = 0.

    A film has no lattice: the spacing of a body is the median distance between neighbours in its first frame.
    """
    film = film.load()
    names = [name for name in np.unique(film.body).tolist() if name]
    body = np.array([names.index(name) if name else -1 for name in film.body.values.tolist()])
    position = film.position.values
    spacing = np.array([_spacing(position[0, body == number]) for number in range(len(names))])
    is_flat = not np.nan_to_num(position[..., 2]).any()  # r, z and an angle that is not used
    across = position[..., 0]
    with np.errstate(invalid="ignore"):
        in_plane = np.isfinite(across) & (body >= 0) & (is_flat | (np.abs(position[..., 1]) < spacing[body]))
    states = [
        Section(
            time=float(time),
            moment=number,
            position=position[number, shown][:, [0, 1 if is_flat else 2]],
            body=body[shown],
            fields={str(name): film[name].values[number, shown] for name in film if name != "position"},
        )
        for number, (time, shown) in enumerate(zip(film.time.values, in_plane, strict=True))
    ]
    mirrored = bool(np.nanmin(across[0]) >= 0.0)
    return Sections(tuple(names), np.stack([spacing, spacing], axis=1), mirrored, (), tuple(states))


def _spacing(position: np.ndarray) -> float:
    """The median distance (m) between neighbours of some particles (n, 3)."""
    known = position[np.isfinite(position[:, 0])]
    if len(known) < 2:
        return 0.0
    distance, _ = cKDTree(known).query(known, k=2)
    return float(np.median(distance[:, 1]))
