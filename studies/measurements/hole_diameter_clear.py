"""The widest cylinder that passes: the smallest clearance of the plate."""

import math

import numpy as np

from studies.measurements import Measurement, Reading
from studies.measurements._impact import (
    ImpactView,
    azimuthal_spread,
    contained,
    equal_area_diameter,
    rim_flags,
)


def innermost(view: ImpactView, keep: np.ndarray) -> Reading:
    """Equal-area diameter of the innermost particle edges of kept matter in each sector."""
    radii = np.array(
        [
            np.min(view.radius[keep & (view.sector == sector)], initial=math.inf)
            for sector in range(view.sectors)
        ]
    )
    radii = radii - 0.5 * view.radial_width
    if (radii < view.cell).any():  # plate still stands on the axis
        return Reading(math.nan, flags=("not_perforated",))
    if not np.isfinite(radii).all() or not contained(view, radii):
        return Reading(math.nan, flags=("not_contained",))
    diameter = equal_area_diameter(radii)
    return Reading(
        diameter,
        {"resolution": view.resolution, "azimuth": azimuthal_spread(radii)},
        rim_flags(view, diameter),
    )


def _read(view: ImpactView) -> Reading:
    return innermost(view, view.attached_target)


MEASUREMENT = Measurement(
    name="hole_diameter_clear",
    title="Smallest clear diameter",
    unit="m",
    meaning="equal-area diameter of the innermost particle edges of the plate that is connected to the rim; near "
    "rim where it is wider than half of the plate, wide bar where its uncertainty is more than a tenth of it",
    version=3,
    read=_read,
    widest=0.1,
)
