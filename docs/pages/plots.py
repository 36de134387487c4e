"""Plots of the pages, as SVG that reads on light and dark paper: grey lines, system fonts, no clock in the file."""

import io
from collections.abc import Callable, Mapping, Sequence
from typing import Any

GREY = "#7f7f7f"
COLOURS = ("#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9", "#7f7f7f")
MARKS = "osD^vP*"
STYLE: dict[Any, Any] = {
    "svg.fonttype": "none",
    "svg.hashsalt": "whipple",
    "font.family": "sans-serif",
    "font.size": 10,
    "text.color": GREY,
    "axes.edgecolor": GREY,
    "axes.labelcolor": GREY,
    "axes.grid": True,
    "grid.color": GREY,
    "grid.alpha": 0.25,
    "xtick.color": GREY,
    "ytick.color": GREY,
    "legend.frameon": False,
    "legend.fontsize": 9,
    "figure.constrained_layout.use": True,
}

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
        axis.legend()
    return close()


def _figure(rows: int, columns: int, size: tuple[float, float]) -> tuple[Any, Callable[[], str]]:
    """The axes of a figure in a row, and the function that gives its SVG."""
    import matplotlib
    from matplotlib.figure import Figure

    with matplotlib.rc_context(STYLE):
        figure = Figure(figsize=size)
        axes = figure.subplots(rows, columns, squeeze=False).ravel()

    def close() -> str:
        buffer = io.StringIO()
        with matplotlib.rc_context(STYLE):
            figure.savefig(buffer, format="svg", transparent=True, metadata={"Date": None})
        return buffer.getvalue()

    return axes, close
