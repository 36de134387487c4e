"""How the series of a figure are drawn: lines, marks, bands and bars, in the units people read.

Colours are those of Okabe and Ito (2008), told apart with any colour vision; every law has a mark of its
own as well, so that a page printed in grey still reads.
"""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from studies.reports.figures import Figure, Series
from studies.reports.view import Scale
from studies.values.formats import display_of

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


def styles_of(figure: Figure) -> dict[str, Style]:
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


def traces_of(series: Series, style: Style, figure: Figure) -> Iterator[Trace]:
    """What draws one series."""
    shape = SHAPES[series.kind]
    for trace in shape(series, style, figure):
        yield {"type": "scatter", "name": series.label, "legendgroup": series.label, **trace}


def _simulation(series: Series, style: Style, figure: Figure) -> Iterator[Trace]:
    flagged = series.flagged or (False,) * len(series.x)
    mode = "lines+markers" if series.connected else "markers"
    yield _legend_entry(style, mode)
    yield {
        "mode": mode,
        "x": scaled(series.x, figure.x),
        "y": scaled(series.y, figure.y),
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
        "x": scaled(series.x, figure.x),
        "y": scaled(series.y, figure.y),
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
        "x": scaled(series.x, figure.x),
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
    x, y = scaled(series.x, figure.x), scaled(series.y, figure.y)
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
    x = scaled(series.x, figure.x)
    low, high = scaled(series.low, figure.y), scaled(series.high, figure.y)
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
        "x": scaled(series.x, figure.x),
        "y": scaled(series.y, figure.y),
        "line": {"color": style.colour, "width": 1.8},
    }


def _run(series: Series, style: Style, figure: Figure) -> Iterator[Trace]:
    """Small open marks, so that the mean and its bar stay in sight."""
    yield {
        "named": True,
        "mode": "markers",
        "x": scaled(series.x, figure.x),
        "y": scaled(series.y, figure.y),
        "marker": {"color": style.colour, "size": 6, "symbol": style.symbol},
    }


def _limit(series: Series, style: Style, figure: Figure) -> Iterator[Trace]:
    yield {
        "named": True,
        "mode": "markers",
        "x": scaled(series.x, figure.x),
        "y": scaled(series.y, figure.y),
        "cliponaxis": False,
        "marker": {"color": style.colour, "size": 12, "symbol": style.symbol},
    }


def _trend(series: Series, style: Style, figure: Figure) -> Iterator[Trace]:
    yield {
        "named": True,
        "mode": "lines",
        "x": scaled(series.x, figure.x),
        "y": scaled(series.y, figure.y),
        "line": {"color": style.colour, "width": 1.4, "dash": "dot"},
        "hoverinfo": "skip",
    }


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


def scaled(values: Sequence[Any], scale: Scale) -> list[Any]:
    """Values in the display unit; words and gaps as they are."""
    factor = display_of(scale.unit).factor
    return [value * factor if isinstance(value, float | int) else value for value in values]
