"""How deep a crater is, from the original surface."""

import math

from studies.measurements import Measurement, Reading
from studies.measurements._view import View, edge_from_inside

COLUMN = 0.25  # radius of the column about the axis, in projectile diameters: the floor of a crater is flat there


def _read(seen: View) -> Reading:
    """Where matter connected to the target begins, in a column about the axis, walking down into the crater.

    A void below the floor, which spall leaves, is not the floor.
    """
    column = max(COLUMN * seen.projectile_diameter, seen.cell)
    inside = seen.attached & (seen.radius < column)
    back = seen.thickness - seen.cell
    floor = edge_from_inside(
        seen.depth[inside],
        seen.mass[inside] / seen.sectors,
        width=seen.axial_width,
        window=seen.cell,
        start=back,
        stop=-seen.projectile_diameter,
        nominal=lambda low, high: 0.5 * column**2 * seen.density * (high - low),
    )
    if math.isnan(floor) or floor >= back:
        return Reading(math.nan, flags=("perforated",) if floor >= back else ("no_crater",))
    return Reading(floor, {"resolution": seen.resolution})


MEASUREMENT = Measurement(
    name="crater_depth",
    title="Crater depth",
    unit="m",
    meaning="depth below the original surface at which the density of matter connected to the target, in a column of a "
    "quarter projectile diameter about the axis, first reaches half of its nominal value on the way down",
    version=2,
    read=_read,
)
