"""The scatter of the pressure of particles on the plateau, which should be flat."""

import math

from studies.measurements import Measurement, Reading, load
from studies.measurements._plates import PlateView


def _read(view: PlateView) -> Reading:
    pressure = load("plateau_pressure").read(view)
    if pressure.flags:
        return Reading(math.nan, flags=pressure.flags)
    return Reading(pressure.parts["scatter"] / pressure.value)


MEASUREMENT = Measurement(
    name="plateau_scatter",
    title="Scatter of the plateau pressure",
    unit="1",
    meaning="volume-weighted standard deviation of the pressure of particles on the plateau, over its mean",
    version=1,
    read=_read,
)
