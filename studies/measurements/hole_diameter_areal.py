"""The opening seen along the plate's normal, by its areal density."""

import math

from studies.measurements import Measurement, Reading
from studies.measurements._impact import ImpactView
from studies.measurements._perforation import areal_edges, flag_without_hole, hole_reading


def _read(view: ImpactView) -> Reading:
    """Where the areal density of plate that hangs together with the rim falls to half its nominal value."""
    edges = areal_edges(view)
    flag = flag_without_hole(view, edges)
    if flag:
        return Reading(math.nan, flags=(flag,))
    return hole_reading(view, edges)


MEASUREMENT = Measurement(
    name="hole_diameter_areal",
    title="Hole diameter by areal density",
    unit="m",
    meaning="equal-area diameter of the opening seen along the plate's normal, where the areal density of the plate "
    "that is connected to the rim falls to half of its nominal value; flags as those of the hole diameter",
    version=1,
    read=_read,
)
