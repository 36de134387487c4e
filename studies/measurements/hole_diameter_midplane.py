"""The hole in the middle of the plate."""

import numpy as np

from studies.measurements import Measurement, Reading
from studies.measurements._view import View
from studies.measurements.hole_diameter_clear import innermost


def _read(seen: View) -> Reading:
    """Innermost edges within a cell of the original mid-plane."""
    near = np.abs(seen.depth - 0.5 * seen.thickness) <= 0.5 * seen.cell
    return innermost(seen, seen.attached_target & near)


MEASUREMENT = Measurement(
    name="hole_diameter_midplane",
    title="Hole diameter at the mid-plane",
    unit="m",
    meaning="equal-area diameter of the innermost particle edges of the connected plate within half a cell of its "
    "original mid-plane",
    version=1,
    read=_read,
)
