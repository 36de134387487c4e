"""The error of a Taylor bar against a reference: the mean error of Johnson, Ma (2005), Eq. 2-42."""

import math

from studies.measurements import Measurement, Reading, load
from studies.measurements._bar import BarView

PARTS = ("final_length", "mushroom_diameter", "width_at_fifth")


def _read(view: BarView) -> Reading:
    """(|dL| / L + |dD| / D + |dW| / W) / 3, relative to the reference."""
    readings = [load(name).read(view) for name in PARTS]
    flags = tuple(sorted({flag for reading in readings for flag in reading.flags}))
    errors, uncertainties = [], []
    for reading, reference in zip(readings, view.references, strict=True):
        if reference is None:
            return Reading(math.nan, flags=("no_reference",))
        errors.append(abs(reading.value - reference) / reference)
        uncertainties.append(reading.parts.get("resolution", 0.0) / reference)
    if flags:
        return Reading(math.nan, flags=flags)
    return Reading(sum(errors) / 3.0, {"resolution": math.hypot(*uncertainties) / 3.0})


MEASUREMENT = Measurement(
    name="taylor_error",
    title="Mean error of the Taylor bar",
    unit="1",
    meaning="mean of the relative errors of length, mushroom diameter and width at a fifth of the length, against the "
    "references of the run",
    version=1,
    read=_read,
)
