"""The marks of a series in its panel: points, lines, bands, bars, rings, what they say, and entries of the legend."""

import math
from collections.abc import Iterator, Sequence
from itertools import pairwise

import numpy as np
from matplotlib.axes import Axes
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

from studies.quantities.display import digits, display_of
from studies.reports.drawing.canvas import KIND, SAYS
from studies.reports.drawing.styles import (
    FLAGGED,
    LOOKS,
    NO_MESH_ERROR,
    OUTSIDE,
    STYLES,
    WINDOW,
    WITH_MODELS,
    Look,
    Style,
)
from studies.reports.figure import MUTED, Figure, Numbers, Scale, Series

# points
STROKE, THIN = 1.5, 1.0  # lines of laws, inside and outside of their range
SHADE = 10.0  # breadth of the pale line over the window
RING, RING_STROKE = 12.0, 1.8  # about a flagged point
BAND_BAR = 4.0  # breadth of a band where a line through the points means nothing
LABEL_APART = 6.0  # between a mark and its label
BEHIND, LINES, POINTS, RINGS = 1.0, 2.0, 3.0, 4.0  # order of drawing
MOST_LABELS = 4  # flagged points of a panel that are labelled; beyond, they are ringed alone


def scaled(values: Sequence[float | str | None], scale: Scale) -> np.ndarray:
    """Values in the display unit; NaN for gaps."""
    return np.array([math.nan if value is None else value for value in values], float) * display_of(scale.unit).factor


class Marks:
    """Draws the series of a figure into panels, and gathers the entries of its legend."""

    def __init__(self, figure: Figure, styles: dict[str, Style]):
        self.figure = figure
        self.styles = styles
        self.entries: dict[str, Line2D | Patch] = {}  # of the legend: what stands before each label
        every = [series for panel in figure.panels for series in panel.series]
        # Of the abscissa, where it has words: their places are its numbers.
        self.words = list(dict.fromkeys(str(x) for series in every for x in series.x)) if figure.x.unit is None else []
        self._ranged = {line.label for line in every if any(line.in_range) or line.kind not in ("law", "band")}

    def draw(self, axes: Axes, series: Series) -> None:
        """Draw a series."""
        style, look = self.styles[series.label], LOOKS.get(series.kind, Look())
        x, y = self._abscissa(series.x), scaled(series.y, self.figure.y)
        if series.kind == "band":
            self._band(axes, series, style, x)
            return
        if series.kind == "missing":
            y = np.full(len(x), axes.get_ylim()[0])
        if series.window:
            self._shade(axes, x, y, scaled(series.window, self.figure.x), style)
        if series.kind in ("law", "curve") and series.connected:
            _strokes(axes, x, y, series.in_range, style)
        elif look.stroke and series.connected:
            axes.plot(x, y, style.dash, color=style.colour, linewidth=look.stroke, zorder=LINES)
        for bars, width, cap in ((series.outer, 0.9, 0.0), (series.uncertainty, 1.3, 3.0)):
            if any(bars):
                half = np.nan_to_num(scaled(bars, self.figure.y))
                axes.errorbar(x, y, half, fmt="none", ecolor=style.colour, elinewidth=width, capsize=cap, zorder=LINES)
        if series.kind == "observation" and series.low:
            self._spans(axes, series, style, x)
        if look.size and not (series.muted and series.connected and len(x) > 1):
            self._points(axes, series, style, look, x, y)
        self._name(series, style, look)
        doubted = [place for place, flags in enumerate(series.doubts) if flags and np.isfinite(y[place])]
        if doubted:
            self._rings(axes, series, x, y, doubted)

    def _abscissa(self, values: Sequence[float | str | None]) -> np.ndarray:
        if self.words:
            return np.array([self.words.index(str(value)) for value in values], float)
        return scaled(values, self.figure.x)

    def _points(self, axes: Axes, series: Series, style: Style, look: Look, x: np.ndarray, y: np.ndarray) -> None:
        """A mark for each point: open where a simulation is flagged, or a law is outside its range."""
        filled = [not flag for flag in series.flagged] or series.in_range or [not style.is_open] * len(x)
        faces = [style.colour if is_filled else "none" for is_filled in filled]
        marks = axes.scatter(x, y, look.size**2, marker=style.marker, linewidths=look.ring, color=style.colour)
        marks.set(clip_on=look.clipped, zorder=POINTS)
        if style.marker != "x":
            marks.set_facecolor(faces)
        marks.set_urls([SAYS + text for text in self._texts(series)])

    def _texts(self, series: Series) -> Iterator[str]:
        """What points say where a reader points at them: label, place, value with its bar, and words."""
        x, y = self.figure.x, self.figure.y
        for place, at in enumerate(series.x):
            parts = [at if isinstance(at, str) else _read(at, x)]
            if series.y and series.y[place] is not None:
                bar = series.uncertainty[place] if series.uncertainty else None
                parts.append(_read(series.y[place], y, bar))
            parts += [words[place] for words in (series.notes, series.doubts) if words and words[place]]
            yield f"{series.label}: {', '.join(parts)}"

    def _name(self, series: Series, style: Style, look: Look) -> None:
        """Enter a series into the legend, and what its marks mean."""
        if series.kind in ("law", "curve") and not series.muted and _is_drawn_outside(series, series.y):
            self._enter(OUTSIDE, _entry(STYLES[OUTSIDE], stroke=THIN))
        if series.muted:
            self._enter(MUTED, _entry(STYLES[MUTED], stroke=THIN, marked=False))
            return
        if any(series.outer):
            self._enter(WITH_MODELS, _entry(STYLES[WITH_MODELS], stroke=0.9, marked=False))
        if any(is_open and not flags for is_open, flags in zip(series.flagged, series.doubts, strict=False)):
            self._enter(NO_MESH_ERROR, _entry(STYLES[NO_MESH_ERROR], stroke=0.0))
        stroke = look.stroke or THIN * (series.kind == "law")
        if look.own_entry:
            has_range = series.label in self._ranged
            self._enter(series.label, _entry(style, stroke=series.connected * stroke, dotted=not has_range))
        else:
            self._enter(series.label, _entry(style, stroke=stroke, marked=bool(look.size)))

    def _enter(self, label: str, handle: Line2D | Patch) -> None:
        self.entries.setdefault(label, handle)

    def name_laws(self, axes: Axes, series: Sequence[Series]) -> None:
        """The names of the laws in colour at their last points in the frame, the higher above its line."""
        low, high = axes.get_ylim()
        ends = []
        for law in (line for line in series if line.kind == "law" and not line.muted):
            x, y = self._abscissa(law.x), scaled(law.y, self.figure.y)
            inside = np.flatnonzero(np.isfinite(y) & (y >= low) & (y <= high))
            if len(inside):
                ends.append((float(y[inside[-1]]), float(x[inside[-1]]), law.label))
        for place, (y_end, x_end, label) in enumerate(sorted(ends)):
            is_below = place == 0 and len(ends) > 1
            apart = (2.0, -LABEL_APART if is_below else LABEL_APART)
            name = axes.annotate(label, (x_end, y_end), apart, textcoords="offset points", gid=f"{KIND}named")
            name.set(ha="right", va="top" if is_below else "bottom", size=9.0, weight="bold", zorder=RINGS)
            name.set_color(self.styles[label].colour)

    def _spans(self, axes: Axes, series: Series, style: Style, x: np.ndarray) -> None:
        """Published ranges, as bars between their ends; an open end lies at the frame."""
        low, high = scaled(series.low, self.figure.y), scaled(series.high, self.figure.y)
        ranges = np.array([y is None for y in series.y]) & (np.isfinite(low) | np.isfinite(high))
        bottom, top = axes.get_ylim()
        low, high = np.where(np.isfinite(low), low, bottom)[ranges], np.where(np.isfinite(high), high, top)[ranges]
        middle = 0.5 * (low + high)
        half = 0.5 * (high - low)
        colour, width = style.colour, BAND_BAR
        axes.errorbar(
            x[ranges], middle, half, fmt="none", ecolor=colour, elinewidth=width, capsize=5.0, alpha=0.6, zorder=LINES
        )

    def _shade(self, axes: Axes, x: np.ndarray, y: np.ndarray, window: np.ndarray, style: Style) -> None:
        """The part of a line inside a window of the abscissa, broad and pale."""
        known = np.isfinite(y)
        x, y = x[known], y[known]
        inside = x > window[0]
        if len(x) < 2 or not inside.any():
            return
        begin = max(x[0], window[0])
        shaded = [[begin, *x[inside]], [np.interp(begin, x, y), *y[inside]]]
        axes.plot(*shaded, color=style.colour, alpha=0.3, linewidth=SHADE, zorder=BEHIND, gid="kind:shade")
        self._enter(WINDOW, Line2D([], [], color=STYLES[WINDOW].colour, alpha=0.3, linewidth=SHADE))

    def _rings(self, axes: Axes, series: Series, x: np.ndarray, y: np.ndarray, doubted: Sequence[int]) -> None:
        """A ring about each flagged point, with its flags beside it."""
        colour = STYLES[FLAGGED].colour
        rings = axes.scatter(x[doubted], y[doubted], RING**2, facecolors="none", edgecolors=colour, zorder=RINGS)
        rings.set(linewidths=RING_STROKE, clip_on=False)
        self._enter(FLAGGED, _entry(STYLES[FLAGGED], stroke=0.0))
        if len(doubted) > MOST_LABELS or series.kind != "simulation":
            return
        for place in {series.doubts[place]: place for place in reversed(doubted)}.values():  # each flag once
            # Towards the middle of the panel, so that no label is cut.
            side, anchor = (1.0, "left") if place < len(x) / 2 else (-1.0, "right")
            text, apart = series.doubts[place].replace(", ", ",\n"), (side * LABEL_APART, -LABEL_APART)
            label = axes.annotate(text, (x[place], y[place]), apart, textcoords="offset points")
            label.set(ha=anchor, va="top", color=colour, size=9.0)

    def _band(self, axes: Axes, series: Series, style: Style, x: np.ndarray) -> None:
        """A shaded area with its edges; bars where a line through the points means nothing."""
        low, high = scaled(series.low, self.figure.y), scaled(series.high, self.figure.y)
        complete = np.isfinite(low) & np.isfinite(high)
        dotted = not any(series.in_range)
        if series.connected and complete.sum() > 1:
            axes.fill_between(x[complete], low[complete], high[complete], color=style.colour, alpha=0.2, linewidth=0)
            for edge in (low, high):
                _strokes(axes, x, edge, series.in_range, style)
            patch = Patch(facecolor=(style.colour, 0.2), edgecolor=style.colour, linestyle=":" if dotted else "-")
            self._enter(series.label, patch)
        else:
            axes.vlines(x[complete], low[complete], high[complete], color=style.colour, alpha=0.5, linewidth=BAND_BAR)
            self._enter(series.label, Line2D([], [], color=style.colour, alpha=0.5, linewidth=BAND_BAR))
        if _is_drawn_outside(series, series.low):
            self._enter(OUTSIDE, _entry(STYLES[OUTSIDE], stroke=THIN))


def _read(value: float | None, scale: Scale, bar: float | None = None) -> str:
    """A number of an axis with its bar and its unit: "5.31 ± 0.12 km/s"."""
    display = display_of(scale.unit)
    numbers = [digits(number * display.factor) for number in (value, bar) if number is not None]
    return f"{' ± '.join(numbers)} {display.unit}".rstrip()


def _entry(style: Style, *, stroke: float, marked: bool = True, dotted: bool = False) -> Line2D:
    """How a label looks, inside its range or (open, dotted) outside."""
    line = Line2D([], [], color=style.colour, marker=style.marker if marked else "none", markersize=5.3)
    line.set(linewidth=stroke, linestyle=(":" if dotted else style.dash) if stroke else "none")
    line.set(markeredgewidth=1.0, markerfacecolor="none" if style.is_open or dotted else style.colour)
    return line


def _is_drawn_outside(series: Series, values: Numbers) -> bool:
    """Whether a law has a value outside of its range."""
    return any(value is not None and not inside for inside, value in zip(series.in_range, values, strict=True))


def _strokes(axes: Axes, x: np.ndarray, y: np.ndarray, inside: Sequence[bool], style: Style) -> None:
    """As the style has it between two points inside the range, dotted elsewhere."""
    solid = np.array([a and b for a, b in pairwise(inside)], bool)
    for shown, width, dash in ((solid, STROKE, style.dash), (~solid, THIN, ":")):
        gaps = np.full(len(solid), np.nan)
        points = np.stack([np.stack([ends[:-1], ends[1:], gaps], axis=-1)[shown].ravel() for ends in (x, y)])
        if np.isfinite(points).all(axis=0).any():
            axes.plot(*points, dash, color=style.colour, linewidth=width, zorder=LINES)
