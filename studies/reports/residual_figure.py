"""The figure of residuals: laws against the simulation, with its error bar as a band about zero."""

import math
from collections.abc import Iterator

import numpy as np

from studies.reports.error_bars import judging, over_resolutions
from studies.reports.figures import Figure, Numbers, Panel, Series, laws_of, numbers
from studies.reports.view import FigureView, Scale, Slice

BAND = "value and error bar"  # the label that it has in the figure of convergence


def residuals(view: FigureView, name: str) -> Figure:
    """Law minus simulation, over the simulation."""
    words = name.replace("_", " ")
    values, bars = view.compared(name), judging(view, name)
    sized = np.where(values == 0.0, np.nan, values)  # nothing is relative to zero
    panels = tuple(
        _panel(view, name, piece, sized / view.norm(name), bars / np.abs(sized))
        for piece in view.slices
    )
    return Figure(
        name=f"{name}_residuals",
        title=f"Law minus simulation, relative: {words}",
        caption="Above zero the law gives more than the simulation. Marks as in the figure of "
        f"{words} and the laws. {_band_in_words(view, values, bars)}",
        x=view.abscissa,
        y=Scale("residual", "(law − simulation) / simulation", "1"),
        panels=panels,
    )


def _panel(
    view: FigureView, name: str, piece: Slice, reference: np.ndarray, bars: np.ndarray
) -> Panel:
    """Residuals of all laws, the error bar behind them; both arrays are (points,) of the view."""
    laws = [_relative(law, reference[piece.cells]) for law in laws_of(view, name, piece)]
    bands = _bands(view, piece, bars[piece.cells]) if laws else ()
    return Panel(piece.title, piece.at, (*bands, *laws))


def _relative(law: Series, reference: np.ndarray) -> Series:
    def over(values: Numbers) -> Numbers:
        return numbers(_floats(values) / reference - 1.0) if values else ()

    return Series(
        kind=law.kind,
        label=law.label,
        x=law.x,
        y=over(law.y),
        low=over(law.low),
        high=over(law.high),
        in_range=law.in_range,
        connected=law.connected,
    )


def _bands(view: FigureView, piece: Slice, bars: np.ndarray) -> Iterator[Series]:
    """The error bar about zero, in pieces: none reaches over a point that has no bar."""
    known = np.flatnonzero(np.isfinite(bars))
    x = view.xs(piece)
    for places in np.split(known, np.flatnonzero(np.diff(known) > 1) + 1):
        if len(places):
            yield Series(
                kind="band",
                label=BAND,
                x=tuple(x[place] for place in places),
                low=numbers(-bars[places]),
                high=numbers(bars[places]),
                in_range=(True,) * len(places),
                connected=piece.connected,
            )


def _band_in_words(view: FigureView, values: np.ndarray, bars: np.ndarray) -> str:
    """What the band is, and why it is missing where it is."""
    valued = np.isfinite(values)
    unknown = int((valued & np.isnan(bars)).sum())
    if unknown == valued.sum():
        return (
            f"No band about zero shows the error bar of the simulation: {_unknown(view)}, and no error "
            "bar judges a law."
        )
    words = (
        "Grey about zero is the error bar of the simulation over its value, mesh error included: a "
        "law inside it cannot be told from the simulation."
    )
    if unknown:
        words += (
            f" It is missing at {unknown} of {valued.sum()} points, whose mesh error is unknown: no "
            "error bar judges a law there."
        )
    return words


def _unknown(view: FigureView) -> str:
    """Why no error bar holds the mesh's part."""
    if not view.refined:
        return "every point is one run on one mesh, whose mesh error is unknown"
    if not over_resolutions(view):
        return "every point has one resolution, whose mesh error is unknown"
    return "no point has resolutions that tell its mesh error"


def _floats(values: Numbers) -> np.ndarray:
    return np.array([math.nan if value is None else value for value in values])
