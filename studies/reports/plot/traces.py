"""The traces of a series: points, lines, bands, bars, rings, and the entries of the legend."""

from collections.abc import Iterator, Sequence
from itertools import pairwise
from typing import Any

from studies.reports.figures import Figure, Series
from studies.reports.plot.styles import FLAGGED, LOOKS, NO_MESH_ERROR, OUTSIDE, STYLES, WINDOW, Style, channels
from studies.reports.view import Scale
from studies.values.formats import display_of

Trace = dict[str, Any]

SHADE = 13  # px, breadth of the pale line over the window
MOST_LABELS = 4  # flagged points of a panel that are labelled; beyond, they are ringed alone


def scaled(values: Sequence[Any], scale: Scale) -> list[Any]:
    """Values in the display unit; words and gaps as they are."""
    factor = display_of(scale.unit).factor
    return [value * factor if isinstance(value, float | int) else value for value in values]


def traces_of(series: Series, style: Style, figure: Figure, has_range: bool) -> Iterator[Trace]:
    """The traces of one series; ``has_range`` tells whether any point of its label is inside the range of its law."""
    x, y = scaled(series.x, figure.x), scaled(series.y, figure.y)
    if series.kind == "band":
        low, high = scaled(series.low, figure.y), scaled(series.high, figure.y)
        yield from _band(x, low, high, series, style)
        if _is_drawn_outside(series, low):
            yield _legend_entry(STYLES[OUTSIDE], "lines+markers", dotted=True) | {"label": OUTSIDE}
        return
    look = LOOKS[series.kind]
    if look.own_entry:
        mode = "lines+markers" if series.connected else "markers"
        yield _legend_entry(style, mode, dotted=not has_range)
    if series.kind == "law" and _is_drawn_outside(series, y):
        yield _legend_entry(STYLES[OUTSIDE], "lines+markers", dotted=True) | {"label": OUTSIDE}
    if any(is_open and not flags for is_open, flags in zip(series.flagged, series.doubts, strict=False)):
        yield _legend_entry(STYLES[NO_MESH_ERROR], "markers") | {"label": NO_MESH_ERROR}
    if series.kind == "law" and series.connected:
        yield from _strokes(x, y, series.in_range, style)
    trace: Trace = {
        "named": not look.own_entry,
        "mode": look.mode(connected=series.connected),
        "x": x,
        "y": [0.0] * len(x) if series.kind == "missing" else y,
        **look.more,
    }
    if series.notes:
        trace["text"] = list(series.notes)
    if look.bars:
        trace["error_y"] = _bars(series, style, figure)
    if look.size:
        trace["marker"] = {"color": style.colour, "size": look.size, "symbol": style.symbol}
        if look.own_entry:
            trace["marker"]["symbol"] = _open_where(series, style)
    if look.ring:
        trace["marker"]["line"] = {"width": look.ring, "color": style.colour}
    if look.stroke:
        dash = {"dash": "dot"} if series.kind == "trend" else {}
        trace["line"] = {"color": style.colour, "width": look.stroke, **dash}
    if series.window:
        yield from _shade(x, y, scaled(series.window, figure.x), style)
    yield trace
    doubted = [place for place, flags in enumerate(series.doubts) if flags and y[place] is not None]
    if doubted:
        yield _rings(series, x, y, doubted)


def _shade(x: Sequence[Any], y: Sequence[Any], window: Sequence[float], style: Style) -> Iterator[Trace]:
    """The part of a line inside a window of the abscissa, broad and pale, with an entry of the legend."""
    ends = list(zip(x, y, strict=True))
    pieces = [(a, b) for a, b in pairwise(ends) if None not in (*a, *b) and b[0] > window[0]]
    if not pieces:
        return
    (x0, y0), (x1, y1) = pieces[0]
    begin = max(x0, window[0])
    points = [(begin, y0 + (y1 - y0) * (begin - x0) / (x1 - x0)), *(end for _, end in pieces)]
    shade = {"mode": "lines", "opacity": 0.3, "hoverinfo": "skip"}
    yield shade | {
        "x": [at for at, _ in points],
        "y": [value for _, value in points],
        "line": {"color": style.colour, "width": SHADE},
    }
    grey = {"color": STYLES[WINDOW].colour, "width": SHADE}
    yield shade | {"label": WINDOW, "named": True, "x": [None], "y": [None], "line": grey}


def _is_drawn_outside(series: Series, values: Sequence[Any]) -> bool:
    """Whether a law has a value outside of its range."""
    return any(value is not None and not inside for inside, value in zip(series.in_range, values, strict=True))


def _rings(series: Series, x: Sequence[Any], y: Sequence[Any], doubted: Sequence[int]) -> Trace:
    """A ring about each flagged point, with its flags beside it."""
    style = STYLES[FLAGGED]
    labelled = len(doubted) <= MOST_LABELS and series.kind == "simulation"
    return {
        "label": FLAGGED,
        "named": True,
        "mode": "markers+text" if labelled else "markers",
        "x": [x[place] for place in doubted],
        "y": [y[place] for place in doubted],
        "text": [series.doubts[place] for place in doubted],
        # Towards the middle of the panel, so that no label is cut.
        "textposition": ["bottom right" if place < len(x) / 2 else "bottom left" for place in doubted],
        "textfont": {"color": style.colour, "size": 12},
        "marker": {
            "color": style.colour,
            "size": 17,
            "symbol": style.symbol,
            "line": {"width": 2.4, "color": style.colour},
        },
        "hovertemplate": "%{x}: %{text}<extra></extra>",
        "cliponaxis": False,
    }


def _open_where(series: Series, style: Style) -> list[str]:
    """A mark for each point: open where a simulation is flagged, or a law is outside its range."""
    inside = [not flag for flag in series.flagged] or series.in_range or [True] * len(series.x)
    return [style.symbol if filled else f"{style.symbol}-open" for filled in inside]


def _legend_entry(style: Style, mode: str, *, dotted: bool = False) -> Trace:
    """A trace without points: how the label looks, inside its range or (open, dotted) outside."""
    symbol = f"{style.symbol.removesuffix('-open')}-open" if dotted else style.symbol
    return {
        "named": True,
        "mode": mode,
        "x": [None],
        "y": [None],
        "line": {"color": style.colour, "width": 1.4 if dotted else 2.0, "dash": "dot" if dotted else style.dash},
        "marker": {"color": style.colour, "size": 7, "symbol": symbol, "line": {"width": 1.2}},
        "hoverinfo": "skip",
    }


def _strokes(x: Sequence[Any], y: Sequence[Any], inside: Sequence[bool], style: Style) -> Iterator[Trace]:
    """As the style has it between two points inside the range, dotted elsewhere."""
    for solid, width, dash in ((True, 2.0, style.dash), (False, 1.4, "dot")):
        pairs = [
            place
            for place in range(len(x) - 1)
            if y[place] is not None and y[place + 1] is not None and (inside[place] and inside[place + 1]) == solid
        ]
        if pairs:
            yield {
                "mode": "lines",
                "x": [at for place in pairs for at in (x[place], x[place + 1], None)],
                "y": [at for place in pairs for at in (y[place], y[place + 1], None)],
                "line": {"color": style.colour, "width": width, "dash": dash},
                "hoverinfo": "skip",
            }


def _band(x: Sequence[Any], low: Sequence[Any], high: Sequence[Any], series: Series, style: Style) -> Iterator[Trace]:
    """A shaded area with its edges; bars where a line through the points means nothing."""
    complete = [place for place in range(len(x)) if low[place] is not None and high[place] is not None]
    if not series.connected or len(complete) < 2:
        yield {
            "named": True,
            "mode": "lines",
            "x": [at for place in complete for at in (x[place], x[place], None)],
            "y": [at for place in complete for at in (low[place], high[place], None)],
            "line": {"color": style.colour, "width": 5},
            "opacity": 0.5,
        }
        return
    red, green, blue = channels(style.colour)
    filling = {"fill": "toself", "fillcolor": f"rgba({red},{green},{blue},0.2)"}
    dash = "solid" if any(series.in_range) else "dot"
    edge_line = {"color": style.colour, "width": 1.4, "dash": dash}
    yield {**_legend_entry(style, "lines"), **filling, "line": edge_line}
    yield {
        "mode": "lines",
        "x": [x[place] for place in complete] + [x[place] for place in reversed(complete)],
        "y": [low[place] for place in complete] + [high[place] for place in reversed(complete)],
        **filling,
        "line": {"width": 0, "color": style.colour},
        "hoverinfo": "skip",
    }
    for edge in (low, high):
        yield from _strokes(x, edge, series.in_range, style)


def _bars(series: Series, style: Style, figure: Figure) -> dict[str, Any]:
    lengths = [0.0 if length is None else length for length in scaled(series.uncertainty, figure.y)]
    return {
        "type": "data",
        "array": lengths,
        "color": style.colour,
        "thickness": 1.2,
        "width": 3,
        "visible": bool(lengths),
    }
