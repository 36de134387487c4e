"""The lip that stands up around a hole on the side of entry."""

import math

import numpy as np

from studies.measurements import Measurement, Reading
from studies.measurements._impact import ImpactView, azimuthal_spread, equal_area_diameter

# Projectile diameters from the hole. Lips of copper plates of a quarter to half a projectile diameter flare by 0.4 to
# 0.9 of it (2 to 7 km/s, 32 cells per diameter); farther out the whole plate dishes.
REACH = 1.0


def _read(view: ImpactView) -> Reading:
    """Radius of the particle that stands highest above the entry face near the hole, in each sector."""
    radii, ends = np.full((2, view.sectors), math.nan)
    for sector in range(view.sectors):
        mine = np.flatnonzero(view.attached_target & (view.sector == sector))
        inner = np.min(view.radius[mine], initial=math.inf)
        ends[sector] = inner + REACH * view.projectile_diameter
        mine = mine[view.radius[mine] < ends[sector]]
        above = mine[view.depth[mine] < -0.5 * view.axial_width]
        if above.size:
            radii[sector] = view.radius[above[np.argmin(view.depth[above])]]
    if np.isnan(radii).any():
        return Reading(math.nan, flags=("no_lip",))
    return Reading(
        equal_area_diameter(radii),
        {"resolution": view.resolution, "azimuth": azimuthal_spread(radii)},
        ("lip_at_window",) if (radii > ends - view.cell).any() else (),
    )


MEASUREMENT = Measurement(
    name="hole_diameter_lip",
    title="Lip diameter",
    unit="m",
    meaning="diameter from crest to crest of the lip on the entry side, within a projectile diameter of the hole; lip "
    "at window where the crest is within a cell of that distance: the plate may stand higher farther out",
    version=2,
    read=_read,
)
