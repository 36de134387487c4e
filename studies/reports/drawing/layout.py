"""The layout of a figure: its panels in rows, their axes, ranges, ticks and titles; sizes in points."""

import math
import re
from collections.abc import Iterator, Sequence
from textwrap import wrap

from matplotlib.axes import Axes
from matplotlib.figure import Figure as Drawing
from matplotlib.legend import Legend

from studies.quantities.display import display_of, with_unit
from studies.reports.drawing.canvas import GREY, number
from studies.reports.drawing.marks import scaled
from studies.reports.figure import Figure, Panel, is_cut

# Widths of the drawings of a page: of a screen, a tablet or a sheet of paper, and of a telephone.
WIDTHS = {"wide": 750.0, "narrow": 255.0}
LEFT, RIGHT = 50.0, 6.0  # beside the panels
PANEL_WIDTH = 225.0  # least width of a panel
LETTER = 6.8  # width of a letter of a title, on average in the widest of usual fonts
# Height of a row: of a figure with one panel, of one or two rows, of more, so that three of them fit a sheet of A4.
HEIGHTS = (320.0, 285.0, 200.0)
FLATTEST = 0.6  # height of a single panel at most, in its width
BELOW = 40.0  # a row of panels: numbers and the label of the axis
TITLE_LINE = 13.0
UNDER = 6.0  # below the legend
GAP, GAP_WITH_NUMBERS = 22.0, 46.0  # between panels of a row; where each has numbers beside it
TICK_APART = 0.1  # numbers that are nearer run into each other
NEAR_ZERO = 0.3  # an axis begins at zero where its lowest mark is below this share of the highest
HEADROOM = 0.08  # above the highest point


class Grid:
    """The places of some panels of a figure."""

    def __init__(self, figure: Figure, panels: Sequence[Panel], width: float):
        self._width = width
        self._gap = GAP_WITH_NUMBERS if figure.scales == "own" else GAP
        inside = width - LEFT - RIGHT
        self.columns = min({1: 1, 2: 2, 4: 2}.get(len(panels), 3), max(1, int(inside // PANEL_WIDTH)))
        self._rows = math.ceil(len(panels) / self.columns)
        self._part = (inside - self._gap * (self.columns - 1)) / self.columns
        self._notes = [panel.note for panel in panels]
        # No line break parts a number from its unit.
        bound = (re.sub(r"(?<=\d) (?=[^\W\d])", "\u00a0", panel.title) for panel in panels)
        self._titles = [wrap(title, int(self._part / LETTER)) for title in bound]
        lines = max(len(title) + bool(note) for title, note in zip(self._titles, self._notes, strict=True))
        self._above = TITLE_LINE * lines + 6.0
        low = self.columns > 1 and self._rows > 2
        self._of_row = HEIGHTS[2 if low else 1] if len(panels) > 1 else min(HEIGHTS[0], FLATTEST * width)
        self.height = self._rows * (self._above + self._of_row + BELOW)  # without the legend

    def title(self, axes: Axes, place: int) -> None:
        """Write the title above a panel, and its note on a further line."""
        note = self._notes[place]
        axes.set_title("\n".join(self._titles[place]), pad=6.0 + TITLE_LINE * bool(note))
        axes.annotate(note, (0.0, 1.0), (0.0, 6.0), xycoords="axes fraction", textcoords="offset points")

    def place(self, drawing: Drawing, legend: Legend) -> None:
        """Place the panels above the legend, for which the drawing grows."""
        below = legend.get_window_extent().height + UNDER
        height = self.height + below
        drawing.set_size_inches(self._width / 72.0, height / 72.0)
        legend.set_bbox_to_anchor((LEFT / self._width if self._width > 2 * PANEL_WIDTH else 0.0, UNDER / height))
        for place, axes in enumerate(drawing.axes):
            row, column = divmod(place, self.columns)
            left = LEFT + column * (self._part + self._gap)
            top = height - row * (self._above + self._of_row + BELOW) - self._above
            size = self._part / self._width, self._of_row / height
            axes.set_position((left / self._width, (top - self._of_row) / height, *size))


def prepare(axes: Axes, figure: Figure, panel: Panel, words: Sequence[str], has_label: bool) -> None:
    """Range, ticks and label of both axes; ``words`` are those of an abscissa without numbers."""
    own = figure.scales == "own"
    axes.set_xlabel(with_unit(figure.x.label, figure.x.unit))
    if has_label:
        axes.set_ylabel(with_unit(figure.y.label, figure.y.unit))
    axes.tick_params(axis="y", labelleft=has_label or own)
    axes.xaxis.set_major_formatter(number)
    axes.yaxis.set_major_formatter(number)
    if figure.x.name == "spacing":
        sizes = _cell_sizes(panel)
        axes.set_xticks([0.0, *sizes], ["0", *(f"1/{1.0 / size:.4g}" for size in sizes)])
    if words:
        axes.set_xticks(range(len(words)), words)
        axes.set_xlim(-0.5, len(words) - 0.5)
    elif limits := _x_range(figure):
        axes.set_xlim(*limits)
    if limits := _own_range(figure, panel) if own else _y_range(figure):
        axes.set_ylim(*limits)
        if limits[0] < 0.0 < limits[1]:
            axes.axhline(0.0, color=GREY, linewidth=0.75, zorder=0.5)


def _cell_sizes(panel: Panel) -> list[float]:
    """The resolutions of a panel, coarsest first, as far apart as their numbers need."""
    levels = [series for series in panel.series if series.kind == "level"]
    apart: list[float] = []
    for size in sorted({x for series in levels for x in series.x if isinstance(x, float)}, reverse=True):
        nearest = min([size, *(other - size for other in apart)])
        if nearest >= TICK_APART * (apart[0] if apart else size):
            apart.append(size)
    return apart


def _x_range(figure: Figure) -> tuple[float, float] | None:
    """All points with a margin; time begins at zero."""
    if figure.x.unit is None:
        return None
    series = [series for panel in figure.panels for series in panel.series]
    values = [x for line in series for x in scaled(line.x, figure.x) if math.isfinite(x)]
    if not values:
        return None
    timed = figure.x.name == "time"
    low, high = 0.0 if timed else min(values), max(values)
    margin = 0.06 * (high - low) or 0.1 * abs(high) or 1.0
    return (low if timed else low - margin, high + margin)


def _y_range(figure: Figure) -> tuple[float, float] | None:
    """Every mark of simulation, measured shots and nearest laws; with zero where it is near, or of a share."""
    factor = display_of(figure.y.unit).factor
    for every in (False, True):
        ends = [end * factor for panel in figure.panels for end in _ends(panel, every=every)]
        if ends:
            break
    else:
        return None
    low, high = min(ends), max(ends)
    if low < NEAR_ZERO * high:
        low = min(0.0, low)
    if high < NEAR_ZERO * low:
        high = max(0.0, high)
    margin = HEADROOM * (high - low) or HEADROOM * abs(high) or 1.0
    return (low if low == 0.0 else low - margin, high + margin)


def _ends(panel: Panel, *, every: bool = False) -> Iterator[float]:
    """Ends of bars and bands, without bars that the frame cuts; of laws all, or the nearest ones inside their range."""
    for series in panel.series:
        if series.muted and not every:
            continue
        inside = (not every and series.in_range) or (True,) * len(series.x)
        bars = series.outer or series.uncertainty or (None,) * len(series.y)
        for y, bar, counts in zip(series.y, bars, inside, strict=False):
            if y is not None and counts:
                reach = 0.0 if bar is None or is_cut(y, bar) else bar
                yield y + reach
                yield y - reach
        for low, high, counts in zip(series.low, series.high, inside, strict=False):
            if counts:
                yield from (end for end in (low, high) if end is not None)


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
    ends = [*_ends(panel)]
    return (min(ends), max(ends)) if ends else None
