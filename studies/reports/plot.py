"""Figures as Plotly JSON: panels with their axes, and the traces in them.

The specification is plain objects, so that a page draws it with the vendored
``plotly-basic.min.js`` and no Python library of plotting is loaded.
"""

import math
from typing import Any

from studies.reports.figures import Figure, Panel, Series
from studies.reports.traces import GREY, INK, MISSING, RULE, Trace, scaled, styles_of, traces_of
from studies.values.formats import display_of, with_unit

WIDTH = 1000  # px: the text width of the page
PANEL_HEIGHT = 380
WIDE_HEIGHT = 430  # of a figure with one panel
LEGEND_LINE = 22
ABOVE, BELOW = 26, 52  # px around the panels, without notes and legend
MARGINS = ABOVE + BELOW
GAP = 0.035  # between panels, of the width
GAP_WITH_NUMBERS = 0.075  # where each panel has numbers beside it
ROW_GAP = 120  # px between rows of panels: numbers and title below one, title above the next
NOTE_LINE = 18  # px: a second line above a panel
TICK_APART = 0.1  # of the width: numbers that are nearer run into each other
HEADROOM = 0.06  # above the highest point, of the whole height


def plot(figure: Figure) -> dict[str, Any]:
    """The Plotly specification of a figure: ``data`` and ``layout``."""
    styles = styles_of(figure)
    traces: list[Trace] = []
    shown: set[str] = set()
    for number, panel in enumerate(figure.panels, start=1):
        for series in panel.series:
            for trace in traces_of(series, styles[series.label], figure):
                traces.append(_placed(trace, number, shown))
    return {"data": traces, "layout": _layout(figure, entries=len(shown))}


def _rank(label: str) -> int:
    """Where a label stands in the legend: the computed and the seen, then laws, then gaps."""
    first = ("simulation", "resolution", "mean over offsets")
    ranks = {**dict.fromkeys(first, 1), "observed": 2, "run at one offset": 2, MISSING: 1000}
    return ranks.get(label, 100)


def _placed(trace: Trace, panel: int, shown: set[str]) -> Trace:
    """The trace in its panel; a label enters the legend once in a figure."""
    suffix = "" if panel == 1 else str(panel)
    named = trace.pop("named", False)
    first = named and trace["legendgroup"] not in shown
    if first:
        shown.add(trace["legendgroup"])
    return {
        **trace,
        "xaxis": f"x{suffix}",
        "yaxis": f"y{suffix}",
        "showlegend": bool(first),
        "legendrank": _rank(trace["legendgroup"]),
    }


# ---- layout --------------------------------------------------------------------------------------


def _layout(figure: Figure, entries: int) -> dict[str, Any]:
    columns, rows = _shape(len(figure.panels))
    height = (WIDE_HEIGHT if len(figure.panels) == 1 else PANEL_HEIGHT) * rows
    legend = LEGEND_LINE * math.ceil(entries / 3) + 18
    notes = NOTE_LINE if any(panel.note for panel in figure.panels) else 0
    layout: dict[str, Any] = {
        "width": WIDTH,
        "height": height + legend + notes,
        "margin": {"l": 64, "r": 12, "t": ABOVE + notes, "b": BELOW + legend},
        "paper_bgcolor": "#ffffff",
        "plot_bgcolor": "#ffffff",
        "font": {"family": "Helvetica, Arial, sans-serif", "size": 13, "color": INK},
        "legend": {
            "orientation": "h",
            "x": 0,
            "y": -58 / (height - MARGINS),
            "yanchor": "top",
            "itemclick": False,
            "itemdoubleclick": False,
        },
        "hoverlabel": {"font": {"size": 12}},
        "annotations": [],
    }
    for number, panel in enumerate(figure.panels, start=1):
        _add_panel(layout, figure, number, panel, columns, rows)
    return layout


def _shape(panels: int) -> tuple[int, int]:
    columns = {1: 1, 2: 2, 4: 2}.get(panels, 3)
    return columns, math.ceil(panels / columns)


def _add_panel(
    layout: dict[str, Any], figure: Figure, number: int, panel: Panel, columns: int, rows: int
) -> None:
    """Axes and title of one panel."""
    suffix = "" if number == 1 else str(number)
    row, column = divmod(number - 1, columns)
    own = figure.scales == "own"
    space = GAP_WITH_NUMBERS if own else GAP
    width = (1 - space * (columns - 1)) / columns
    left = column * (width + space)
    notes = NOTE_LINE if any(one.note for one in figure.panels) else 0
    gap = (ROW_GAP + notes) / (PANEL_HEIGHT * rows - MARGINS) if rows > 1 else 0.0
    tall = (1 - gap * (rows - 1)) / rows
    top = 1 - row * (tall + gap)
    edge = column == 0
    layout[f"xaxis{suffix}"] = {
        **_axis(),
        "domain": [left, left + width],
        "anchor": f"y{suffix}",
        "title": _title(with_unit(figure.x.label, figure.x.unit)),
        **_range(_x_range(figure)),
        **({"type": "category"} if figure.x.unit is None else {}),
        **(_cell_ticks(panel) if figure.x.name == "spacing" else {}),
    }
    layout[f"yaxis{suffix}"] = {
        **_axis(),
        "domain": [top - tall, top],
        "anchor": f"x{suffix}",
        "showticklabels": edge or own,
        "title": _title(with_unit(figure.y.label, figure.y.unit) if edge else ""),
        **_range(_own_range(figure, panel) if own else _y_range(figure)),
        **({"tickformat": "+.0%"} if figure.y.name == "residual" else {}),
    }
    layout["annotations"].append(
        {
            "text": f"<b>{panel.title}</b>" + (f"<br>{panel.note}" if panel.note else ""),
            "align": "left",
            "x": left,
            "y": top,
            "xref": "paper",
            "yref": "paper",
            "xanchor": "left",
            "yanchor": "bottom",
            "showarrow": False,
            "font": {"size": 13},
        }
    )


def _title(text: str) -> dict[str, Any]:
    return {"text": text, "standoff": 8, "font": {"size": 13}}


def _axis() -> dict[str, Any]:
    return {
        "showline": True,
        "linecolor": GREY,
        "linewidth": 1,
        "gridcolor": RULE,
        "zeroline": True,
        "zerolinecolor": GREY,
        "ticks": "outside",
        "tickcolor": GREY,
        "ticklen": 4,
        "fixedrange": True,
        "automargin": True,
    }


def _range(limits: tuple[float, float] | None) -> dict[str, Any]:
    return {} if limits is None else {"range": list(limits)}


def _x_range(figure: Figure) -> tuple[float, float] | None:
    known = [
        x for panel in figure.panels for series in panel.series for x in scaled(series.x, figure.x)
    ]
    numbers = [x for x in known if isinstance(x, float)]
    if not numbers or figure.x.unit is None:
        return None
    low, high = min(numbers), max(numbers)
    if figure.x.name == "time":
        low = 0.0
    margin = 0.06 * (high - low) or 0.1 * abs(high) or 1.0
    return (low if figure.x.name == "time" else low - margin, high + margin)


def _cell_ticks(panel: Panel) -> dict[str, Any]:
    """A tick at each resolution, in the words in which people ask for it: 1/32 of a diameter."""
    levels = [series for series in panel.series if series.kind == "level"]
    sizes = sorted({x for series in levels for x in series.x if isinstance(x, float)})
    apart: list[float] = []
    for size in reversed(sizes):
        nearest = min([size, *(one - size for one in apart)])
        if nearest >= TICK_APART * (apart[0] if apart else size):
            apart.append(size)
    return {
        "tickvals": [0.0, *apart],
        "ticktext": ["0", *(f"1/{1.0 / size:.4g}" for size in apart)],
        "tickangle": 0,
    }


def _own_range(figure: Figure, panel: Panel) -> tuple[float, float] | None:
    """About the panel's own middle, as wide in per cent as the panel that needs most."""
    spans = {id(one): _span(one) for one in figure.panels}
    mine = spans[id(panel)]
    if mine is None:
        return None
    half = max(
        0.5 * (high - low) / abs(0.5 * (high + low)) if high + low else 0.0
        for low, high in (span for span in spans.values() if span is not None)
    )
    factor = display_of(figure.y.unit).factor
    middle = 0.5 * (mine[0] + mine[1]) * factor
    reach = abs(middle) * half * (1.0 + 2.0 * HEADROOM) or 1.0
    return (middle - reach, middle + reach)


def _span(panel: Panel) -> tuple[float, float] | None:
    """Lowest and highest mark of a panel, bars included."""
    ends = [end for series in panel.series for end in (*_tops(series), *_bottoms(series))]
    return (min(ends), max(ends)) if ends else None


def _y_range(figure: Figure) -> tuple[float, float] | None:
    """Zero is always in sight, and so is every mark."""
    tops = [top for panel in figure.panels for series in panel.series for top in _tops(series)]
    known = [top * display_of(figure.y.unit).factor for top in tops]
    if not known:
        return None
    low, high = min(0.0, *known), max(0.0, *known)
    margin = HEADROOM * (high - low) or 1.0
    return (low - margin if low < 0 else low, high + margin)


def _bottoms(series: Series) -> list[float]:
    bars = series.uncertainty or (None,) * len(series.y)
    return [y - (bar or 0.0) for y, bar in zip(series.y, bars, strict=True) if y is not None]


def _tops(series: Series) -> list[float]:
    bars = series.uncertainty or (None,) * len(series.y)
    tops = [y + (bar or 0.0) for y, bar in zip(series.y, bars, strict=True) if y is not None]
    return tops + [edge for edge in (*series.low, *series.high) if edge is not None]
