"""Figures as Plotly JSON: panels with their axes, and the traces in them, in the units people read.

The specification is plain objects, so that a page draws it with the vendored ``plotly-basic.min.js`` and no Python
library of plotting is loaded. ``styles`` has colours and marks, ``traces`` draws a series, ``layout`` places panels.
"""

from collections.abc import Sequence
from textwrap import wrap
from typing import Any

from studies.reports.figures import Figure, Panel
from studies.reports.plot.layout import WIDTH, layout_of
from studies.reports.plot.styles import Style, styles_of
from studies.reports.plot.traces import Trace, traces_of

MOST_LETTERS = 44  # in a line of the legend: as many as fit a telephone


def plot(figure: Figure, width: int = WIDTH, panels: Sequence[Panel] | None = None) -> dict[str, Any]:
    """The Plotly specification of a figure of some width: ``data``, which is the same for each, and ``layout``.

    ``panels`` are those to draw where one drawing does not hold the whole figure; axes are those of the figure.
    """
    panels = figure.panels if panels is None else panels
    styles = styles_of(figure)
    traces: list[Trace] = []
    shown: set[str] = set()
    inside = {
        series.label
        for panel in figure.panels
        for series in panel.series
        if any(series.in_range) or series.kind not in ("law", "band")
    }
    for number, panel in enumerate(panels, start=1):
        for series in panel.series:
            for trace in traces_of(series, styles[series.label], figure, series.label in inside):
                label = trace.pop("label", series.label)
                traces.append(_placed(trace, label, styles[label], number, shown))
    return {"data": traces, "layout": layout_of(figure, panels, list(map(_entry, shown)), width)}


def _entry(label: str) -> str:
    """A label as the legend has it, in lines."""
    return "<br>".join(wrap(label, MOST_LETTERS))


def _placed(trace: Trace, label: str, style: Style, panel: int, shown: set[str]) -> Trace:
    """The trace in its panel; a label enters the legend once in a figure."""
    suffix = "" if panel == 1 else str(panel)
    first = trace.pop("named", False) and label not in shown
    if first:
        shown.add(label)
    return {
        "type": "scatter",
        "name": _entry(label),
        "legendgroup": label,
        **trace,
        "xaxis": f"x{suffix}",
        "yaxis": f"y{suffix}",
        "showlegend": first,
        "legendrank": style.rank,
    }
