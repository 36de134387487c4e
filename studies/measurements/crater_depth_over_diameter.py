"""The shape of a crater: depth over diameter."""

import math

from studies.measurements import Measurement, Reading, load
from studies.measurements._impact import ImpactView


def _read(view: ImpactView) -> Reading:
    depth, diameter = load("crater_depth").read(view), load("crater_diameter").read(view)
    ratio = depth.value / diameter.value
    parts = {
        name: math.hypot(
            depth.parts.get(name, 0.0) / diameter.value, ratio * diameter.parts.get(name, 0.0) / diameter.value
        )
        for name in sorted(depth.parts.keys() | diameter.parts.keys())
    }
    return Reading(ratio, parts, depth.flags + diameter.flags)


MEASUREMENT = Measurement(
    name="crater_depth_over_diameter",
    title="Crater depth over diameter",
    unit="1",
    meaning="crater depth divided by crater diameter",
    version=6,
    read=_read,
)
