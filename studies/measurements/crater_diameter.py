"""The diameter of a crater at the original surface."""

import math

from studies.measurements import Measurement, Reading
from studies.measurements._crater import opening
from studies.measurements._impact import ImpactView, azimuthal_spread, equal_area_diameter


def _read(view: ImpactView) -> Reading:
    """Where walls begin on the way out from the axis, in six layers, continued to the original surface."""
    radii, flags = opening(view)
    if radii is None:
        return Reading(math.nan, flags=flags)
    return Reading(equal_area_diameter(radii), {"resolution": view.resolution, "azimuth": azimuthal_spread(radii)})


MEASUREMENT = Measurement(
    name="crater_diameter",
    title="Crater diameter",
    unit="m",
    meaning="equal-area diameter at the original surface: the radius at which matter connected to the target, by its "
    "undisturbed volume, first fills half of a window of two cells, halved by area, on the way out from the axis (of "
    "an oblique shot, from the middle of the mouth), in six layers of two cells, one cell apart below the surface, "
    "continued to it by the conic of revolution through them, its square quadratic in the depth; in a crater of less "
    "than fourteen cells the layers are thinner and nearer to each other, so that they end above half of its depth",
    version=6,
    read=_read,
)
