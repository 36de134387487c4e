"""The mass of a plug."""

import math

from studies.measurements import Measurement, Reading
from studies.measurements._plug import PlugView, without_plug
from studies.values.results import DEFINITION

NAME = "plug_mass"
HALF = 0.5  # between two definitions: the part of the uncertainty


def _read(view: PlugView) -> Reading:
    """The mass with the failed matter that flies with it; its wall is known to a cell."""
    if not view.has_plug:
        return without_plug()
    value, core = float(view.mass[view.plug].sum()), float(view.mass[view.core].sum())
    wall = math.pi * view.projectile_diameter * view.thickness
    parts = {"resolution": view.density * wall * view.resolution, DEFINITION: HALF * (value - core)}
    return Reading(value, parts)


MEASUREMENT = Measurement(
    name=NAME,
    title="Mass of the plug",
    unit="kg",
    meaning="mass of the heaviest piece of the plate that has not failed and does not hang together with the rim, and "
    "of the failed matter in its cells and neighbouring ones that is faster than half of it; no plug where the piece "
    "has less than a tenth of the mass that the projectile covers",
    version=1,
    read=_read,
)
