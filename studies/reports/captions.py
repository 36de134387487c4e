"""Captions of figures: they explain points, bars, bands and open marks, and name the parts of error bars."""

from collections.abc import Iterable, Iterator

import numpy as np

from studies.cubes import variables as cubes
from studies.quantities.display import MESH_UNKNOWN
from studies.reports.figure import is_cut
from studies.reports.view import ONLY_DRAWN, FigureView

OF_FRAGMENTS = (
    "Connected pieces behind the plate that came off, by the diameter of a sphere with their volume (of whole rings in "
    "a body of revolution). The mesh makes none that is much smaller than its cell: where that stands right of the "
    "nominal size after Grady (1988), the mesh alone decides the curves."
)
NEAR = 0.05  # relative: an observed shot belongs to the panel whose other axes it meets this closely
# A history has dipped where it is below this share of an earlier value.
DIP = 0.5
# Sentences about kinds of series, in this order, for a figure that has them.
OF_KINDS = (
    (
        {"law", "band"},
        "Laws: solid or dashed lines and filled marks inside the range that their source states, dotted lines and "
        "open marks outside. The axis reaches over simulation, observations and laws inside their range: a law outside "
        "of it may leave the figure.",
    ),
    ({"band"}, "A shaded band spans the smallest to the largest answer over the constants stated for that law."),
    ({"missing"}, "A grey cross on the base line is a run without a value."),
    ({"observation"}, f"An observed shot is drawn in the panel whose other axis values it matches within {NEAR:.0%}."),
)


def of_laws(view: FigureView, name: str, kinds: set[str]) -> str:
    """The caption of simulation, laws and observations together, with the laws that are not drawn."""
    sentences = [of_points(view, name)]
    sentences += [text for shown, text in OF_KINDS if kinds & shown]
    drawn = view.drawn_laws(name)
    left_out = sorted(title for law, title in view.laws(name).items() if law not in drawn)
    plain = [title for title in left_out if title.endswith(ONLY_DRAWN)]
    if listed := [title for title in left_out if title not in plain]:
        sentences.append(f"Not drawn, because no point is inside their range: {', '.join(listed)}.")
    if plain:
        names = ", ".join(title.removesuffix(ONLY_DRAWN) for title in plain)
        sentences.append(f"Not drawn beside so many, because in no verdict: {names}.")
    sentences += [f"The lines of {first} and {second} coincide." for first, second in view.coinciding(name)]
    if view.left_out:
        sentences.append("The cube contains the panels that are not drawn.")
    return " ".join(sentences)


def of_points(view: FigureView, name: str) -> str:
    """Explain the points of a figure, their bars and open marks."""
    quantity = name.replace("_", " ")
    if not view.over_resolutions:
        points = f"{quantity}, the mean over offsets" if view.over_offsets else "runs"
        return f"Points are {points}, without bars: {MESH_UNKNOWN}. Open points carry a flag."
    mean = ", the mean over offsets" if view.over_offsets else ""
    return (
        f"Points are {quantity} on the finest grid{mean}; {_bars(view, name)}. Open points carry a flag, or "
        "have no mesh error."
    )


def of_growth(view: FigureView, name: str, histories: np.ndarray) -> str:
    """The caption of histories, (points, samples), with what makes a hole jump and dip where one does."""
    caption = (
        "A run ends when growth has stopped, or at a cap: a line that still rises was cut off. Shaded: the last part "
        "of a line, in which growth is judged."
    )
    if view.refinements:
        caption += " Runs of the finest resolution, without offset."
    if name.startswith("hole_diameter") and any(map(_dips, histories)):
        # Copper, 8 mm on 2 mm, 2 km/s, 32 cells: the plug, 18 mm behind the plate, is off at 14 us and on at 15 us.
        caption += (
            " A hole jumps where the plug behind the plate loses its last thread to the rim, and dips where the thread "
            "touches again: until it has parted for good, the plug counts as the plate."
        )
    return caption


def _dips(history: np.ndarray) -> bool:
    """Whether a history falls below half of a value before it."""
    known = history[np.isfinite(history)]
    return bool((known < DIP * np.maximum.accumulate(known)).any()) if known.size else False


def of_cut_bars(bars: Iterable[tuple[float, float | None]]) -> str:
    """The sentence on bars that the frame cuts, of values with their bars; empty where there is none."""
    count = sum(is_cut(value, bar) for value, bar in bars)
    if not count:
        return ""
    which = "1 bar that is longer than its" if count == 1 else f"{count} bars that are longer than their"
    return f" The axis is set by the values: the frame cuts {which} value."


def _bars(view: FigureView, name: str) -> str:
    """The parts that bars include: "bars are their uncertainty: mesh error, scatter over offsets"."""
    parts = list(_parts(view, name))
    if not parts:
        return f"there are no bars: {MESH_UNKNOWN}"
    return f"bars are their uncertainty: {', '.join(parts)}"


def _parts(view: FigureView, name: str) -> Iterator[str]:
    """The parts that any bar includes, in words."""
    valued = np.isfinite(view.succeeded(name))
    unknown = valued & np.isnan(view.error_bars(name))
    if unknown.sum() == valued.sum():
        return
    yield (
        f"mesh error (unknown at {unknown.sum()} of {valued.sum()} points, without bars)"
        if unknown.any()
        else "mesh error"
    )
    offsets = view.flat(cubes.OFFSETS_PART, name)
    if view.over_offsets and np.isfinite(offsets).any():
        yield "scatter over offsets"
    elif (offsets > 0.0).any():
        yield "position on the grid (as single runs state it)"
    if (view.flat(cubes.MEASUREMENT_PART, name) > 0.0).any():
        yield "measurement"


def of_residuals(view: FigureView, name: str) -> str:
    """The caption of residuals: what the band about zero is, and why it is missing where it is."""
    quantity = name.replace("_", " ")
    valued = np.isfinite(view.compared(name))
    unknown = int((valued & np.isnan(view.error_bars(name))).sum())
    opening = f"Above zero the law gives more than the simulation. Marks as in the figure of {quantity} and the laws. "
    if unknown == valued.sum():
        return f"{opening}No band shows the error bar of the simulation: {_why_unknown(view)}."
    caption = (
        f"{opening}The grey band is the error bar of the simulation over its value, mesh error included: a "
        "law inside it agrees with the simulation within the error bar."
    )
    if unknown:
        caption += f" It is missing at {unknown} of {valued.sum()} points, whose mesh error is unknown."
    return caption


def _why_unknown(view: FigureView) -> str:
    """The reason why no error bar includes the mesh error."""
    if not view.refinements:
        return "every point is one run on one mesh, so the mesh error is unknown"
    if not view.over_resolutions:
        return "every point has one resolution, so the mesh error is unknown"
    return "no point has resolutions that show its mesh error"


def of_convergence(*, offsets: bool, extrapolated: bool, left_out: bool) -> str:
    """The caption of a quantity against the size of a cell."""
    caption = (
        "The grey band is the value that laws are compared with, and its error bar. Every panel spans the same "
        "share of its own middle, so that slopes compare; its axis does not begin at zero."
    )
    if offsets:
        caption = (
            "Small points are runs, one for each sub-cell offset; large ones their mean, with the scatter over "
            f"offsets as bar. {caption}"
        )
    if extrapolated:
        caption += " The star is Richardson's value, the dotted line the curve on which it lies."
    return caption + (" Some points are not drawn; the table contains all points." if left_out else "")
