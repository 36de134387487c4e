"""The deflection of a plate about its hole."""

import math

from studies.measurements import Measurement, Reading
from studies.measurements._plug import PlugView


def _read(view: PlugView) -> Reading:
    mine = view.ring() & (view.origin > view.thickness - view.layer)
    if not mine.any():
        return Reading(math.nan, flags=("no_plate",))
    mass = view.mass[mine]
    moved = (mass * (view.depth[mine] - view.origin[mine])).sum() / mass.sum()
    return Reading(float(moved), {"resolution": view.resolution})


MEASUREMENT = Measurement(
    name="dishing",
    title="Dishing",
    unit="m",
    meaning="mean displacement along the flight of the plate's rear face, a tenth of the thickness or a cell, between "
    "0.75 and 1.25 projectile diameters from the axis, at the time of the observation",
    version=1,
    read=_read,
)
