"""Stands in for ``studies.run`` and ``studies.publish`` in a child: the real ones, after a definition has changed.

Importing it gives the measurement ``MEASUREMENT`` another text and version ``VERSION``. Nothing is
solved any more: a run that is asked for all the same fails, and says so.
"""

import math
import os
from dataclasses import replace
from pathlib import Path
from typing import Any

from studies import measurements
from studies.measurements import Reading
from studies.publish import publish as publish_really
from studies.run import Run

__all__ = ["Run", "execute", "publish"]

MEASUREMENT, VERSION, VALUE = "hole_diameter", 2, 0.0123
FAULT = "WHIPPLE_TEST_FAULT"  # name of a file: the process dies once before it publishes


def raise_the_version() -> None:
    """Change the definition, in this process."""
    plain = measurements.load

    def load(name: str) -> measurements.Measurement:
        one = plain(name)
        return replace(one, version=VERSION, read=_read) if name == MEASUREMENT else one

    measurements.load = load


def _read(seen: Any) -> Reading:
    assert math.isfinite(seen.cell)
    return Reading(VALUE, {"resolution": seen.cell})


def execute(run: Run, *_: Any, **__: Any) -> None:
    """Nothing may be solved."""
    raise AssertionError(f"{run.id} was solved")


def publish(document: Any, outcomes: Any, directory: Path) -> dict[str, str]:
    """The real one; the first time it dies before it, where the environment names a file for that."""
    mark = os.environ.get(FAULT)
    if mark and not Path(mark).exists():
        Path(mark).touch()
        os.abort()
    return publish_really(document, outcomes, directory)


raise_the_version()
