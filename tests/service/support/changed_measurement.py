"""A measurement whose definition has changed: another text, another version."""

import math
from dataclasses import replace
from typing import Any

from studies import measurements
from studies.measurements import Reading

MEASUREMENT, VALUE = "hole_diameter", 0.0123
TODAY = measurements.load(MEASUREMENT).version
VERSION = TODAY + 1


def raise_the_version() -> None:
    """Change the definition, in this process."""
    plain = measurements.load

    def load(name: str) -> measurements.Measurement:
        measurement = plain(name)
        if name != MEASUREMENT:
            return measurement
        return replace(measurement, version=VERSION, definition=_read)

    measurements.load = load


def _read(view: Any) -> Reading:
    assert math.isfinite(view.cell)
    return Reading(VALUE, {"resolution": view.cell})
