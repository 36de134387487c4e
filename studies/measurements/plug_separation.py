"""The time at which a plug is free of its plate."""

import math

import numpy as np

from studies.measurements import History, Measurement, Reading
from studies.measurements._plug import NO_PLUG
from studies.measurements.plug_mass import NAME as MASS


def _read(history: History) -> Reading:
    """The first observation after the last one without a plug."""
    without = np.flatnonzero(np.isnan(history.values[MASS]))
    first = int(without[-1]) + 1 if without.size else 0
    if first == history.times.size:
        return Reading(math.nan, flags=(NO_PLUG,))
    interval = history.times[first] - history.times[max(first - 1, 0)]
    return Reading(float(history.times[first]), {"sampling": float(interval)})


MEASUREMENT = Measurement(
    name="plug_separation",
    title="Separation of the plug",
    unit="s",
    meaning="time of the first observation from which on a plug hangs together with the plate by no matter that has "
    "not failed",
    version=1,
    read=_read,
    follows=(MASS,),
)
