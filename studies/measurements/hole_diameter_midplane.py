"""The hole in the middle of the plate."""

import math

import numpy as np

from studies.measurements import Measurement, Reading
from studies.measurements._impact import ImpactView, contained
from studies.measurements._perforation import hole_reading, is_whole


def _read(view: ImpactView) -> Reading:
    """Innermost particle edges, in each sector, within half a cell of the original mid-plane."""
    near = np.abs(view.depth - 0.5 * view.thickness) <= 0.5 * view.cell
    keep = view.attached_target & near
    radii = np.array(
        [np.min(view.radius[keep & (view.sector == sector)], initial=math.inf) for sector in range(view.sectors)]
    )
    radii = radii - 0.5 * view.radial_width
    if is_whole(view) or (radii < view.cell).any():
        return Reading(math.nan, flags=("not_perforated",))
    if not np.isfinite(radii).all() or not contained(view, radii):
        return Reading(math.nan, flags=("not_contained",))
    return hole_reading(view, radii)


MEASUREMENT = Measurement(
    name="hole_diameter_midplane",
    title="Hole diameter at the mid-plane",
    unit="m",
    meaning="equal-area diameter of the innermost particle edges of the connected plate within half a cell of its "
    "original mid-plane; not perforated, closed on axis and near rim as the hole diameter",
    version=3,
    read=_read,
)
