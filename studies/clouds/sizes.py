"""Computes the section of fragments and its figure."""

import math

import numpy as np
import xarray as xr

from studies.clouds.section import FragmentSizes, SmallestSizes
from studies.cubes.points import by_run, places_of, refinements_of
from studies.cubes.reading import finite
from studies.reports.figure import CELL_OF_MESH, GRADY, Figure, Panel, Scale, Series, numbers
from studies.reports.section import Part, Source
from studies.reports.view import MOST_PANELS, spread, title_of
from studies.sweeps.reading import RESOLUTION

CAPTION = (
    "Connected pieces behind the plate that came off, by the diameter of a sphere with their volume (of whole rings in "
    "a body of revolution). The mesh makes none that is much smaller than its cell: where that stands right of the "
    "nominal size after Grady (1988), the mesh alone decides the curves."
)
CURVES = (("number", "fragments_over_size"), ("mass", "fragment_mass_over_size"))


def fragment_sizes_of(source: Source) -> Part | None:
    """The section; None of a sweep without fragments."""
    points = source.points
    if CURVES[0][1] not in points:
        return None
    place = places_of(points)
    is_refined = RESOLUTION in refinements_of(source.dataset)
    cells = np.full(len(place), source.dataset[RESOLUTION][-1]) if is_refined else by_run(points, RESOLUTION).ravel()
    grady = (by_run(points, "fragment_size_grady") / by_run(points, "projectile_diameter")).ravel()
    sizes = [
        SmallestSizes(at, 1.0 / float(cells_across), finite(float(size)))
        for at, cells_across, size in zip(place, cells, grady, strict=True)
    ]
    panels = tuple(_panel(points, number, sizes[number]) for number in spread(range(len(place)), MOST_PANELS))
    if not any(panel.series for panel in panels):
        return None
    figure = Figure(
        name="fragment_sizes",
        title="Size of fragments: share of their number and mass that is larger",
        caption=CAPTION,
        x=Scale("fragment_size", "log10 (size / projectile diameter)", "1"),
        y=Scale("larger", "share that is larger", "1"),
        panels=panels,
    )
    return Part(FragmentSizes(tuple(sizes)), (figure,))


def _panel(points: xr.Dataset, number: int, sizes: SmallestSizes) -> Panel:
    middles = points["fragment_size"].values
    edges = tuple((middles - 0.5 * (middles[1] - middles[0])).tolist())
    series = []
    for label, name in CURVES:
        amounts = points[name].values.reshape(-1, len(middles))[number]
        larger = amounts[::-1].cumsum()[::-1]
        if larger[0] > 0.0:
            first, last = np.flatnonzero(amounts)[[0, -1]]
            shown = slice(max(first - 1, 0), last + 2)
            series.append(Series("quantity", label, edges[shown], numbers(larger[shown] / larger[0])))
    for label, size in ((CELL_OF_MESH, sizes.cell), (GRADY, sizes.grady)):
        if series and size and size > 0.0:
            series.append(Series("trend", label, (math.log10(size),) * 2, (0.0, 1.0)))
    return Panel(title_of(points, sizes.at), sizes.at, tuple(series))
