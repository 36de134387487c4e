"""Figures of a report as files for print: PNG, SVG or PDF, drawn by Matplotlib, which needs no network and no browser.

A Plotly specification of ``plot`` is drawn with its own axes, ranges, colours and marks, so that page and file show the
same; Kaleido, which would draw it too, brings a Chromium. Matplotlib comes with ``whipple[plot]``.
"""

import html
import math
import re
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, Literal

import xarray as xr

from studies.cubes.reading import of_any_schema
from studies.reports import compare
from studies.reports.figures import figures
from studies.reports.plot import plot
from studies.reports.plot.layout import LEGEND_COLUMNS
from studies.reports.plot.styles import FLAGGED
from studies.values.errors import Finding, InvalidInput, MissingExtra
from studies.values.files import CUBE, write_atomically

Format = Literal["png", "svg", "pdf"]
FORMATS: tuple[Format, ...] = ("png", "svg", "pdf")

PIXELS = 96.0  # of a specification, in an inch
POINT = 72.0 / PIXELS  # a pixel in typographic points
SHARP = 2.0  # pixels of a PNG for each pixel of the specification
LABEL_APART = 6.0  # points, between a mark and its label
TITLE_LINE = 16.0  # px
# Plotly's names of marks; "-open" and "-thin" may follow.
MARKERS = {
    "circle": "o",
    "square": "s",
    "triangle-up": "^",
    "triangle-down": "v",
    "diamond": "D",
    "star-diamond": "P",
    "hexagon": "h",
    "star": "*",
    "x": "x",
    "cross": "+",
    "pentagon": "p",
    "bowtie": "1",
}
DASHES = {"solid": "-", "dot": ":", "dash": "--", "dashdot": "-."}


def draw_figures(cube: Path, folder: Path, format: Format) -> list[Path]:
    """Draw every figure of a cube into a folder, each in a file named after it; the files.

    ``cube`` is a cube.nc or the folder of one. Raises InvalidInput where it is none, MissingExtra without Matplotlib.
    """
    file = cube / CUBE if cube.is_dir() else cube
    try:
        dataset = xr.open_dataset(file)
    except (OSError, ValueError):
        raise _no_cube(file, "not a NetCDF file that can be read") from None
    with dataset:
        if "quantities" not in dataset.attrs:
            raise _no_cube(file, "a NetCDF file without the attributes of a cube")
        dataset = of_any_schema(dataset)
        drawn = figures(dataset, compare.compare(dataset))
    return [draw(plot(each), folder / f"{each.name}.{format}") for each in drawn]


def draw(specification: Mapping[str, Any], file: Path) -> Path:
    """Draw a Plotly specification into a file, whose ending is its format; raises MissingExtra."""
    try:
        from matplotlib.figure import Figure
    except ImportError:
        raise MissingExtra("drawing figures needs Matplotlib: pip install 'whipple[plot]'") from None
    layout = specification["layout"]
    size = (layout["width"] / PIXELS, layout["height"] / PIXELS)
    canvas = Figure(figsize=size, dpi=PIXELS)
    panels = {
        name.removeprefix("xaxis"): _Panel(canvas, layout, name.removeprefix("xaxis"))
        for name in layout
        if name.startswith("xaxis")
    }
    for trace in specification["data"]:
        panels[trace["xaxis"].removeprefix("x")].draw(trace)
    for annotation in layout.get("annotations", ()):
        _write(canvas, annotation, layout)
    _legend(canvas, specification)
    format = file.suffix.removeprefix(".")
    metadata = {"svg": {"Date": None}, "pdf": {"CreationDate": None}}.get(format)
    return write_atomically(
        file, lambda part: canvas.savefig(part, format=format, dpi=SHARP * PIXELS, metadata=metadata)
    )


class _Panel:
    """The axes of one panel, and how its words are numbered where the abscissa has words."""

    def __init__(self, canvas: Any, layout: Mapping[str, Any], suffix: str):
        self._x, self._y = layout[f"xaxis{suffix}"], layout[f"yaxis{suffix}"]
        self._words: dict[str, int] = {}
        self._has_words = self._x.get("type") == "category"
        self.axes = canvas.add_axes(_rectangle(layout, self._x["domain"], self._y["domain"]))
        for axis, which in ((self._x, "x"), (self._y, "y")):
            self._prepare(axis, which)
        self.axes.spines[["top", "right"]].set_visible(False)
        self.axes.set_axisbelow(True)
        self.axes.grid(color=self._y.get("gridcolor", "#e4e4e4"), linewidth=0.8 * POINT)

    def _prepare(self, axis: Mapping[str, Any], which: str) -> None:
        """Range, ticks and title of an axis."""
        title = axis.get("title", {}).get("text", "")
        self.axes.set(**{f"{which}label": _plain(title)})
        if "range" in axis:
            self.axes.set(**{f"{which}lim": axis["range"]})
        if "tickvals" in axis:
            texts = axis.get("ticktext") or [f"{value:g}" for value in axis["tickvals"]]
            self.axes.set(**{f"{which}ticks": axis["tickvals"], f"{which}ticklabels": texts})
        shows = axis.get("showticklabels", True)
        self.axes.tick_params(axis=which, labelsize=9, **{f"label{'bottom' if which == 'x' else 'left'}": shows})
        part = getattr(self.axes, f"{which}axis")
        part.label.set_size(10)
        if "%" in axis.get("tickformat", ""):
            part.set_major_formatter(lambda value, _: f"{100.0 * value:.3g} %")

    def draw(self, trace: Mapping[str, Any]) -> None:
        """The line, the area, the marks and the error bars of a trace."""
        x = [self._place(value) for value in trace["x"]]
        y = [math.nan if value is None else value for value in trace["y"]]
        if not x or all(math.isnan(value) for value in x):
            return
        mode, opacity = trace.get("mode", ""), trace.get("opacity", 1.0)
        line, marker = trace.get("line", {}), trace.get("marker", {})
        if trace.get("fill") == "toself":
            self.axes.fill(x, y, color=_colour(trace["fillcolor"]), linewidth=0)
        if "lines" in mode and line.get("width", 1.0):
            self.axes.plot(x, y, alpha=opacity, **_line(line))
        error = trace.get("error_y", {})
        if error.get("visible") and any(error["array"]):
            bars = {"ecolor": error["color"], "elinewidth": error["thickness"] * POINT}
            self.axes.errorbar(x, y, error["array"], fmt="none", capsize=2.0, **bars)
        if "markers" in mode:
            names = marker.get("symbol", "circle")
            clip = trace.get("cliponaxis", True)
            for each, at, value in zip([names] * len(x) if isinstance(names, str) else names, x, y, strict=True):
                self.axes.plot([at], [value], clip_on=clip, zorder=3, **_mark(marker, each))

        if "text" in mode:
            for text, at, value, position in zip(trace["text"], x, y, trace["textposition"], strict=True):
                self._label(text, (at, value), position, trace["textfont"])

    def _label(self, text: str, place: tuple[float, float], position: str, font: Mapping[str, Any]) -> None:
        """A text beside a mark: "bottom right" of it, for instance."""
        vertical, _, horizontal = position.partition(" ")
        across = {"left": -1.0, "right": 1.0}.get(horizontal, 0.0)
        self.axes.annotate(
            _plain(text),
            place,
            (across * LABEL_APART, LABEL_APART if vertical == "top" else -LABEL_APART),
            textcoords="offset points",
            ha={-1.0: "right", 1.0: "left"}.get(across, "center"),
            va="bottom" if vertical == "top" else "top",
            color=font["color"],
            size=font["size"] * POINT,
        )

    def _place(self, value: Any) -> float:
        """A value of the abscissa; a word as its number in the order of the words."""
        if value is None:
            return math.nan
        if not self._has_words:
            return float(value)
        number = self._words.setdefault(str(value), len(self._words))
        self.axes.set_xticks(range(len(self._words)), list(self._words))
        return float(number)


def _line(line: Mapping[str, Any]) -> dict[str, Any]:
    return {
        "color": line.get("color"),
        "linewidth": line.get("width", 1.0) * POINT,
        "linestyle": DASHES.get(line.get("dash", "solid"), "-"),
        "solid_capstyle": "butt",
    }


def _mark(marker: Mapping[str, Any], symbol: str) -> dict[str, Any]:
    """A mark; an open one has an outline alone."""
    colour = marker.get("color")
    name = re.sub("-(open|thin|dot)", "", symbol)
    return {
        "linestyle": "none",
        "marker": MARKERS.get(name, "o"),
        "markersize": marker.get("size", 6.0) * POINT,
        "markeredgewidth": max(1.0, marker.get("line", {}).get("width", 0.0)) * POINT,
        "markeredgecolor": colour,
        "markerfacecolor": "none" if symbol.endswith("-open") else colour,
    }


def _rectangle(
    layout: Mapping[str, Any], across: Sequence[float], up: Sequence[float]
) -> tuple[float, float, float, float]:
    """Left, bottom, width and height of a panel, as parts of the figure."""
    (left, bottom), (right, top) = (_at(layout, *corner) for corner in zip(across, up, strict=True))
    return left, bottom, right - left, top - bottom


def _at(layout: Mapping[str, Any], x: float, y: float) -> tuple[float, float]:
    """A place of "paper", which is the figure without its margins, as a part of the figure."""
    margin, width, height = layout["margin"], layout["width"], layout["height"]
    across = margin["l"] + x * (width - margin["l"] - margin["r"])
    up = margin["b"] + y * (height - margin["t"] - margin["b"])
    return across / width, up / height


def _write(canvas: Any, annotation: Mapping[str, Any], layout: Mapping[str, Any]) -> None:
    """The lines of a title above its panel, bold, and of its note below it."""
    if annotation.get("xref") != "paper":
        return
    bold, _, rest = annotation["text"].partition("</b>")
    lines = [(text, "bold", 10) for text in bold.split("<br>")]
    lines += [(text, "normal", 9) for text in rest.split("<br>") if text]
    left, bottom = _at(layout, annotation["x"], annotation["y"])
    for number, (text, weight, size) in enumerate(reversed(lines)):
        height = bottom + TITLE_LINE * (0.25 + number) / layout["height"]
        canvas.text(left, height, _plain(text), size=size, weight=weight)


def _legend(canvas: Any, specification: Mapping[str, Any]) -> None:
    """One entry for each label, below the panels, in the order of the page."""
    from matplotlib.lines import Line2D
    from matplotlib.patches import Patch

    layout = specification["layout"]
    named = [trace for trace in specification["data"] if trace.get("showlegend")]
    handles: list[Any] = []
    for trace in sorted(named, key=lambda trace: trace.get("legendrank", 1000)):
        label, marker = _plain(_elsewhere(trace["name"])), trace.get("marker", {})
        if trace.get("fill") == "toself":
            handles.append(Patch(color=_colour(trace["fillcolor"]), label=label))
            continue
        look: dict[str, Any] = {"linestyle": "none"}
        if "markers" in trace.get("mode", ""):
            symbol = marker.get("symbol", "circle")
            look = _mark(marker, symbol if isinstance(symbol, str) else symbol[0])
        if "lines" in trace.get("mode", ""):
            look |= {**_line(trace.get("line", {})), "alpha": trace.get("opacity")}
        handles.append(Line2D([], [], label=label, **look))
    if handles:
        _, bottom = _at(layout, 0.0, layout.get("legend", {}).get("y", 0.0))
        canvas.legend(
            handles=handles,
            loc="upper left",
            bbox_to_anchor=(layout["margin"]["l"] / layout["width"], bottom),
            ncols=LEGEND_COLUMNS,
            frameon=False,
            fontsize=9,
            borderaxespad=0.0,
        )


def _elsewhere(label: str) -> str:
    """A label of the page in a file, which has no other sections."""
    return "flagged: see the report" if label == FLAGGED else label.replace("<br>", "\n")


def _colour(text: str) -> Any:
    """A colour of the specification; rgba(...) as four shares."""
    match = re.fullmatch(r"rgba\((\d+),(\d+),(\d+),([\d.]+)\)", text.replace(" ", ""))
    if match is None:
        return text
    red, green, blue = (int(match[place]) / 255.0 for place in (1, 2, 3))
    return red, green, blue, float(match[4])


def _plain(text: str) -> str:
    """A text of the page without its tags."""
    return html.unescape(re.sub("<[^>]+>", "", text))


def _no_cube(file: Path, problem: str) -> InvalidInput:
    cure = "give the cube.nc of a sweep, or the folder of one"
    return InvalidInput([Finding("cube", f"{file}: {problem}", "a cube of whipple", cure)])
