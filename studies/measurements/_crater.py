"""Shape of a crater: its floor, its wall in layers, and its opening at the original surface.

Matter counts where it is connected to the target, each particle by its undisturbed volume. Walls are looked for from
the inside outwards, and the floor from above.
"""

import math
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from studies.measurements._impact import ImpactView, contained, edge_from_inside, overlap, radii_by_sector

COLUMN = 0.25  # radius of the column about the axis, in projectile diameters: the floor of a crater is flat there

# Particles of a wall are drawn apart by up to a cell (the numerical fracture of the method), so a gap of one cell is no
# end of it: layers are two cells high, and matter is looked for in windows two cells wide. So it is above the floor,
# where in a window of one cell two particles of debris near the edge of a column of 1.5 cells are half of the matter.
LAYER = 2.0  # cells
# Depths of the middles of the layers of a wall below the original surface, in cells.
CENTRES = np.arange(1.0, 7.0)
# The square of a conic's radius is a polynomial of this degree in the depth.
CONIC = 2
# Of the crater's depth, where the lowest layer ends at the latest: the floor is no wall.
DEEPEST = 0.5

STEP = 0.5  # cells between the columns among which that with the deepest floor is looked for


@dataclass(frozen=True)
class Floor:
    """The floor of a crater in a column."""

    depth: float  # m below the original surface; NaN where matter stands above all of it
    place: float  # of the column on the trace of an oblique flight, m from the middle of the opening


# Several measurements of one view ask for it.
@lru_cache(maxsize=1)
def deepest_floor(view: ImpactView) -> Floor:
    """The floor in the column about the axis; of an oblique shot, in the column along its trace where it is deepest."""
    column = max(COLUMN * view.projectile_diameter, view.cell)
    if view.along is None:
        return Floor(_floor(view, view.radius, view.attached, column), 0.0)
    aside = view.radius**2 - view.along**2
    near = view.attached & (aside < column**2)
    reach = view.target_radius - 2.0 * column
    floors = []
    for place in STEP * view.cell * np.arange(-int(reach / view.cell), int(reach / view.cell) + 1):
        radius = np.sqrt(np.maximum(aside, 0.0) + (view.along - place) ** 2)
        depth = _floor(view, radius, near, column)
        if math.isfinite(depth):
            floors.append(Floor(depth, float(place)))
    if not floors:
        return Floor(math.nan, 0.0)
    # The middle of equally deep columns.
    depth = max(floor.depth for floor in floors)
    level = [floor.place for floor in floors if floor.depth >= depth - 0.01 * view.cell]
    return Floor(depth, float(np.mean(level)))


def _floor(view: ImpactView, radius: np.ndarray, among: np.ndarray, column: float) -> float:
    """Where matter begins in a column about a place from which particles have a radius (n,)."""
    inside = among & (radius < column)
    return edge_from_inside(
        view.depth[inside],
        view.mass[inside] / view.sectors,
        width=view.axial_width,
        window=LAYER * view.cell,
        start=view.thickness - view.cell,
        stop=-view.projectile_diameter,
        nominal=lambda low, high: 0.5 * column**2 * view.density * (high - low),
    )


def upper_walls(view: ImpactView) -> np.ndarray | None:
    """Radius (layers, sectors) of the wall in layers below the original surface (m); None without a crater."""
    depth = deepest_floor(view).depth
    if depth < view.cell:
        return None
    unit = view.cell
    if math.isfinite(depth):
        unit = min(unit, DEEPEST * depth / (CENTRES[-1] + 0.5 * LAYER))
    walls = np.array([wall(view, centre * unit, LAYER * unit) for centre in CENTRES])
    return None if np.isnan(walls).any() else walls


@lru_cache(maxsize=1)
def opening(view: ImpactView) -> tuple[np.ndarray | None, tuple[str, ...]]:
    """Radius (sectors,) of the crater at the original surface (m), or None and the flag that says why."""
    walls = upper_walls(view)
    if walls is None:
        return None, ("no_crater",)
    if not contained(view, walls):
        return None, ("not_contained",)
    # Squares of the radii are quadratic in the depth for every conic of revolution: sphere, ellipsoid, paraboloid, cone
    # and cylinder. Through six layers that scatters little more than a straight line through three (1.8 times the
    # scatter of a layer, 1.5), which makes a hemisphere too wide by a fifth of a cell at a radius of 16 cells.
    *_, squares = np.polyfit(CENTRES, walls**2, CONIC)
    # Walls may close below the surface while the crater forms.
    if (squares <= 0.0).any():
        return None, ("no_crater",)
    radii: np.ndarray = np.sqrt(squares)
    return radii, ()


@lru_cache(maxsize=1)
def _by_depth(view: ImpactView) -> tuple[np.ndarray, np.ndarray]:
    """Indices (k,) of the attached particles down to the floor, from the shallowest on, and their depths (m)."""
    deepest = deepest_floor(view).depth + LAYER * view.cell
    attached = np.flatnonzero(view.attached & ~(view.depth > deepest))
    order = attached[np.argsort(view.depth[attached])]
    return order, view.depth[order]


def wall(view: ImpactView, centre: float, height: float, *, place: float = 0.0) -> np.ndarray:
    """Radius of the wall (sectors,) in a layer about a depth; NaN where matter stands on the axis.

    The axis passes through a place on the trace of an oblique flight (m from the middle of the opening). Full matter
    fills half of a window from the circle on that halves its area, which lies outside its middle: by w^2 / 8 R for a
    window of width w at a radius R.
    """
    window = LAYER * view.cell
    low, high = centre - 0.5 * height, centre + 0.5 * height
    near = 0.5 * (height + view.axial_width)
    order, depths = _by_depth(view)
    begin, end = np.searchsorted(depths, (centre - near, centre + near))
    layer = np.sort(order[begin:end])
    middle = radii_by_sector(
        view.about(place),
        layer,
        view.mass[layer] * overlap(view.depth[layer], view.axial_width, low, high),
        view.density * height,
        edge=edge_from_inside,
        window=window,
    )
    inner, outer = np.maximum(middle - 0.5 * window, 0.0), middle + 0.5 * window
    halving: np.ndarray = np.sqrt(0.5 * (inner**2 + outer**2))
    return halving
