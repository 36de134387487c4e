"""The opening seen along the line of flight: what hole laws mean."""

import math

import numpy as np

from studies.measurements import Measurement, Reading
from studies.measurements._view import (
    View,
    azimuthal_spread,
    contained,
    equal_area_diameter,
    radii_by_sector,
)


def _read(seen: View) -> Reading:
    """Where the areal density of plate that hangs together with the rim falls to half its nominal value."""
    radii = radii_by_sector(seen, seen.attached_target, seen.mass, seen.density * seen.thickness)
    if np.isnan(radii).any():
        return Reading(math.nan, flags=("not_perforated",))
    if not contained(seen, radii):
        return Reading(math.nan, flags=("not_contained",))
    return Reading(
        equal_area_diameter(radii),
        {"resolution": seen.resolution, "azimuth": azimuthal_spread(radii)},
    )


MEASUREMENT = Measurement(
    name="hole_diameter",
    title="Hole diameter",
    unit="m",
    meaning="equal-area diameter of the opening seen along the line of flight, where the areal density of the plate "
    "that is connected to the rim falls to half of its nominal value",
    version=1,
    read=_read,
)
