"""The crater of an impact: its floor, its wall in layers, and its opening at the original surface.

Matter counts where it is connected to the target, each particle by its undisturbed volume. Walls are looked for from
the inside outwards, and the floor from above.
"""

import math
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from studies.measurements import History, NoValue, Reading, measurement
from studies.measurements.impact.edges import SAMPLES_PER_CELL, edge_from_inside, overlap
from studies.measurements.impact.opening import axes_of, contained, equal_area_diameter, parts_of, radii_by_sector
from studies.measurements.impact.view import ImpactView

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


@lru_cache(maxsize=1)
def opening(view: ImpactView) -> np.ndarray:
    """Radii of the crater at the original surface."""
    depth = deepest_floor(view).depth
    if depth < view.cell:
        raise NoValue("no_crater")
    unit = view.cell
    if math.isfinite(depth):
        unit = min(unit, DEEPEST * depth / (CENTRES[-1] + 0.5 * LAYER))
    walls = np.array([wall(view, centre * unit, LAYER * unit) for centre in CENTRES])
    if np.isnan(walls).any():
        raise NoValue("no_crater")
    if not contained(view, walls):
        raise NoValue("not_contained")
    # Squares of the radii are quadratic in the depth for every conic of revolution: sphere, ellipsoid, paraboloid, cone
    # and cylinder. Through six layers that scatters little more than a straight line through three (1.8 times the
    # scatter of a layer, 1.5), which makes a hemisphere too wide by a fifth of a cell at a radius of 16 cells.
    *_, squares = np.polyfit(CENTRES, walls**2, CONIC)
    # Walls may close below the surface while the crater forms.
    if (squares <= 0.0).any():
        raise NoValue("no_crater")
    return np.sqrt(squares)


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
    return np.sqrt(0.5 * (inner**2 + outer**2))


# Crater depths of thickness from which a block is deep: thinner ones have attached spall at their back (Gehring, in
# Cour-Palais 1987).
DEEP = 3.0


@measurement(
    title="Crater depth",
    unit="m",
    meaning="depth below the original surface at which matter connected to the target, by its undisturbed volume, "
    "first fills half of a window of two cells in a column of a quarter projectile diameter about the axis (of an "
    "oblique shot, in the column along its trace where it is deepest) on the way down; near back where the block "
    "is thinner than three of these depths and its back reflects waves",
    version=5,
)
def crater_depth(view: ImpactView) -> Reading:
    floor, back = deepest_floor(view).depth, view.thickness - view.cell
    if math.isnan(floor) or floor >= back:
        raise NoValue("perforated" if floor >= back else "no_crater")
    near_back = view.thickness < DEEP * floor and not view.back_absorbs
    return Reading(floor, {"resolution": view.resolution}, ("near_back",) if near_back else ())


@measurement(
    title="Crater diameter",
    unit="m",
    meaning="equal-area diameter at the original surface: the radius at which matter connected to the target, by its "
    "undisturbed volume, first fills half of a window of two cells, halved by area, on the way out from the axis (of "
    "an oblique shot, from the middle of the mouth), in six layers of two cells, one cell apart below the surface, "
    "continued to it by the conic of revolution through them, its square quadratic in the depth; in a crater of less "
    "than fourteen cells the layers are thinner and nearer to each other, so that they end above half of its depth",
    version=6,
)
def crater_diameter(view: ImpactView) -> Reading:
    radii = opening(view)
    return Reading(equal_area_diameter(radii), parts_of(view, radii))


@measurement(title="Crater depth over diameter", unit="1", meaning="crater depth divided by crater diameter", version=6)
def crater_depth_over_diameter(view: ImpactView) -> Reading:
    depth, diameter = crater_depth.read(view), crater_diameter.read(view)
    ratio = depth.value / diameter.value
    parts = {
        name: math.hypot(
            depth.parts.get(name, 0.0) / diameter.value, ratio * diameter.parts.get(name, 0.0) / diameter.value
        )
        for name in sorted(depth.parts.keys() | diameter.parts.keys())
    }
    return Reading(ratio, parts, depth.flags + diameter.flags)


@measurement(
    title="Crater volume",
    unit="m3",
    meaning="volume between the original surface and the floor of a crater, of the whole crater also from a sector: "
    "the area inside the wall in layers a cell high, where the wall of a sector is the radius at which matter "
    "connected to the target, by its undisturbed volume, first fills half of a window of two cells, halved by area, on "
    "the way out",
    version=3,
)
def crater_volume(view: ImpactView) -> Reading:
    """The areas inside the wall of layers a cell high, from the original surface to the floor.

    The layers of an oblique crater are about a line from the middle of its mouth to its deepest place. What the
    volume's surface may be off by stands in its uncertainty: a cell all over the floor and wall, a hemisphere's.
    """
    floor = deepest_floor(view)
    if not floor.depth >= view.cell:
        raise NoValue("no_crater")
    if floor.depth >= view.thickness - view.cell:
        raise NoValue("perforated")
    layers = math.ceil(floor.depth / view.cell)
    height = floor.depth / layers
    middles = height * (np.arange(layers) + 0.5)
    radii = np.array([wall(view, float(z), height, place=z / floor.depth * floor.place) for z in middles])
    if np.isnan(radii[0]).any():
        raise NoValue("no_crater")
    radii = np.nan_to_num(radii)
    if not contained(view, radii):
        raise NoValue("not_contained")
    areas = math.pi * np.mean(radii**2, axis=1)
    surface = 2.0 * math.pi * float(np.mean(radii[0] ** 2))
    return Reading(float(height * areas.sum()), {"resolution": surface * view.resolution})


# Cells below the end of the grid: so near to it, the grid cuts what flies off with the lip.
AT_EDGE = 2.0


@measurement(
    title="Height of the crater's lip",
    unit="m",
    meaning="largest height above the original surface at which matter connected to the target, by its undisturbed "
    "volume, fills half of a window of one cell on the way down, in rings one cell wide about the axis, mean over the "
    "sectors of azimuth; a lip thinner than half of a cell is none, and one within two cells of the end of the grid, "
    "where ejecta still hang together with it, has no height",
    version=2,
)
def crater_lip_height(view: ImpactView) -> Reading:
    """The highest ring of attached matter about the axis, each ring a cell wide and every half of a cell."""
    rings = 0.5 * view.cell * np.arange(1, int(2.0 * view.target_radius / view.cell) - 6)
    lip = view.only(np.flatnonzero(view.attached & (view.depth < 2.0 * view.cell)))
    # Rings without matter above the original surface are flat.
    raised = lip.radius[lip.depth < 0.0]
    if not raised.size:
        raise NoValue("no_lip")
    rings = rings[(rings > raised.min() - view.cell) & (rings < raised.max() + view.cell)]
    height = _highest(lip, rings)
    if not height >= 0.5 * view.cell:
        raise NoValue("no_lip")
    if height > view.room - AT_EDGE * view.cell:
        raise NoValue("lip_at_edge")
    return Reading(height, {"resolution": view.resolution})


def _highest(lip: ImpactView, rings: np.ndarray) -> float:
    """The largest height of rings with these middles; NaN where none has one."""
    reach = 0.5 * (lip.cell + lip.radial_width)
    order = np.argsort(lip.radius)
    ends = np.searchsorted(lip.radius[order], (rings - reach, rings + reach))
    tops = np.array([-lip.depth[order[begin:end]].min(initial=math.inf) for begin, end in ends.T.tolist()])
    highest = -math.inf
    # A ring is no higher than its highest particle, so that few have to be looked at.
    for place in np.argsort(-tops):
        if tops[place] + 0.5 * lip.axial_width + lip.cell / SAMPLES_PER_CELL < highest:
            break
        height = _height(lip, float(rings[place]))
        highest = max(highest, height) if math.isfinite(height) else highest
    return highest if math.isfinite(highest) else math.nan


def _height(view: ImpactView, middle: float) -> float:
    """The height of a lip in a ring above the original surface, the mean over the sectors; NaN where one has none."""
    low, far = middle - 0.5 * view.cell, middle + 0.5 * view.cell
    share = overlap(view.radius, view.radial_width, low, far)
    inside = np.flatnonzero(share > 0.0)
    heights = np.empty(view.sectors)
    for sector in range(view.sectors):
        mine = inside[view.sector[inside] == sector]
        if not mine.size:
            return math.nan
        heights[sector] = -edge_from_inside(
            view.depth[mine],
            view.mass[mine] * share[mine],
            width=view.axial_width,
            window=view.cell,
            start=view.cell,
            stop=float(view.depth[mine].min()) - 2.0 * view.cell,
            nominal=lambda a, b: 0.5 * view.density * (far**2 - low**2) * (b - a),
        )
    return float(heights.mean())


@measurement(
    title="Rebound of the crater",
    unit="1",
    meaning="share of its largest depth by which a crater has become shallower at the end, over all observations; "
    "before maximum where it is deepest at the end",
    version=2,
    follows=(crater_depth.name,),
)
def crater_rebound(history: History) -> Reading:
    depth = history.values[crater_depth.name]
    if not depth.size or not math.isfinite(depth[-1]) or not depth[-1] > 0.0:
        raise NoValue("no_crater")
    largest = float(np.nanmax(depth))
    deepest = int(np.nanargmax(depth)) == depth.size - 1
    return Reading(1.0 - float(depth[-1]) / largest, flags=("before_maximum",) if deepest else ())


MEASUREMENT = (
    crater_depth,
    crater_diameter,
    crater_depth_over_diameter,
    crater_volume,
    crater_lip_height,
    crater_rebound,
    *axes_of("crater", "at the original surface (crater_diameter)", 4, lambda view: (opening(view), ())),
)
