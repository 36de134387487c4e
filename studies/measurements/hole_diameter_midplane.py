"""The hole in the middle of the plate."""

import math
from dataclasses import replace

import numpy as np

from studies.measurements import Measurement, Reading
from studies.measurements._impact import ImpactView
from studies.measurements._perforation import film_flags, is_whole
from studies.measurements.hole_diameter_clear import innermost


def _read(view: ImpactView) -> Reading:
    """Innermost edges within half a cell of the original mid-plane."""
    if is_whole(view):
        return Reading(math.nan, flags=("not_perforated",))
    near = np.abs(view.depth - 0.5 * view.thickness) <= 0.5 * view.cell
    reading = innermost(view, view.attached_target & near)
    if math.isnan(reading.value):
        return reading
    return replace(reading, flags=film_flags(view) + reading.flags)


MEASUREMENT = Measurement(
    name="hole_diameter_midplane",
    title="Hole diameter at the mid-plane",
    unit="m",
    meaning="equal-area diameter of the innermost particle edges of the connected plate within half a cell of its "
    "original mid-plane; not perforated, closed on axis and near rim as the hole diameter",
    version=3,
    read=_read,
)
