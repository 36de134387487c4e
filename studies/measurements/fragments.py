"""Pieces of what came off behind a plate, as the grid joins particles: the mesh decides, so three grids are asked."""

import math
from collections.abc import Callable

import numpy as np

from studies.measurements import Measurement, Reading
from studies.measurements._cloud import NOTHING_BEHIND, CloudView, flags


def _pieces(view: CloudView) -> tuple[np.ndarray, np.ndarray]:
    """Mass (k,) of each piece behind the plate and how many of it the whole body has."""
    behind = view.behind() & ~view.plate
    _, first, piece = np.unique(view.fragment[behind], return_index=True, return_inverse=True)
    copies = view.copies[behind][first]
    return np.bincount(piece.ravel(), view.mass[behind]) / copies, copies


def _count(view: CloudView) -> Reading:
    _, copies = _pieces(view)
    return Reading(float(copies.sum()), flags=flags(view))


def _largest(view: CloudView) -> Reading:
    masses, _ = _pieces(view)
    if not masses.size:
        return Reading(math.nan, flags=(NOTHING_BEHIND,))
    return Reading(float(masses.max()), flags=flags(view))


def _fragments(name: str, title: str, unit: str, meaning: str, read: Callable[[CloudView], Reading]) -> Measurement:
    return Measurement(
        name=name,
        title=title,
        unit=unit,
        meaning=f"{meaning}: two particles belong together where their cells are the same or neighbours; rings in a "
        "body of revolution; mesh determined unless three grids are there, "
        "not separated where more than 1 % of the mass behind the plate is still connected to its rim and flies faster "
        "than a tenth of the impact speed",
        version=1,
        read=read,
        mesh_determined=True,
    )


MEASUREMENT = (
    _fragments(
        "fragments", "Fragments", "1", "number of connected pieces of matter behind the plate that came off", _count
    ),
    _fragments(
        "largest_fragment",
        "Largest fragment",
        "kg",
        "mass of the heaviest connected piece of matter behind the plate that came off",
        _largest,
    ),
)
