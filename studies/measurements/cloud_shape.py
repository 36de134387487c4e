"""Width and length of a debris cloud."""

import math

import numpy as np

from studies.measurements import Measurement, Reading
from studies.measurements._cloud import CloudView, exceeded_reading
from studies.measurements._impact import overlap

SHARE = 0.01  # of the mass, which lies farther out


def _radius(view: CloudView) -> Reading:
    return exceeded_reading(view, view.radius, SHARE, view.behind(), is_length=True)


def _place(view: CloudView) -> Reading:
    """Mean depth of what lies farther out than the largest radius, with the standard error of a mean."""
    radius = _radius(view)
    behind = view.behind()
    if not behind.any():
        return Reading(math.nan, flags=radius.flags)
    outside = overlap(view.radius[behind], view.width, radius.value, math.inf)
    mass, depth = view.mass[behind] * outside, view.depth[behind] - view.thickness
    mean = float((mass * depth).sum() / mass.sum())
    error = math.sqrt(float((mass**2 * (depth - mean) ** 2).sum())) / float(mass.sum())
    return Reading(mean, {"sampling": error, "resolution": view.resolution}, radius.flags)


def _length(view: CloudView) -> Reading:
    depth = view.depth - view.thickness
    return exceeded_reading(view, depth, SHARE, view.behind(), is_length=True)


def _ratio(view: CloudView) -> Reading:
    length, radius = _length(view), _radius(view)
    ratio = length.value / (2.0 * radius.value)
    if not math.isfinite(ratio):
        return Reading(math.nan, flags=length.flags)
    parts = {
        name: abs(ratio) * float(np.hypot(part / length.value, radius.parts[name] / radius.value))
        for name, part in length.parts.items()
    }
    return Reading(ratio, parts, tuple(dict.fromkeys((*length.flags, *radius.flags))))


_FLAGS = "flags as those of the tip velocity"

MEASUREMENT = (
    Measurement(
        name="cloud_radius",
        title="Largest radius of the cloud",
        unit="m",
        meaning=f"distance from the axis that {SHARE:.0%} of the mass behind the plate exceeds; {_FLAGS}",
        version=1,
        read=_radius,
    ),
    Measurement(
        name="cloud_radius_place",
        title="Place of the largest radius",
        unit="m",
        meaning="mean distance, from the plate's original back surface, of the matter behind it that is at the "
        "largest radius or farther out",
        version=1,
        read=_place,
    ),
    Measurement(
        name="cloud_length",
        title="Length of the cloud",
        unit="m",
        meaning=f"distance from the plate's original back surface that {SHARE:.0%} of the mass behind it "
        f"exceeds; {_FLAGS}",
        version=1,
        read=_length,
    ),
    Measurement(
        name="cloud_length_over_diameter",
        title="Length of the cloud over its diameter",
        unit="1",
        meaning="length of the cloud divided by twice its largest radius",
        version=1,
        read=_ratio,
    ),
)
