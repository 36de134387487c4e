"""How deep a crater is, from the original surface."""

import math

from studies.measurements import Measurement, Reading
from studies.measurements._view import View, edge_from_inside

# Crater depths of thickness from which a block is deep: thinner ones have attached spall at their back (Gehring, in
# Cour-Palais 1987).
DEEP = 3.0

COLUMN = 0.25  # radius of the column about the axis, in projectile diameters: the floor of a crater is flat there


def _read(seen: View) -> Reading:
    """Where matter connected to the target begins, in a column about the axis, walking down into the crater.

    Each particle fills its undisturbed volume. A void below the floor, which spall leaves, is not the floor.
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
    near_back = seen.thickness < DEEP * floor and not seen.back_absorbs
    return Reading(floor, {"resolution": seen.resolution}, ("near_back",) if near_back else ())


MEASUREMENT = Measurement(
    name="crater_depth",
    title="Crater depth",
    unit="m",
    meaning="depth below the original surface at which matter connected to the target, by its undisturbed volume, "
    "first fills half of a column of a quarter projectile diameter about the axis on the way down; near back where the "
    "block is thinner than three of these depths and its back reflects waves",
    version=4,
    read=_read,
)
