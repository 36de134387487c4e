"""The depth of a crater below the original surface."""

import math

from studies.measurements import Measurement, Reading
from studies.measurements._crater import deepest_floor
from studies.measurements._impact import ImpactView

# Crater depths of thickness from which a block is deep: thinner ones have attached spall at their back (Gehring, in
# Cour-Palais 1987).
DEEP = 3.0


def _read(view: ImpactView) -> Reading:
    """Where matter connected to the target begins, in a column about the axis, walking down into the crater.

    Each particle fills its undisturbed volume. A void below the floor, which spall leaves, is not the floor.
    """
    floor, back = deepest_floor(view).depth, view.thickness - view.cell
    if math.isnan(floor) or floor >= back:
        return Reading(math.nan, flags=("perforated",) if floor >= back else ("no_crater",))
    near_back = view.thickness < DEEP * floor and not view.back_absorbs
    return Reading(floor, {"resolution": view.resolution}, ("near_back",) if near_back else ())


MEASUREMENT = Measurement(
    name="crater_depth",
    title="Crater depth",
    unit="m",
    meaning="depth below the original surface at which matter connected to the target, by its undisturbed volume, "
    "first fills half of a window of two cells in a column of a quarter projectile diameter about the axis (of an "
    "oblique shot, in the column along its trace where it is deepest) on the way down; near back where the block "
    "is thinner than three of these depths and its back reflects waves",
    version=5,
    read=_read,
)
