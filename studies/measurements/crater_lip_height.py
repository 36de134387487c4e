"""The height of the lip of a crater above the original surface."""

import math

import numpy as np

from studies.measurements import Measurement, Reading
from studies.measurements._impact import SAMPLES_PER_CELL, ImpactView, edge_from_inside, overlap

# Cells below the end of the grid: so near to it, the grid cuts what flies off with the lip.
AT_EDGE = 2.0


def _read(view: ImpactView) -> Reading:
    """The highest ring of attached matter about the axis, each ring a cell wide and every half of a cell."""
    rings = 0.5 * view.cell * np.arange(1, int(2.0 * view.target_radius / view.cell) - 6)
    lip = view.only(np.flatnonzero(view.attached & (view.depth < 2.0 * view.cell)))
    # Rings without matter above the original surface are flat.
    raised = lip.radius[lip.depth < 0.0]
    if not raised.size:
        return Reading(math.nan, flags=("no_lip",))
    rings = rings[(rings > raised.min() - view.cell) & (rings < raised.max() + view.cell)]
    height = _highest(lip, rings)
    if not height >= 0.5 * view.cell:
        return Reading(math.nan, flags=("no_lip",))
    if height > view.room - AT_EDGE * view.cell:
        return Reading(math.nan, flags=("lip_at_edge",))
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


MEASUREMENT = Measurement(
    name="crater_lip_height",
    title="Height of the crater's lip",
    unit="m",
    meaning="largest height above the original surface at which matter connected to the target, by its undisturbed "
    "volume, fills half of a window of one cell on the way down, in rings one cell wide about the axis, mean over the "
    "sectors of azimuth; a lip thinner than half of a cell is none, and one within two cells of the end of the grid, "
    "where ejecta still hang together with it, has no height",
    version=2,
    read=_read,
)
