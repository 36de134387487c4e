"""Plots of the pages, as SVG that reads on light and dark paper: grey lines, system fonts, no clock in the file."""

import io
import math
from collections.abc import Callable, Mapping, Sequence
from typing import Any

from matplotlib.figure import Figure

from studies.reports.drawing.canvas import drawn_in_style
from studies.reports.drawing.styles import MARKERS, OKABE_ITO

GREY = "#7f7f7f"
COLOURS, MARKS = (*OKABE_ITO, GREY), ("o", *MARKERS)
# Dashes of lines: the first with each colour, then the second with each again.
DASHES = ("-", "--")
LEGEND_LETTERS = 140  # in a row of a legend, the space of each line and gap taken as 8
LEGEND: dict[str, Any] = {"frameon": False, "labelcolor": GREY, "fontsize": 9}

Points = Sequence[tuple[float, float]]


def residuals(panels: Sequence[tuple[str, Mapping[str, Points]]]) -> str:
    """Panels in two columns: differences in percent against speed in m/s, a mark for each series."""
    axes, close = _figure(-(-len(panels) // 2), 2, (9.0, 2.6 * (-(-len(panels) // 2))))
    for axis, (title, series) in zip(axes, panels, strict=False):
        axis.axhline(0.0, color=GREY, lw=1)
        for (name, points), colour, mark in zip(series.items(), COLOURS, MARKS, strict=False):
            if points:
                axis.plot(*zip(*points, strict=True), mark, ms=4, color=colour, label=name)
        axis.set(title=title, xlabel="speed (m/s)", ylabel="difference (%)")
        axis.legend(**LEGEND)
    return close()


def _figure(rows: int, columns: int, size: tuple[float, float]) -> tuple[Any, Callable[[], str]]:
    """The axes of a figure in a row, and the function that gives its SVG."""
    with drawn_in_style("plain"):
        figure = Figure(figsize=size)
        axes = figure.subplots(rows, columns, squeeze=False).ravel()

    def close() -> str:
        buffer = io.StringIO()
        with drawn_in_style("plain"):
            figure.savefig(buffer, format="svg", transparent=True, metadata={"Date": None})
        return buffer.getvalue()

    return axes, close


def curves(
    panels: Sequence[tuple[str, Sequence[tuple[str, Sequence[tuple[float, float, bool]]]]]], *, xlabel: str, ylabel: str
) -> str:
    """Panels side by side with lines (x, y, whether inside the range) of each label, dotted outside; one legend."""
    labels = list(dict.fromkeys(label for _, lines in panels for label, _ in lines))
    columns = max(1, min(len(labels), LEGEND_LETTERS // max(len(label) + 8 for label in labels)))
    rows = -(-len(labels) // columns)
    axes, close = _figure(1, len(panels), (9.0, 4.4 + 0.2 * rows))
    looks = [(colour, dash) for dash in DASHES for colour in COLOURS]
    for axis, (title, lines) in zip(axes, panels, strict=True):
        for label, points in lines:
            (colour, dash), x = looks[labels.index(label)], [place for place, _, _ in points]
            inside = [y if within else math.nan for _, y, within in points]
            beyond = [math.nan if within else y for _, y, within in points]
            axis.plot(x, beyond, ":", color=colour, lw=1.5)
            axis.plot(x, inside, dash, color=colour, lw=2)
        axis.set(title=title, xlabel=xlabel, ylabel=ylabel)
    handles = [axes[0].plot([], [], dash, color=colour)[0] for colour, dash in looks[: len(labels)]]
    axes[0].figure.legend(handles, labels, loc="outside lower center", ncols=columns, **LEGEND)
    return close()
