"""Axes of an opening: the largest and the smallest diameter of a hole or crater, and the root of their product.

The diameter in a direction is the sum of the radii of the opposite sectors. One over its square is an ellipse's
constant plus a cosine of twice the azimuth; the least-squares series with the next harmonic is read between sectors.
"""

import math
from collections.abc import Callable

import numpy as np

from studies.measurements import Measurement, Reading
from studies.measurements._crater import opening
from studies.measurements._impact import ImpactView, azimuthal_spread, equal_area_diameter
from studies.measurements._perforation import areal_edges, film_flags, flag_without_hole, rim_flags

HARMONICS = 3  # of twice the azimuth, the constant included
DIRECTIONS = 361  # at which the series is read, from the trace of the flight to across it


def _diameters(view: ImpactView, radii: np.ndarray) -> np.ndarray:
    """Diameters (DIRECTIONS,) of an opening with a radius in each sector, from along the trace to across it, m."""
    if view.sectors == 1:
        return np.full(DIRECTIONS, 2.0 * float(radii[0]))
    # A half model has the radii of opposite directions; in a quarter they are equal.
    across = radii + radii[::-1] if view.span > 0.75 * math.pi else 2.0 * radii
    angle = view.span * (np.arange(view.sectors) + 0.5) / view.sectors
    terms = 2.0 * np.arange(HARMONICS)
    # The mean of a cosine over a sector is smaller than that in its middle.
    smoothed = np.sinc(terms * view.span / view.sectors / (2.0 * math.pi))
    series, *_ = np.linalg.lstsq(np.cos(angle[:, None] * terms) * smoothed, across**-2.0, rcond=None)
    fine = np.linspace(0.0, 0.5 * math.pi, DIRECTIONS)
    diameters: np.ndarray = (np.cos(fine[:, None] * terms) @ series) ** -0.5
    return diameters


def _of_hole(view: ImpactView) -> tuple[np.ndarray | None, tuple[str, ...]]:
    """Radii (sectors,) of a hole by areal density, and its flags; None with the reason.

    The clear radius of a sector is the least in it, so that it would make an oval narrower.
    """
    radii = areal_edges(view)
    flag = flag_without_hole(view, radii)
    if flag:
        return None, (flag,)
    return radii, film_flags(view) + rim_flags(view, equal_area_diameter(radii))


Radii = Callable[[ImpactView], tuple[np.ndarray | None, tuple[str, ...]]]
OPENINGS: dict[str, tuple[str, str, Radii, int]] = {
    "hole": ("hole", "of the hole by areal density (hole_diameter_areal)", _of_hole, 1),
    "crater": ("crater", "of the crater at the original surface (crater_diameter)", opening, 4),
}
AXES: dict[str, tuple[str, str, Callable[[np.ndarray], float]]] = {
    "largest": ("Largest diameter", "largest diameter", lambda d: float(d.max())),
    "smallest": ("Smallest diameter", "smallest diameter", lambda d: float(d.min())),
    "mean_root": (
        "Mean root diameter",
        "root of the product of largest and smallest diameter",
        lambda d: math.sqrt(float(d.max() * d.min())),
    ),
}


def _axis(name: str, axis: str) -> Measurement:
    noun, where, radii_of, version = OPENINGS[name]
    title, meaning, pick = AXES[axis]

    def read(view: ImpactView) -> Reading:
        radii, flags = radii_of(view)
        if radii is None:
            return Reading(math.nan, flags=flags)
        parts = {"resolution": view.resolution, "azimuth": azimuthal_spread(radii)}
        return Reading(pick(_diameters(view, radii)), parts, flags)

    return Measurement(
        name=f"{name}_diameter_{axis}",
        title=f"{title} of the {noun}",
        unit="m",
        meaning=f"{meaning} {where}, through its middle: the sums of the radii of opposite sectors, one over their "
        "square as a constant and two cosines of the azimuth; of a body of revolution its diameter",
        version=version,
        read=read,
    )


MEASUREMENT = tuple(_axis(name, axis) for name in OPENINGS for axis in AXES)
