"""The opening seen along the plate's normal: what hole laws mean."""

import math

import numpy as np

from studies.measurements import Measurement, Reading
from studies.measurements._impact import (
    ImpactView,
    azimuthal_spread,
    contained,
    equal_area_diameter,
    radii_by_sector,
    rim_flags,
)
from studies.measurements._perforation import film_flags, is_whole


def _read(view: ImpactView) -> Reading:
    """Where the areal density of plate that hangs together with the rim falls to half its nominal value."""
    radii = radii_by_sector(view, view.attached_target, view.mass, view.density * view.thickness)
    if np.isnan(radii).any() or is_whole(view):
        return Reading(math.nan, flags=("not_perforated",))
    if not contained(view, radii):
        return Reading(math.nan, flags=("not_contained",))
    diameter = equal_area_diameter(radii)
    return Reading(
        diameter,
        {"resolution": view.resolution, "azimuth": azimuthal_spread(radii)},
        film_flags(view) + rim_flags(view, diameter),
    )


MEASUREMENT = Measurement(
    name="hole_diameter",
    title="Hole diameter",
    unit="m",
    meaning="equal-area diameter of the opening seen along the plate's normal, where the areal density of the plate "
    "that is connected to the rim falls to half of its nominal value; not perforated where more than a quarter of it "
    "stands within a cell of the axis, closed on axis where less does: a film of the plate still closes the hole; near "
    "rim where it is wider than half of the plate",
    version=3,
    read=_read,
)
