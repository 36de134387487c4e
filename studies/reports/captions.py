"""Captions of figures: what points, bars and lines are."""

from collections.abc import Iterable

import numpy as np

from studies.quantities.display import MESH_UNKNOWN
from studies.reports.figure import is_cut
from studies.reports.view import FigureView

NEAR = 0.05  # relative: an observed shot belongs to the panel whose other axes it meets this closely
# A history has dipped where it is below this share of an earlier value.
DIP = 0.5
LAWS = (
    "The laws nearest to the simulation are in colour, all others grey; dotted outside of the range of their source. "
    "The axis reaches over simulation, measured shots and nearest laws."
)


def of_laws(view: FigureView, name: str, kinds: set[str]) -> str:
    """The caption of simulation, laws and measured shots together."""
    sentences = [_of_points(view, name)]
    sentences += [LAWS] if "law" in kinds else []
    sentences += ["A grey cross is a run without a value."] if "missing" in kinds else []
    sentences += ["The cube has the panels that are not drawn."] if view.left_out else []
    return " ".join(sentences)


def _of_points(view: FigureView, name: str) -> str:
    """Explain the points of a figure, their bars and open marks."""
    valued = np.isfinite(view.succeeded(name))
    unknown = int((valued & np.isnan(view.error_bars(name))).sum())
    if unknown == valued.sum():
        return f"Points have no bars: {MESH_UNKNOWN}. Open points carry a flag."
    some = f", unknown at {unknown} of {valued.sum()} points" if unknown else ""
    return (
        f"Inner bars: mesh error and reading{some}. Outer bars: with what material data and models leave open. Open "
        "points carry a flag, or have no mesh error."
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
