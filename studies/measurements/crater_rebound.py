"""The rebound of a crater: the share of its largest depth that it has lost since."""

import math

import numpy as np

from studies.measurements import History, Measurement, Reading

DEPTH = "crater_depth"


def _read(history: History) -> Reading:
    """One minus the last depth over the largest; flagged while the last is the largest."""
    depth = history.values[DEPTH]
    if not depth.size or not math.isfinite(depth[-1]) or not depth[-1] > 0.0:
        return Reading(math.nan, flags=("no_crater",))
    largest = float(np.nanmax(depth))
    deepest = int(np.nanargmax(depth)) == depth.size - 1
    return Reading(1.0 - float(depth[-1]) / largest, flags=("before_maximum",) if deepest else ())


MEASUREMENT = Measurement(
    name="crater_rebound",
    title="Rebound of the crater",
    unit="1",
    meaning="share of its largest depth by which a crater has become shallower at the end, over all observations; "
    "before maximum where it is deepest at the end",
    version=2,
    read=_read,
    follows=(DEPTH,),
)
