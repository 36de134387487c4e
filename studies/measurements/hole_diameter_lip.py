"""The lip that stands up around a hole on the side of entry."""

import math

import numpy as np

from studies.measurements import Measurement, Reading
from studies.measurements._view import View, azimuthal_spread, equal_area_diameter

# Lips curl within half a projectile diameter of the hole; farther out the whole plate dishes.
REACH = 0.5


def _read(seen: View) -> Reading:
    """Radius of the particle that stands highest above the entry face near the hole, in each sector."""
    radii = np.full(seen.sectors, math.nan)
    for sector in range(seen.sectors):
        mine = np.flatnonzero(seen.attached_target & (seen.sector == sector))
        inner = np.min(seen.radius[mine], initial=math.inf)
        mine = mine[seen.radius[mine] < inner + REACH * seen.projectile_diameter]
        above = mine[seen.depth[mine] < -0.5 * seen.axial_width]
        if above.size:
            radii[sector] = seen.radius[above[np.argmin(seen.depth[above])]]
    if np.isnan(radii).any():
        return Reading(math.nan, flags=("no_lip",))
    return Reading(
        equal_area_diameter(radii),
        {"resolution": seen.resolution, "azimuth": azimuthal_spread(radii)},
    )


MEASUREMENT = Measurement(
    name="hole_diameter_lip",
    title="Lip diameter",
    unit="m",
    meaning="diameter from crest to crest of the lip on the entry side, within half a projectile diameter of the hole",
    version=1,
    read=_read,
)
