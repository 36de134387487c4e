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
    """Where matter fills half of the first cell below the original surface, each particle by its undisturbed volume."""
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
    meaning="equal-area diameter at the original surface, where the undisturbed volume of matter connected to the "
    "target in the first cell below it falls to half of the cell",
    version=2,
    read=_read,
)
