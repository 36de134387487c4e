"""The diameter of a crater at the original surface."""

import math

import numpy as np

from studies.measurements import Measurement, Reading, load
from studies.measurements._impact import (
    ImpactView,
    azimuthal_spread,
    contained,
    edge_from_inside,
    equal_area_diameter,
    overlap,
    radii_by_sector,
)

# Particles of a wall are drawn apart by up to a cell (the numerical fracture of the method), so a gap of one cell is no
# end of it: layers are two cells high, and matter is looked for in windows two cells wide.
LAYER = 2.0  # cells
CENTRES = np.array([1.0, 2.0, 3.0])  # of the layers below the original surface, in cells
# Of the crater's depth, where the lowest layer ends at the latest: the floor is no wall.
DEEPEST = 0.5


def _read(view: ImpactView) -> Reading:
    """Where walls begin on the way out from the axis, in three layers, continued to the original surface."""
    depth = load("crater_depth").read(view).value
    if depth < view.cell:
        return Reading(math.nan, flags=("no_crater",))
    unit = view.cell
    if math.isfinite(depth):
        unit = min(unit, DEEPEST * depth / (CENTRES[-1] + 0.5 * LAYER))
    walls = np.array([_wall(view, centre * unit, LAYER * unit) for centre in CENTRES])
    if np.isnan(walls).any():
        return Reading(math.nan, flags=("no_crater",))
    if not contained(view, walls):
        return Reading(math.nan, flags=("not_contained",))
    # Squares of the radii: linear in the depth for a paraboloid, and but for the square of the depth for a sphere.
    _, squares = np.polyfit(CENTRES, walls**2, 1)
    radii = np.sqrt(np.maximum(squares, 0.0))
    return Reading(
        equal_area_diameter(radii),
        {"resolution": view.resolution, "azimuth": azimuthal_spread(radii)},
    )


def _wall(view: ImpactView, centre: float, height: float) -> np.ndarray:
    """Radius of the wall (sectors,) in a layer about a depth; NaN where matter stands on the axis."""
    share = overlap(view.depth, view.axial_width, centre - 0.5 * height, centre + 0.5 * height)
    return radii_by_sector(
        view,
        view.attached,
        view.mass * share,
        view.density * height,
        edge=edge_from_inside,
        window=LAYER * view.cell,
    )


MEASUREMENT = Measurement(
    name="crater_diameter",
    title="Crater diameter",
    unit="m",
    meaning="equal-area diameter at the original surface: the radius at which matter connected to the target, by its "
    "undisturbed volume, first fills half of a window of two cells on the way out from the axis, in three layers of "
    "two cells, one cell apart below the surface, continued to it by the straight line through its squares; in a "
    "crater of less than eight cells the layers are thinner, so that they end above half of its depth",
    version=3,
    read=_read,
)
