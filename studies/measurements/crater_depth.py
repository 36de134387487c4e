"""The depth of a crater below the original surface."""

import math

from studies.measurements import Measurement, Reading
from studies.measurements._impact import ImpactView, edge_from_inside

# Crater depths of thickness from which a block is deep: thinner ones have attached spall at their back (Gehring, in
# Cour-Palais 1987).
DEEP = 3.0

COLUMN = 0.25  # radius of the column about the axis, in projectile diameters: the floor of a crater is flat there


def _read(view: ImpactView) -> Reading:
    """Where matter connected to the target begins, in a column about the axis, walking down into the crater.

    Each particle fills its undisturbed volume. A void below the floor, which spall leaves, is not the floor.
    """
    column = max(COLUMN * view.projectile_diameter, view.cell)
    inside = view.attached & (view.radius < column)
    back = view.thickness - view.cell
    floor = edge_from_inside(
        view.depth[inside],
        view.mass[inside] / view.sectors,
        width=view.axial_width,
        window=view.cell,
        start=back,
        stop=-view.projectile_diameter,
        nominal=lambda low, high: 0.5 * column**2 * view.density * (high - low),
    )
    if math.isnan(floor) or floor >= back:
        return Reading(math.nan, flags=("perforated",) if floor >= back else ("no_crater",))
    near_back = view.thickness < DEEP * floor and not view.back_absorbs
    return Reading(floor, {"resolution": view.resolution}, ("near_back",) if near_back else ())


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
