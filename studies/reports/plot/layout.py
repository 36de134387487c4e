"""The layout of a figure: its panels side by side or in rows, their axes, ranges, ticks and titles, the legend."""

import math
import re
from collections.abc import Iterator, Sequence
from textwrap import wrap
from typing import Any

from studies.reports.figures import Figure, Panel
from studies.reports.plot.styles import GREY, INK, RULE
from studies.reports.plot.traces import scaled
from studies.reports.view import is_cut
from studies.values.formats import NARROW_SPACE, display_of, signed, with_unit

# px
WIDTH = 1000  # the text width of the page
# Widths for which a page has layouts: a screen, a tablet or a sheet of A4, a telephone.
WIDTHS = (WIDTH, 700, 340)
LEGEND_MARK = 44  # width of the mark before an entry of the legend, with the space around both
LEGEND_LETTER = 7.6  # width of a letter of the legend, on average
LEGEND_COLUMNS = 3  # at most, in a file for print
NARROW = 500  # below it the legend begins at the left edge, in smaller letters
LEFT, RIGHT = 64, 12  # beside the panels
PANEL_WIDTH = 300  # least width of a panel
LETTER = 9.0  # width of a letter of a title, on average in the widest of usual fonts
PANEL_HEIGHT = 380
LOW_HEIGHT = 270  # height of each of more than two rows, so that three of them fit a sheet of A4
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


def layout_of(figure: Figure, panels: Sequence[Panel], entries: Sequence[str], width: int) -> dict[str, Any]:
    """The layout of some panels of a figure; ``entries`` are those of the legend."""
    inside = width - LEFT - RIGHT
    columns = min({1: 1, 2: 2, 4: 2}.get(len(panels), 3), max(1, inside // PANEL_WIDTH))
    rows = math.ceil(len(panels) / columns)
    own = figure.scales == "own"
    space = GAP_WITH_NUMBERS * WIDTH / width if own else GAP
    part = (1 - space * (columns - 1)) / columns
    low = columns > 1 and rows > 2
    of_row = LOW_HEIGHT if low else WIDE_HEIGHT if len(panels) == 1 else PANEL_HEIGHT
    height = of_row * rows
    legend = LEGEND_LINE * _legend_lines(entries, inside) + 18
    titles = [wrap(_bound(panel.title), int(part * inside / LETTER)) for panel in panels]
    lines = max(map(len, titles), default=0) - 1
    notes = NOTE_LINE * (max(0, lines) + any(panel.note for panel in panels))
    layout: dict[str, Any] = {
        "width": width,
        "height": height + legend + notes,
        "margin": {"l": LEFT, "r": RIGHT, "t": ABOVE + notes, "b": BELOW + legend},
        "paper_bgcolor": "rgba(0,0,0,0)",
        "plot_bgcolor": "rgba(0,0,0,0)",
        "font": {"family": "Helvetica, Arial, sans-serif", "size": 13, "color": INK},
        "legend": {
            "orientation": "h",
            **({"x": -LEFT / inside, "font": {"size": 12}} if width < NARROW else {"x": 0}),
            "y": -58 / (height - ABOVE - BELOW),
            "yanchor": "top",
            "itemclick": False,
            "itemdoubleclick": False,
        },
        "hoverlabel": {"font": {"size": 12}},
        "annotations": [],
    }
    gap = (ROW_GAP + notes) / (height - ABOVE - BELOW) if rows > 1 else 0.0
    tall = (1 - gap * (rows - 1)) / rows
    for number, panel in enumerate(panels):
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


def _bound(title: str) -> str:
    """A title in which no line break parts a number from its unit."""
    return re.sub(r"(?<=\d) (?=[^\W\d])", "\u00a0", title)


def _legend_lines(entries: Sequence[str], width: float) -> int:
    """Lines that the legend needs in some width (px): its columns are as wide as its longest entry."""
    lines = [entry.split("<br>") for entry in entries]
    longest = max((len(line) for each in lines for line in each), default=0)
    columns = max(1, min(LEGEND_COLUMNS, int(width / (LEGEND_MARK + LEGEND_LETTER * longest))))
    rows = (lines[first : first + columns] for first in range(0, len(lines), columns))
    return sum(max(map(len, row)) for row in rows)


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
    return {"tickvals": [0.0, *apart], "ticktext": ["0", *(f"1/{1.0 / size:.4g}" for size in apart)], "tickangle": 0}


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
    """Ends of bars and bands, without bars that the frame cuts and what a law gives outside its range."""
    for series in panel.series:
        inside = series.in_range or (True,) * len(series.x)
        bars = series.uncertainty or (None,) * len(series.y)
        for y, bar, counts in zip(series.y, bars, inside, strict=False):
            if y is not None and counts:
                reach = 0.0 if bar is None or is_cut(y, bar) else bar
                yield y + reach
                yield y - reach
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
    half = max(0.5 * (high - low) / abs(0.5 * (high + low)) if high + low else 0.0 for low, high in spans)
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
