"""The clear hole: what a gauge that passes through the plate measures, and what hole laws mean.

The plate that is connected to the rim is looked at in sectors of azimuth (one about the axis, of ten degrees in three
dimensions) and, in each, in bins one cell high, counted from the original surface. The edge e of a sector is the
radius at which the areal density of the plate falls to half of its nominal value. With d the diameter of the
projectile, rho the undisturbed density and h the height of a bin, a full bin holds, within d of the edge and per
radian, the mass M = rho h ((e + d)^2 - e^2) / 2. In each bin a is the radius inside which 1 % of M lies, its particles
spread evenly over their widths. Solid matter from a radius c on has that mass between c and a, so that

    c^2 = a^2 - 0.01 ((e + d)^2 - e^2).

c is the wall of the bin; the least of a sector is its clear radius. Less than 1 % of M is nowhere an obstacle: stray
particles, wherever they fly, move a wall by the space that they fill. Setting back from a to c matters: the radius
inside which 1 % lies stands by about 0.01 d (1 + d / 2 e) inside the matter behind a straight wall, on any grid, which
makes a drilled hole of two diameters 1.5 % too wide. A share of what the bin itself holds instead of a full one would
make a particle alone in its bin an obstacle.
"""

import math

import numpy as np

from studies.measurements import Measurement, Reading
from studies.measurements._impact import ImpactView, equal_area_diameter, overlap, place_holding
from studies.measurements._perforation import areal_edges, flag_without_hole, hole_reading
from studies.values.results import DEFINITION

OBSTACLE = 0.01  # of the mass that a full bin holds within a projectile diameter of the edge
HALF_OF_GAP = 0.5  # between two definitions of a diameter: the part of its uncertainty


def _read(view: ImpactView) -> Reading:
    """The clear diameter, with half of its difference from that by areal density as the part of its definition."""
    edges = areal_edges(view)
    flag = flag_without_hole(view, edges)
    if flag:
        return Reading(math.nan, flags=(flag,))
    radii = np.array([_clear_radius(view, sector, edge) for sector, edge in enumerate(edges)])
    if (radii < view.cell).any():
        return Reading(math.nan, flags=("not_perforated",))
    gap = abs(equal_area_diameter(edges) - equal_area_diameter(radii))
    return hole_reading(view, radii, **{DEFINITION: HALF_OF_GAP * gap})


def _clear_radius(view: ImpactView, sector: int, edge: float) -> float:
    """The least radius of a wall over all bins of a sector, m."""
    window = OBSTACLE * ((edge + view.projectile_diameter) ** 2 - edge**2)
    obstacle = 0.5 * view.density * view.cell * window
    mine = np.flatnonzero(
        view.attached_target & (view.sector == sector) & (view.radius < edge + view.projectile_diameter)
    )
    mine = mine[np.argsort(view.depth[mine], kind="stable")]
    depth, reach = view.depth[mine], 0.5 * view.axial_width
    least = math.inf
    for number in range(math.floor((depth[0] - reach) / view.cell), math.ceil((depth[-1] + reach) / view.cell)):
        low, high = number * view.cell, (number + 1) * view.cell
        inside = slice(*np.searchsorted(depth, [low - reach, high + reach]))
        weight = view.mass[mine[inside]] * overlap(depth[inside], view.axial_width, low, high)
        least = min(least, place_holding(view.radius[mine[inside]], weight, view.radial_width, obstacle))
    return math.sqrt(max(least**2 - window, 0.0))


MEASUREMENT = Measurement(
    name="hole_diameter",
    title="Hole diameter",
    unit="m",
    meaning="equal-area diameter of the clear hole in the plate that is connected to the rim: in each sector of "
    "azimuth the least radius, over bins one cell high, of a wall of solid matter that holds, inside the radius where "
    "the bin does, 1 % of what a full bin holds within a projectile diameter of the edge, where the areal density is "
    "half; not perforated where more than a quarter of the plate stands within a cell of the axis, closed on axis "
    "where less does: a film of it still closes the hole; near rim where it is wider than half of the plate, wide bar "
    "where its uncertainty is more than a tenth of it",
    version=4,
    read=_read,
    widest=0.1,
)
