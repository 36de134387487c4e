"""The figure of convergence: a quantity against the size of a cell, one panel a point, from the cube alone."""

import math
from collections.abc import Iterator, Sequence

import numpy as np
import xarray as xr

from studies.convergence.orders import FORMAL_ORDER
from studies.reports.figures import Figure, Panel, Series, ratio_scale
from studies.reports.places import places_of
from studies.reports.points import Refined, points_of, refined, refinements_of
from studies.reports.view import (
    MOST_PANELS,
    FigureView,
    Scale,
    main_quantities,
    named_value,
    spread,
    view_of,
)
from studies.sweeps.sweep import RESOLUTION

TREND_POINTS = 24  # of the curve through the three finest resolutions
MEAN, ALONE = "mean over offsets", "resolution"
SPACING = Scale("spacing", "cell size / projectile diameter", "1")


def convergence_figures(cube: xr.Dataset) -> Iterator[Figure]:
    """A figure for each main quantity, where a cube has several resolutions."""
    if RESOLUTION not in refinements_of(cube):
        return
    points = points_of(cube)
    view = view_of(points)
    for name in main_quantities(cube):
        known = [one for one in refined(cube, name) if math.isfinite(one.value)]
        if known:
            yield _figure(view, name, spread(known, MOST_PANELS), len(known) > MOST_PANELS)


def _figure(view: FigureView, name: str, shown: Sequence[Refined], left_out: bool) -> Figure:
    words = name.replace("_", " ")
    places = places_of(view.dataset)
    panels = [
        Panel(
            ", ".join(
                named_value(view.dataset, axis, value) for axis, value in places[one.number].items()
            ),
            places[one.number],
            tuple(_series(one, float(view.norm(name)[one.number]))),
            in_words(one),
        )
        for one in shown
    ]
    caption = (
        "The grey band is the value that laws are compared with, and its error bar. Every panel spans the same "
        "share of its own middle, so that slopes compare; zero is not in sight."
    )
    if len(shown[0].values) > len(shown[0].levels):
        caption = (
            "Small points are runs, one for each sub-cell offset; large ones their mean, with the scatter over "
            f"offsets as bar. {caption}"
        )
    if any(one.verdict == "converging" for one in shown):
        caption += " The star is Richardson's value, the dotted line the curve on which it lies."
    if left_out:
        caption += " Not all points are drawn; the table has all."
    return Figure(
        name=f"{name}_convergence",
        title=f"{words.capitalize()} against the size of a cell",
        caption=caption,
        x=SPACING,
        y=ratio_scale(view, name),
        panels=tuple(panels),
        scales="own",
    )


def in_words(one: Refined) -> str:
    """The verdict, with the order where there is one: "converging, order 1.3"."""
    return f"{one.verdict}, order {one.order:.2g}" if one.verdict == "converging" else one.verdict


def _series(one: Refined, norm: float) -> Iterator[Series]:
    if math.isfinite(one.uncertainty):
        yield _band(one, norm)
    if one.verdict == "converging":
        yield _trend(one, norm)
    known = np.isfinite(one.values)
    if len(one.values) > len(one.levels):
        yield Series(
            "run",
            "run at one offset",
            tuple(one.spacings[known].tolist()),
            tuple((one.values[known] / norm).tolist()),
            connected=False,
        )
    levels = [level for level in reversed(one.levels) if level.values]
    yield Series(
        "level",
        MEAN if len(one.values) > len(one.levels) else ALONE,
        tuple(level.spacing for level in levels),
        tuple(level.value / norm for level in levels),
        tuple(None if math.isnan(level.scatter) else level.scatter / norm for level in levels),
    )
    if one.verdict == "converging":
        yield Series("limit", "extrapolated", (0.0,), (one.extrapolated / norm,), connected=False)


def _band(one: Refined, norm: float) -> Series:
    """The value with its error bar, from nothing to the coarsest resolution."""
    coarsest = max(level.spacing for level in one.levels)
    low, high = (one.value - one.uncertainty) / norm, (one.value + one.uncertainty) / norm
    return Series(
        "band",
        "value and error bar",
        (0.0, coarsest),
        low=(low, low),
        high=(high, high),
        in_range=(True, True),
    )


def _trend(one: Refined, norm: float) -> Series:
    """f(0) + C h^p from nothing to the third finest resolution, through the two finest."""
    fine, _, coarse = [level for level in one.levels if level.values][:3]
    order = min(one.order, FORMAL_ORDER)
    x = np.linspace(0.0, coarse.spacing, TREND_POINTS)
    y = one.extrapolated + (fine.value - one.extrapolated) * (x / fine.spacing) ** order
    return Series("trend", "curve of the order used", tuple(x.tolist()), tuple((y / norm).tolist()))
