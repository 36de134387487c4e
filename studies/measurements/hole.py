"""The hole of an impact: clear, by areal density, in the mid-plane, its axes and its lip.

The clear hole is what a gauge that passes through the plate measures, and what hole laws mean.

The plate that is connected to the rim, through matter that has not failed, is looked at in sectors of azimuth (one
about the axis, of ten degrees in three dimensions) and, in each, in bins one cell high, counted from the original
surface. The edge e of a sector is the radius at which the areal density of the plate falls to half of its nominal
value. With d the diameter of the projectile, rho the undisturbed density and h the height of a bin, a full bin holds,
within d of the edge and per radian, the mass M = rho h ((e + d)^2 - e^2) / 2. In each bin a is the radius inside which
1 % of M lies, its particles spread evenly over their widths. Solid matter from a radius c on has that mass between c
and a, so that

    c^2 = a^2 - 0.01 ((e + d)^2 - e^2).

c is the wall of the bin; the least of a sector is its clear radius. Less than 1 % of M is nowhere an obstacle: stray
particles, wherever they fly, move a wall by the space that they fill. Setting back from a to c matters: the radius
inside which 1 % lies stands by about 0.01 d (1 + d / 2 e) inside the matter behind a straight wall, on any grid, which
makes a drilled hole of two diameters 1.5 % too wide. A share of what the bin itself holds instead of a full one would
make a particle alone in its bin an obstacle.
"""

import math

import numpy as np

from studies.measurements import NoValue, Reading, measurement
from studies.measurements.impact.edges import cumulated, overlap, place_holding
from studies.measurements.impact.opening import axes_of, contained, equal_area_diameter, parts_of, radii_by_sector
from studies.measurements.impact.view import FILM, ImpactView
from studies.quantities.measured import CLOSED_ON_AXIS, DEFINITION

OBSTACLE = 0.01  # of the mass that a full bin holds within a projectile diameter of the edge
HALF_OF_GAP = 0.5  # between two definitions of a diameter: the part of its uncertainty
# Projectile diameters from the hole. Lips of copper plates of a quarter to half a projectile diameter flare by 0.4 to
# 0.9 of it (2 to 7 km/s, 32 cells per diameter); farther out the whole plate dishes.
REACH = 1.0


def _areal_edges(view: ImpactView) -> np.ndarray:
    """Radius (sectors,) at which the areal density of the connected plate falls to half of its nominal value, m."""
    plate = np.flatnonzero(view.attached_target)
    edges = radii_by_sector(view, plate, view.mass[plate], view.density * view.thickness)
    if np.isnan(edges).any() or _is_whole(view):
        raise NoValue("not_perforated")
    if not contained(view, edges):
        raise NoValue("not_contained")
    return edges


def _hole_reading(view: ImpactView, radii: np.ndarray, **parts: float) -> Reading:
    """The reading of a hole with the radii (sectors,) of its wall (m); ``parts`` are uncertainties of its own, m."""
    diameter = equal_area_diameter(radii)
    return Reading(diameter, {**parts_of(view, radii), **parts}, _flags(view, diameter))


def _is_whole(view: ImpactView) -> bool:
    """Whether more than a film of the connected plate stands within a cell of the axis.

    Particles are spread over a cell, the width that they have when they are about to lose contact: so the density does
    not jump as a stretched plate takes them across the edge of that cell one by one.
    """
    mine = view.attached_target
    mass = view.mass[mine] / view.sectors
    (standing,) = cumulated(view.radius[mine], mass, view.cell, np.array([view.cell]))
    return bool(standing > FILM * 0.5 * view.cell**2 * view.density * view.thickness)


def _flags(view: ImpactView, diameter: float) -> tuple[str, ...]:
    """``closed_on_axis`` where a film is within a cell of the axis, ``near_rim`` where the hole is wider than half."""
    innermost = np.min(view.radius[view.attached_target], initial=np.inf)
    closed = (CLOSED_ON_AXIS,) if innermost - 0.5 * view.radial_width < view.cell else ()
    return (*closed, "near_rim") if diameter > view.target_radius else closed


@measurement(
    title="Hole diameter",
    unit="m",
    meaning="equal-area diameter of the clear hole in the plate that is connected to the rim through matter that has "
    "not failed: in each sector of azimuth the least radius, over bins one cell high, of a wall of solid matter that "
    "holds, inside the radius where the bin does, 1 % of what a full bin holds within a projectile diameter of the "
    "edge, where the areal density is half; not perforated where more than a quarter of the plate stands within a "
    "cell of the axis, closed on axis where less does: a film of it still closes the hole; near rim where it is wider "
    "than half of the plate, wide bar where its uncertainty is more than a tenth of it",
    version=7,
    widest=0.1,
)
def hole_diameter(view: ImpactView) -> Reading:
    """The clear diameter, with half of its difference from that by areal density as the part of its definition."""
    edges = _areal_edges(view)
    radii = np.array([_clear_radius(view, sector, edge) for sector, edge in enumerate(edges)])
    if (radii < view.cell).any():
        raise NoValue("not_perforated")
    gap = abs(equal_area_diameter(edges) - equal_area_diameter(radii))
    return _hole_reading(view, radii, **{DEFINITION: HALF_OF_GAP * gap})


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


@measurement(
    title="Hole diameter by areal density",
    unit="m",
    meaning="equal-area diameter of the opening seen along the plate's normal, where the areal density of the plate "
    "that is connected to the rim falls to half of its nominal value; flags as those of the hole diameter",
    version=4,
)
def hole_diameter_areal(view: ImpactView) -> Reading:
    return _hole_reading(view, _areal_edges(view))


@measurement(
    title="Hole diameter at the mid-plane",
    unit="m",
    meaning="equal-area diameter of the innermost particle edges of the connected plate within half a cell of its "
    "original mid-plane; not perforated, closed on axis and near rim as the hole diameter",
    version=6,
)
def hole_diameter_midplane(view: ImpactView) -> Reading:
    near = np.abs(view.depth - 0.5 * view.thickness) <= 0.5 * view.cell
    keep = view.attached_target & near
    radii = np.array(
        [np.min(view.radius[keep & (view.sector == sector)], initial=math.inf) for sector in range(view.sectors)]
    )
    radii = radii - 0.5 * view.radial_width
    if _is_whole(view) or (radii < view.cell).any():
        raise NoValue("not_perforated")
    if not np.isfinite(radii).all() or not contained(view, radii):
        raise NoValue("not_contained")
    return _hole_reading(view, radii)


@measurement(
    title="Lip diameter",
    unit="m",
    meaning="diameter from crest to crest of the lip on the entry side, within a projectile diameter of the hole; lip "
    "at window where the crest is within a cell of that distance: the plate may stand higher farther out",
    version=5,
)
def hole_diameter_lip(view: ImpactView) -> Reading:
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
        raise NoValue("no_lip")
    flags = ("lip_at_window",) if (radii > ends - view.cell).any() else ()
    return Reading(equal_area_diameter(radii), parts_of(view, radii), flags)


def _radii(view: ImpactView) -> tuple[np.ndarray, tuple[str, ...]]:
    """Radii by areal density: the clear radius of a sector is the least in it, which would make an oval narrower."""
    radii = _areal_edges(view)
    return radii, _flags(view, equal_area_diameter(radii))


MEASUREMENT = (
    hole_diameter,
    hole_diameter_areal,
    hole_diameter_midplane,
    hole_diameter_lip,
    *axes_of("hole", "by areal density (hole_diameter_areal)", 3, _radii),
)
