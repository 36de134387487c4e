"""Figures as Plotly JSON: how points, lines and bands are drawn, in the units people read.

The specification is plain objects, so that a page draws it with the vendored
``plotly-basic.min.js`` and no Python library of plotting is loaded. Colours are those of Okabe and
Ito (2008), told apart with any colour vision; every law has a mark of its own as well, so that a
page printed in grey still reads.
"""

import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from studies.figures import Figure, Panel, Series
from studies.formats import display_of, with_unit
from studies.view import Scale

Trace = dict[str, Any]

# Okabe and Ito (2008), without black (the simulation) and yellow (too pale on paper).
COLOURS = ("#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9")
SYMBOLS = ("square", "triangle-up", "diamond", "triangle-down", "star-diamond", "hexagon")
# Five steps of cividis, which grows evenly in lightness: for lines that follow one number.
RAMP = ("#00204d", "#414d6b", "#7c7b78", "#b8a853", "#e3cb3a")
INK = "#1a1a1a"
GREY = "#8a8a8a"
RULE = "#e4e4e4"
OBSERVED = "#a3003c"

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


@dataclass(frozen=True)
class Style:
    """How the series of one label look."""

    colour: str
    symbol: str


MISSING = "run without a value"
OWN_STYLES = {
    "simulation": Style(INK, "circle"),
    "resolution": Style(INK, "circle"),
    "mean over offsets": Style(INK, "circle"),
    "run at one offset": Style(COLOURS[0], "circle-open"),
    "value and error bar": Style(GREY, "square"),
    "extrapolated": Style(COLOURS[1], "star"),
    "curve of the order used": Style(COLOURS[1], "circle"),
    "observed": Style(OBSERVED, "diamond-open"),
    MISSING: Style(GREY, "x-thin"),
}


def plot(figure: Figure) -> dict[str, Any]:
    """The Plotly specification of a figure: ``data`` and ``layout``."""
    styles = _styles(figure)
    traces: list[Trace] = []
    shown: set[str] = set()
    for number, panel in enumerate(figure.panels, start=1):
        for series in panel.series:
            for trace in _traces(series, styles[series.label], figure):
                traces.append(_placed(trace, number, shown))
    return {"data": traces, "layout": _layout(figure, entries=len(shown))}


def _rank(label: str) -> int:
    """Where a label stands in the legend: the computed and the seen, then laws, then gaps."""
    first = ("simulation", "resolution", "mean over offsets")
    ranks = {**dict.fromkeys(first, 1), "observed": 2, "run at one offset": 2, MISSING: 1000}
    return ranks.get(label, 100)


def _styles(figure: Figure) -> dict[str, Style]:
    """A colour and a mark for each label, the same in every panel."""
    labels = list(dict.fromkeys(series.label for panel in figure.panels for series in panel.series))
    coloured = [label for label in labels if label not in OWN_STYLES]
    if any(series.kind == "history" for panel in figure.panels for series in panel.series):
        return {
            label: Style(_on_ramp(place, len(labels)), "circle")
            for place, label in enumerate(labels)
        }
    styles = {
        label: Style(COLOURS[place % len(COLOURS)], SYMBOLS[place % len(SYMBOLS)])
        for place, label in enumerate(coloured)
    }
    return {**styles, **OWN_STYLES}


def _on_ramp(place: int, count: int) -> str:
    """A colour of the ramp, mixed between its steps."""
    at = (len(RAMP) - 1) * place / max(1, count - 1)
    low = min(int(at), len(RAMP) - 2)
    pairs = zip(_channels(RAMP[low]), _channels(RAMP[low + 1]), strict=True)
    return "#" + "".join(f"{round(a + (b - a) * (at - low)):02x}" for a, b in pairs)


def _channels(colour: str) -> list[int]:
    return [int(colour[place : place + 2], 16) for place in (1, 3, 5)]


# ---- traces --------------------------------------------------------------------------------------


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


def _traces(series: Series, style: Style, figure: Figure) -> Iterator[Trace]:
    shape = SHAPES[series.kind]
    for trace in shape(series, style, figure):
        yield {"type": "scatter", "name": series.label, "legendgroup": series.label, **trace}


def _simulation(series: Series, style: Style, figure: Figure) -> Iterator[Trace]:
    flagged = series.flagged or (False,) * len(series.x)
    mode = "lines+markers" if series.connected else "markers"
    yield _legend_entry(style, mode)
    yield {
        "mode": mode,
        "x": _scaled(series.x, figure.x),
        "y": _scaled(series.y, figure.y),
        "error_y": _bars(series, style, figure),
        "line": {"color": style.colour, "width": 1.6},
        "marker": {
            "color": style.colour,
            "size": 7,
            "symbol": [f"{style.symbol}-open" if flag else style.symbol for flag in flagged],
            "line": {"width": 1.6, "color": style.colour},
        },
    }


def _observation(series: Series, style: Style, figure: Figure) -> Iterator[Trace]:
    yield {
        "named": True,
        "mode": "markers",
        "x": _scaled(series.x, figure.x),
        "y": _scaled(series.y, figure.y),
        "text": list(series.notes),
        "error_y": _bars(series, style, figure),
        "marker": {
            "color": style.colour,
            "size": 9,
            "symbol": style.symbol,
            "line": {"width": 2, "color": style.colour},
        },
    }


def _missing(series: Series, style: Style, figure: Figure) -> Iterator[Trace]:
    yield {
        "named": True,
        "mode": "markers",
        "x": _scaled(series.x, figure.x),
        "y": [0.0] * len(series.x),
        "text": list(series.notes),
        "hovertemplate": "%{x}: %{text}<extra></extra>",
        "cliponaxis": False,
        "marker": {
            "color": style.colour,
            "size": 9,
            "symbol": style.symbol,
            "line": {"width": 2, "color": style.colour},
        },
    }


def _law(series: Series, style: Style, figure: Figure) -> Iterator[Trace]:
    """Solid inside the range, dotted outside, and a mark at each answer."""
    x, y = _scaled(series.x, figure.x), _scaled(series.y, figure.y)
    yield _legend_entry(style, "lines+markers" if series.connected else "markers")
    if series.connected:
        yield from _strokes(x, y, series.in_range, style)
    yield {
        "mode": "markers",
        "x": x,
        "y": y,
        "marker": {
            "color": style.colour,
            "size": 6,
            "symbol": [
                style.symbol if inside else f"{style.symbol}-open" for inside in series.in_range
            ],
            "line": {"width": 1.2, "color": style.colour},
        },
    }


def _legend_entry(style: Style, mode: str) -> Trace:
    """A trace without points: how the label looks inside its range."""
    return {
        "named": True,
        "mode": mode,
        "x": [None],
        "y": [None],
        "line": {"color": style.colour, "width": 2.0},
        "marker": {"color": style.colour, "size": 7, "symbol": style.symbol},
        "hoverinfo": "skip",
    }


def _strokes(
    x: Sequence[Any], y: Sequence[Any], inside: Sequence[bool], style: Style
) -> Iterator[Trace]:
    """Solid between two points inside the range, dotted elsewhere."""
    for solid in (True, False):
        xs, ys = _segments(x, y, inside, solid)
        if xs:
            line = {
                "color": style.colour,
                "width": 2.0 if solid else 1.4,
                "dash": "solid" if solid else "dot",
            }
            yield {"mode": "lines", "x": xs, "y": ys, "line": line, "hoverinfo": "skip"}


def _segments(
    x: Sequence[Any], y: Sequence[Any], inside: Sequence[bool], solid: bool
) -> tuple[list[Any], list[Any]]:
    xs: list[Any] = []
    ys: list[Any] = []
    for place in range(len(x) - 1):
        known = y[place] is not None and y[place + 1] is not None
        if known and (inside[place] and inside[place + 1]) == solid:
            xs += [x[place], x[place + 1], None]
            ys += [y[place], y[place + 1], None]
    return xs, ys


def _band(series: Series, style: Style, figure: Figure) -> Iterator[Trace]:
    """A shaded area with its edges; bars where a line through the points means nothing."""
    x = _scaled(series.x, figure.x)
    low, high = _scaled(series.low, figure.y), _scaled(series.high, figure.y)
    known = [place for place in range(len(x)) if low[place] is not None and high[place] is not None]
    if not series.connected or len(known) < 2:
        yield _posts(x, low, high, known, style)
        return
    yield {
        "named": True,
        "mode": "lines",
        "x": [x[place] for place in known] + [x[place] for place in reversed(known)],
        "y": [low[place] for place in known] + [high[place] for place in reversed(known)],
        "fill": "toself",
        "fillcolor": _pale(style.colour),
        "line": {"width": 0, "color": style.colour},
        "hoverinfo": "skip",
    }
    for edge in (low, high):
        yield from _strokes(x, edge, series.in_range, style)


def _posts(
    x: Sequence[Any], low: Sequence[Any], high: Sequence[Any], known: Iterable[int], style: Style
) -> Trace:
    xs = [one for place in known for one in (x[place], x[place], None)]
    ys = [one for place in known for one in (low[place], high[place], None)]
    return {
        "named": True,
        "mode": "lines",
        "x": xs,
        "y": ys,
        "line": {"color": style.colour, "width": 5},
        "opacity": 0.5,
    }


def _pale(colour: str) -> str:
    return f"rgba({','.join(str(channel) for channel in _channels(colour))},0.2)"


def _history(series: Series, style: Style, figure: Figure) -> Iterator[Trace]:
    yield {
        "named": True,
        "mode": "lines",
        "x": _scaled(series.x, figure.x),
        "y": _scaled(series.y, figure.y),
        "line": {"color": style.colour, "width": 1.8},
    }


def _run(series: Series, style: Style, figure: Figure) -> Iterator[Trace]:
    """Small open marks, so that the mean and its bar stay in sight."""
    yield {
        "named": True,
        "mode": "markers",
        "x": _scaled(series.x, figure.x),
        "y": _scaled(series.y, figure.y),
        "marker": {"color": style.colour, "size": 6, "symbol": style.symbol},
    }


def _limit(series: Series, style: Style, figure: Figure) -> Iterator[Trace]:
    yield {
        "named": True,
        "mode": "markers",
        "x": _scaled(series.x, figure.x),
        "y": _scaled(series.y, figure.y),
        "cliponaxis": False,
        "marker": {"color": style.colour, "size": 12, "symbol": style.symbol},
    }


def _trend(series: Series, style: Style, figure: Figure) -> Iterator[Trace]:
    yield {
        "named": True,
        "mode": "lines",
        "x": _scaled(series.x, figure.x),
        "y": _scaled(series.y, figure.y),
        "line": {"color": style.colour, "width": 1.4, "dash": "dot"},
        "hoverinfo": "skip",
    }


def _bars(series: Series, style: Style, figure: Figure) -> dict[str, Any]:
    lengths = [
        0.0 if length is None else length for length in _scaled(series.uncertainty, figure.y)
    ]
    return {
        "type": "data",
        "array": lengths,
        "color": style.colour,
        "thickness": 1.2,
        "width": 3,
        "visible": bool(lengths),
    }


SHAPES: Mapping[str, Any] = {
    "simulation": _simulation,
    "quantity": _simulation,
    "law": _law,
    "band": _band,
    "observation": _observation,
    "missing": _missing,
    "history": _history,
    "level": _simulation,
    "run": _run,
    "limit": _limit,
    "trend": _trend,
}


def _scaled(values: Sequence[Any], scale: Scale) -> list[Any]:
    """Values in the display unit; words and gaps as they are."""
    factor = display_of(scale.unit).factor
    return [value * factor if isinstance(value, float | int) else value for value in values]


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
        x for panel in figure.panels for series in panel.series for x in _scaled(series.x, figure.x)
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
