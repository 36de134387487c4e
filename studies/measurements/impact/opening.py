"""An opening, hole or crater, by its radii in equal sectors of azimuth: its size, scatter and axes."""

import math
from collections.abc import Callable

import numpy as np

from studies.measurements import Measurement, Reading
from studies.measurements.impact.edges import edge_from_outside
from studies.measurements.impact.view import ImpactView


def equal_area_diameter(radii: np.ndarray) -> float:
    """Diameter of the circle with the area of a hole given by its radius in equal sectors."""
    return 2.0 * math.sqrt(float(np.mean(radii**2)))


def azimuthal_spread(radii: np.ndarray) -> float:
    """Standard error of the mean diameter from the scatter of sectors about a smooth shape, 0 for a body of revolution.

    Independent radii of standard deviation s scatter by s sqrt(1 + 4 + 1) in r[i-1] - 2 r[i] + r[i+1]; a smooth
    shape, as the oval of an oblique shot, adds next to nothing.
    """
    if radii.size < 3:
        return 0.0
    scatter = math.sqrt(float(np.mean(np.diff(radii, n=2) ** 2)) / 6.0)
    return 2.0 * scatter / math.sqrt(radii.size)


def radii_by_sector(
    view: ImpactView,
    places: np.ndarray,
    weight: np.ndarray,
    areal_density: float,
    *,
    edge: Callable[..., float] = edge_from_outside,
    window: float | None = None,
) -> np.ndarray:
    """Edge radius of some matter in each sector, between the axis and the rim (m); NaN where there is no edge.

    ``places`` (k,) are the indices of the particles, ``weight`` (k,) the mass per radian of each that counts,
    ``areal_density`` (kg/m2) the undisturbed one; ``edge`` walks inwards from the rim or outwards from the axis, with a
    window of one cell unless told.
    """
    radius, sectors = view.radius[places], view.sector[places]
    radii = np.empty(view.sectors)
    for sector in range(view.sectors):
        mine = (weight > 0.0) & (sectors == sector)
        radii[sector] = edge(
            radius[mine],
            weight[mine],
            width=view.radial_width,
            window=window or view.cell,
            start=view.target_radius - view.cell,
            stop=0.0,
            nominal=lambda low, high: 0.5 * areal_density * (high**2 - low**2),
        )
    return radii


def contained(view: ImpactView, radii: np.ndarray) -> bool:
    """Whether an opening stays clear of the rim."""
    return bool(np.nanmax(radii) < view.target_radius - 3.0 * view.cell)


def parts_of(view: ImpactView, radii: np.ndarray) -> dict[str, float]:
    """Parts of the uncertainty of a diameter by its radii in sectors, m."""
    return {"resolution": view.resolution, "azimuth": azimuthal_spread(radii)}


# ---- axes: the largest and the smallest diameter of an opening, and the root of their product -----
# The diameter in a direction is the sum of the radii of the opposite sectors. One over its square is an ellipse's
# constant plus a cosine of twice the azimuth; the least-squares series with the next harmonic is read between sectors.

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
    return (np.cos(fine[:, None] * terms) @ series) ** -0.5


AXES: dict[str, tuple[str, str, Callable[[np.ndarray], float]]] = {
    "largest": ("Largest diameter", "largest diameter", lambda d: float(d.max())),
    "smallest": ("Smallest diameter", "smallest diameter", lambda d: float(d.min())),
    "mean_root": (
        "Mean root diameter",
        "root of the product of largest and smallest diameter",
        lambda d: math.sqrt(float(d.max() * d.min())),
    ),
}


RadiiOf = Callable[[ImpactView], tuple[np.ndarray, tuple[str, ...]]]  # (sectors,) m, and flags


def axes_of(noun: str, where: str, version: int, radii_of: RadiiOf) -> list[Measurement]:
    """The axes of an opening of which ``radii_of`` reads the radii and flags."""

    def reader(pick: Callable[[np.ndarray], float]) -> Callable[[ImpactView], Reading]:
        def read(view: ImpactView) -> Reading:
            radii, flags = radii_of(view)
            return Reading(pick(_diameters(view, radii)), parts_of(view, radii), flags)

        return read

    return [
        Measurement(
            name=f"{noun}_diameter_{axis}",
            title=f"{title} of the {noun}",
            unit="m",
            meaning=f"{meaning} of the {noun} {where}, through its middle: the sums of the radii of opposite sectors, "
            "one over their square as a constant and two cosines of the azimuth; of a body of revolution its diameter",
            version=version,
            definition=reader(pick),
        )
        for axis, (title, meaning, pick) in AXES.items()
    ]
