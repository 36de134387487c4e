"""Figures as Plotly JSON: panels with their axes, and the traces in them, in the units people read.

The specification is plain objects, so that a page draws it with the vendored ``plotly-basic.min.js`` and no Python
library of plotting is loaded. Colours are those of Okabe and Ito (2008), told apart with any colour vision; every law
has a mark of its own as well, so that a page printed in grey still reads.
"""

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from itertools import pairwise
from textwrap import wrap
from typing import Any

from studies.reports import figures as labels
from studies.reports.figures import Figure, Panel, Series
from studies.reports.view import Scale
from studies.values.formats import NARROW_SPACE, display_of, signed, with_unit

Trace = dict[str, Any]

# Okabe and Ito (2008), without black (the simulation) and yellow (too pale on paper).
COLOURS = ("#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9")
SYMBOLS = ("square", "triangle-up", "diamond", "triangle-down", "star-diamond", "hexagon")
AGAIN = (
    "circle",
    "cross",
    "x",
    "star",
    "pentagon",
    "bowtie",
)  # with the same colours, of the next labels
# For lines that follow one number: lightness grows along it, and each step reads on white and on black.
RAMP = ("#5b4cc4", "#0072b2", "#009e9e", "#7fa800", "#d99000")
INK, GREY, RULE, CRIMSON = "#1a1a1a", "#8a8a8a", "#e4e4e4", "#a3003c"

# px
WIDTH = 1000  # the text width of the page
# Widths for which a page has layouts: a screen, a tablet or a sheet of A4, a telephone.
WIDTHS = (WIDTH, 700, 340)
LEGEND_ENTRY = 300  # width that an entry of the legend needs
PANEL_WIDTH = 300  # least width of a panel
LETTER = 7.2  # width of a letter of a title, on average
PANEL_HEIGHT = 380
WIDE_HEIGHT = 430  # height of a figure with one panel, px
LEGEND_LINE = 22
ABOVE, BELOW = 26, 52  # around the panels, without notes and legend
ROW_GAP = 120  # space between rows of panels, px: numbers and title below one, title above the next
NOTE_LINE = 18  # a second line above a panel
# shares of the width or the height
GAP = 0.035  # space between panels, as a part of the figure
GAP_WITH_NUMBERS = 0.075  # where each panel has numbers beside it
TICK_APART = 0.1  # numbers that are nearer run into each other
HEADROOM = 0.06  # above the highest point
MOST_TICKS = 7  # of an axis in per cent
FLAGGED = "flagged: see the label at the mark"
OUTSIDE = "law outside its range: open marks, dotted"
NO_MESH_ERROR = "simulation without a mesh error: open marks"
WINDOW = "window in which growth is judged"
SHADE = 13  # px, breadth of the pale line over the window
MOST_LABELS = 4  # flagged points of a panel that are labelled; beyond, they are ringed alone


@dataclass(frozen=True)
class Style:
    """Colour, mark and place in the legend of the series of one label."""

    colour: str
    symbol: str
    rank: int = 100
    dash: str = "solid"  # of lines inside the range of a law


# Computed and observed values come first in the legend, laws next, gaps last.
STYLES = {
    labels.SIMULATION: Style(INK, "circle", 1),
    labels.LEVEL: Style(INK, "circle", 1),
    labels.MEAN: Style(INK, "circle", 1),
    labels.RUN: Style(COLOURS[0], "circle-open", 2),
    labels.OBSERVED: Style(CRIMSON, "diamond-open", 2),
    labels.ERROR_BAR: Style(GREY, "square"),
    labels.EXTRAPOLATED: Style(COLOURS[1], "star"),
    labels.TREND: Style(COLOURS[1], "circle"),
    labels.MISSING: Style(GREY, "x-thin", 1000),
    FLAGGED: Style(CRIMSON, "circle-open", 3),
    NO_MESH_ERROR: Style(INK, "circle-open", 2),
    OUTSIDE: Style(GREY, "square-open", 900),
    WINDOW: Style(GREY, "circle", 900),
}


@dataclass(frozen=True)
class Look:
    """Marks and lines of one kind of series; sizes and widths in px, 0 for what is not drawn."""

    size: float = 0.0  # of marks
    ring: float = 0.0  # width of their outline
    stroke: float = 0.0  # width of the line through the points
    own_entry: bool = False  # the legend shows it filled, whatever its points are
    bars: bool = False  # has error bars
    more: Mapping[str, Any] = field(default_factory=dict)

    def mode(self, *, connected: bool) -> str:
        lines = "lines" if self.stroke and connected else ""
        return "+".join(filter(None, (lines, "markers" if self.size else "")))


CURVE = Look(size=7, ring=1.6, stroke=1.6, own_entry=True, bars=True)
LOOKS = {
    "simulation": CURVE,
    "quantity": CURVE,
    "level": CURVE,
    "law": Look(size=6, ring=1.2, own_entry=True),
    "observation": Look(size=9, ring=2, bars=True),
    "missing": Look(
        size=9,
        ring=2,
        more={"hovertemplate": "%{x}: %{text}<extra></extra>", "cliponaxis": False},
    ),
    "history": Look(stroke=1.8),
    "run": Look(size=6),  # small and open, so that the mean and its bar stay in sight
    "limit": Look(size=12, more={"cliponaxis": False}),
    "trend": Look(stroke=1.4, more={"hoverinfo": "skip"}),
}


def plot(figure: Figure, width: int = WIDTH) -> dict[str, Any]:
    """The Plotly specification of a figure of some width: ``data``, which is the same for each, and ``layout``."""
    styles = _styles(figure)
    traces: list[Trace] = []
    shown: set[str] = set()
    inside = {
        series.label
        for panel in figure.panels
        for series in panel.series
        if any(series.in_range) or series.kind not in ("law", "band")
    }
    for number, panel in enumerate(figure.panels, start=1):
        for series in panel.series:
            for trace in _traces(series, styles[series.label], figure, series.label in inside):
                label = trace.pop("label", series.label)
                traces.append(_placed(trace, label, styles[label], number, shown))
    return {"data": traces, "layout": _layout(figure, list(shown), width)}


def _styles(figure: Figure) -> dict[str, Style]:
    """A colour and a mark for each label, the same in every panel."""
    series = [series for panel in figure.panels for series in panel.series]
    names = list(dict.fromkeys(each.label for each in series))
    if any(each.kind == "history" for each in series):
        return STYLES | {
            name: Style(_on_ramp(place, len(names)), "circle") for place, name in enumerate(names)
        }
    coloured = [name for name in names if name not in STYLES]
    marks = SYMBOLS + AGAIN
    return STYLES | {
        name: Style(
            COLOURS[place % len(COLOURS)],
            marks[place % len(marks)],
            dash="solid" if place < len(COLOURS) else "dash",
        )
        for place, name in enumerate(coloured)
    }


def _on_ramp(place: int, count: int) -> str:
    """A colour of the ramp, mixed between its steps."""
    at = (len(RAMP) - 1) * place / max(1, count - 1)
    low = min(int(at), len(RAMP) - 2)
    pairs = zip(_channels(RAMP[low]), _channels(RAMP[low + 1]), strict=True)
    return "#" + "".join(f"{round(a + (b - a) * (at - low)):02x}" for a, b in pairs)


def _channels(colour: str) -> list[int]:
    return [int(colour[place : place + 2], 16) for place in (1, 3, 5)]


def _placed(trace: Trace, label: str, style: Style, panel: int, shown: set[str]) -> Trace:
    """The trace in its panel; a label enters the legend once in a figure."""
    suffix = "" if panel == 1 else str(panel)
    first = trace.pop("named", False) and label not in shown
    if first:
        shown.add(label)
    return {
        "type": "scatter",
        "name": label,
        "legendgroup": label,
        **trace,
        "xaxis": f"x{suffix}",
        "yaxis": f"y{suffix}",
        "showlegend": first,
        "legendrank": style.rank,
    }


# ---- traces --------------------------------------------------------------------------------------


def scaled(values: Sequence[Any], scale: Scale) -> list[Any]:
    """Values in the display unit; words and gaps as they are."""
    factor = display_of(scale.unit).factor
    return [value * factor if isinstance(value, float | int) else value for value in values]


def _traces(series: Series, style: Style, figure: Figure, has_range: bool) -> Iterator[Trace]:
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
    if any(
        is_open and not flags for is_open, flags in zip(series.flagged, series.doubts, strict=False)
    ):
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


def _shade(
    x: Sequence[Any], y: Sequence[Any], window: Sequence[float], style: Style
) -> Iterator[Trace]:
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
    return any(
        value is not None and not inside
        for inside, value in zip(series.in_range, values, strict=True)
    )


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
        "textposition": [
            "bottom right" if place < len(x) / 2 else "bottom left" for place in doubted
        ],
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
        "line": {
            "color": style.colour,
            "width": 1.4 if dotted else 2.0,
            "dash": "dot" if dotted else style.dash,
        },
        "marker": {"color": style.colour, "size": 7, "symbol": symbol, "line": {"width": 1.2}},
        "hoverinfo": "skip",
    }


def _strokes(
    x: Sequence[Any], y: Sequence[Any], inside: Sequence[bool], style: Style
) -> Iterator[Trace]:
    """As the style has it between two points inside the range, dotted elsewhere."""
    for solid, width, dash in ((True, 2.0, style.dash), (False, 1.4, "dot")):
        pairs = [
            place
            for place in range(len(x) - 1)
            if y[place] is not None
            and y[place + 1] is not None
            and (inside[place] and inside[place + 1]) == solid
        ]
        if pairs:
            yield {
                "mode": "lines",
                "x": [at for place in pairs for at in (x[place], x[place + 1], None)],
                "y": [at for place in pairs for at in (y[place], y[place + 1], None)],
                "line": {"color": style.colour, "width": width, "dash": dash},
                "hoverinfo": "skip",
            }


def _band(
    x: Sequence[Any], low: Sequence[Any], high: Sequence[Any], series: Series, style: Style
) -> Iterator[Trace]:
    """A shaded area with its edges; bars where a line through the points means nothing."""
    complete = [
        place for place in range(len(x)) if low[place] is not None and high[place] is not None
    ]
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
    red, green, blue = _channels(style.colour)
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


# ---- layout --------------------------------------------------------------------------------------


def _layout(figure: Figure, entries: Sequence[str], width: int) -> dict[str, Any]:
    most = max(1, (width - 76) // PANEL_WIDTH)
    columns = min({1: 1, 2: 2, 4: 2}.get(len(figure.panels), 3), most)
    rows = math.ceil(len(figure.panels) / columns)
    height = (WIDE_HEIGHT if len(figure.panels) == 1 else PANEL_HEIGHT) * rows
    legend = LEGEND_LINE * math.ceil(len(entries) / max(1, width // LEGEND_ENTRY)) + 18
    across = int((width - 76) / columns / LETTER)
    titles = [wrap(panel.title, across) for panel in figure.panels]
    lines = max(map(len, titles), default=0) - 1
    notes = NOTE_LINE * (max(0, lines) + any(panel.note for panel in figure.panels))
    layout: dict[str, Any] = {
        "width": width,
        "height": height + legend + notes,
        "margin": {"l": 64, "r": 12, "t": ABOVE + notes, "b": BELOW + legend},
        "paper_bgcolor": "rgba(0,0,0,0)",
        "plot_bgcolor": "rgba(0,0,0,0)",
        "font": {"family": "Helvetica, Arial, sans-serif", "size": 13, "color": INK},
        "legend": {
            "orientation": "h",
            "x": 0,
            "y": -58 / (height - ABOVE - BELOW),
            "yanchor": "top",
            "itemclick": False,
            "itemdoubleclick": False,
        },
        "hoverlabel": {"font": {"size": 12}},
        "annotations": [],
    }
    own = figure.scales == "own"
    space = GAP_WITH_NUMBERS * WIDTH / width if own else GAP
    part = (1 - space * (columns - 1)) / columns
    gap = (ROW_GAP + notes) / (PANEL_HEIGHT * rows - ABOVE - BELOW) if rows > 1 else 0.0
    tall = (1 - gap * (rows - 1)) / rows
    for number, panel in enumerate(figure.panels):
        suffix = "" if number == 0 else str(number + 1)
        row, column = divmod(number, columns)
        left, top = column * (part + space), 1 - row * (tall + gap)
        layout[f"xaxis{suffix}"] = {
            **_axis(with_unit(figure.x.label, figure.x.unit), _x_range(figure)),
            "domain": [left, left + part],
            "anchor": f"y{suffix}",
            **({"type": "category"} if figure.x.unit is None else {}),
            **(_cell_ticks(panel) if figure.x.name == "spacing" else {}),
        }
        label = with_unit(figure.y.label, figure.y.unit) if column == 0 else ""
        limits = _own_range(figure, panel) if own else _y_range(figure)
        layout[f"yaxis{suffix}"] = {
            **_axis(label, limits),
            "domain": [top - tall, top],
            "anchor": f"x{suffix}",
            "showticklabels": column == 0 or own,
            **(_percent_ticks(*limits) if figure.y.name == "residual" and limits else {}),
        }
        layout["annotations"].append(_title(panel, titles[number], left, top))
    return layout


def _percent_ticks(low: float, high: float) -> dict[str, Any]:
    """Ticks of signed shares: "-10 %", "0 %", "+10 %"."""
    rough = max(high - low, 1e-9) / MOST_TICKS
    power = 10.0 ** math.floor(math.log10(rough))
    step = next(power * factor for factor in (1, 2, 5, 10) if power * factor >= rough)
    values = [number * step for number in range(math.ceil(low / step), math.floor(high / step) + 1)]
    places = max(0, -math.floor(math.log10(100.0 * step * (1.0 + 1e-9))))
    texts = [f"{signed(100.0 * value, places)}{NARROW_SPACE}%" for value in values]
    return {"tickvals": values, "ticktext": texts}


def _title(panel: Panel, lines: Sequence[str], left: float, top: float) -> dict[str, Any]:
    """The title of a panel, with its note on a further line."""
    return {
        "text": f"<b>{'<br>'.join(lines)}</b>" + (f"<br>{panel.note}" if panel.note else ""),
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


def _axis(label: str, limits: tuple[float, float] | None) -> dict[str, Any]:
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
        "title": {"text": label, "standoff": 8, "font": {"size": 13}},
        **({} if limits is None else {"range": list(limits)}),
    }


def _cell_ticks(panel: Panel) -> dict[str, Any]:
    """A tick at each resolution, in the words in which people ask for it: 1/32 of a diameter."""
    levels = [series for series in panel.series if series.kind == "level"]
    sizes = sorted({x for series in levels for x in series.x if isinstance(x, float)})
    apart: list[float] = []
    for size in reversed(sizes):
        nearest = min([size, *(other - size for other in apart)])
        if nearest >= TICK_APART * (apart[0] if apart else size):
            apart.append(size)
    return {
        "tickvals": [0.0, *apart],
        "ticktext": ["0", *(f"1/{1.0 / size:.4g}" for size in apart)],
        "tickangle": 0,
    }


def _x_range(figure: Figure) -> tuple[float, float] | None:
    """All points with a margin; time begins at zero."""
    if figure.x.unit is None:
        return None
    series = [series for panel in figure.panels for series in panel.series]
    values = [x for each in series for x in scaled(each.x, figure.x) if isinstance(x, float)]
    if not values:
        return None
    timed = figure.x.name == "time"
    low, high = 0.0 if timed else min(values), max(values)
    margin = 0.06 * (high - low) or 0.1 * abs(high) or 1.0
    return (low if timed else low - margin, high + margin)


def _y_range(figure: Figure) -> tuple[float, float] | None:
    """Zero, and every mark of simulation, observations and laws inside their range; every mark where there is none."""
    factor = display_of(figure.y.unit).factor
    ends = [end * factor for panel in figure.panels for end in _weighty_ends(panel)]
    if not ends:
        ends = [top * factor for panel in figure.panels for top in _ends(panel, +1.0, bands=True)]
    if not ends:
        return None
    low, high = min(0.0, *ends), max(0.0, *ends)
    margin = HEADROOM * (high - low) or 1.0
    return (low - margin if low < 0 else low, high + margin)


def _weighty_ends(panel: Panel) -> Iterator[float]:
    """Ends of bars and bands, without what a law gives outside its range."""
    for series in panel.series:
        inside = series.in_range or (True,) * len(series.x)
        bars = series.uncertainty or (None,) * len(series.y)
        for y, bar, counts in zip(series.y, bars, inside, strict=False):
            if y is not None and counts:
                yield y + (bar or 0.0)
                yield y - (bar or 0.0)
        for low, high, counts in zip(series.low, series.high, inside, strict=False):
            if low is not None and high is not None and counts:
                yield low
                yield high


def _own_range(figure: Figure, panel: Panel) -> tuple[float, float] | None:
    """About the panel's own middle, as wide in per cent as the panel that needs most."""
    mine = _span(panel)
    if mine is None:
        return None
    spans = [span for span in map(_span, figure.panels) if span is not None]
    half = max(
        0.5 * (high - low) / abs(0.5 * (high + low)) if high + low else 0.0 for low, high in spans
    )
    middle = 0.5 * (mine[0] + mine[1]) * display_of(figure.y.unit).factor
    reach = abs(middle) * half * (1.0 + 2.0 * HEADROOM) or 1.0
    return (middle - reach, middle + reach)


def _span(panel: Panel) -> tuple[float, float] | None:
    """Lowest and highest mark of a panel, bars and bands included."""
    ends = [*_ends(panel, +1.0, bands=True), *_ends(panel, -1.0, bands=False)]
    return (min(ends), max(ends)) if ends else None


def _ends(panel: Panel, sign: float, *, bands: bool) -> Iterator[float]:
    """Upper (+1) or lower (-1) ends of the points' error bars, and the edges of bands."""
    for series in panel.series:
        bars = series.uncertainty or (None,) * len(series.y)
        for y, bar in zip(series.y, bars, strict=True):
            if y is not None:
                yield y + sign * (bar or 0.0)
        if bands:
            yield from (edge for edge in (*series.low, *series.high) if edge is not None)
