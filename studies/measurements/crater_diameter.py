"""How wide a crater is at the original surface."""

import math

import numpy as np

from studies.measurements import Measurement, Reading
from studies.measurements._view import (
    View,
    azimuthal_spread,
    contained,
    equal_area_diameter,
    overlap,
    radii_by_sector,
)


def _read(seen: View) -> Reading:
    """Where the target's matter in the first cell below the original surface falls to half of its nominal density."""
    layer = overlap(seen.depth, seen.axial_width, 0.0, seen.cell)
    radii = radii_by_sector(seen, seen.attached, seen.mass * layer, seen.density * seen.cell)
    if np.isnan(radii).any():
        return Reading(math.nan, flags=("no_crater",))
    if not contained(seen, radii):
        return Reading(math.nan, flags=("not_contained",))
    return Reading(
        equal_area_diameter(radii),
        {"resolution": seen.resolution, "azimuth": azimuthal_spread(radii)},
    )


MEASUREMENT = Measurement(
    name="crater_diameter",
    title="Crater diameter",
    unit="m",
    meaning="equal-area diameter at the original surface, where the density of matter connected to the target in the "
    "first cell below it falls to half of its nominal value",
    version=1,
    read=_read,
)
