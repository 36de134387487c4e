"""The canvas of a drawing, in points: its common style, and how it becomes SVG of a page or a file for print.

On a page, colours are variables of the style sheet, so that a drawing reads in light and dark and on paper, and marks
say in words what they show.
"""

import io
import re
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from functools import cache
from pathlib import Path
from typing import TypedDict

import matplotlib
from markupsafe import Markup, escape
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from studies.quantities.display import digits

INK, SOFT, GREY, CRIMSON = "#1a1a1a", "#555555", "#8a8a8a", "#a3003c"
DPI = 192  # of a PNG
SAYS, KIND = "says:", "kind:"  # beginnings of what an artist has as its address or identifier
# What the SVG of a page has in place of what Matplotlib writes.
OF_PAGES = (
    (r"base64,\n", "base64,"),
    (r"\s*\n\s*", " "),
    (f'<a xlink:href="{SAYS}([^"]*)" target="_blank">(.*?)</a>', r"<g><title>\1</title>\2</g>"),
    (f'id="{KIND}', 'class="'),
    (r' id="[a-z]+_\d+"', ""),
    (r"#([0-9a-f]{6})(?=[;\"])", r"var(--c-\1, #\1)"),
    (r"font-family: [^;\"]*;? ?", ""),
    (r"(\d\.\d{3})\d+", r"\1"),
    (r"image-rendering:[^;\"]*;?", ""),
)


class LineLook(TypedDict, total=False):
    color: str
    linewidth: float
    linestyle: tuple[float, tuple[float, float]]


class TextLook(TypedDict, total=False):
    size: float
    color: str
    weight: str
    gid: str


LINES: Mapping[str, LineLook] = {
    "plain": {"color": SOFT, "linewidth": 0.75},
    "scale": {"color": INK, "linewidth": 1.5},
    "flight": {"color": INK, "linewidth": 1.35},
    "measured": {"color": CRIMSON, "linewidth": 1.05},
    "thin": {"color": CRIMSON, "linewidth": 0.75, "linestyle": (0, (3.0, 3.0))},
}
TEXTS: Mapping[str, TextLook] = {
    "plain": {"size": 9.0},
    "small": {"size": 9.0, "gid": f"{KIND}small"},
    "measured": {"size": 9.75, "color": CRIMSON, "weight": "bold", "gid": f"{KIND}measured"},
}


@contextmanager
def drawn_in_style(name: str = "report") -> Iterator[None]:
    """Draw in a style, and leave that of other drawings of the process as it is.

    The style "plain" has grey and colours that read on any paper, light or dark.
    """
    with matplotlib.rc_context(_style(name)):
        yield


@cache
def _style(name: str) -> matplotlib.RcParams:
    return matplotlib.rc_params_from_file(Path(__file__).with_name(f"{name}.mplstyle"), use_default_template=False)


def canvas(width: float, height: float) -> Figure:
    """An empty canvas; sizes in points."""
    return Figure(figsize=(width / 72.0, height / 72.0), dpi=72, facecolor="none")


def line(axes: Axes, kind: str, x: Sequence[float], y: Sequence[float]) -> None:
    """A straight line of a kind, between two places."""
    axes.plot(x, y, clip_on=False, **LINES[kind])


def arrow(axes: Axes, kind: str, x: Sequence[float], y: Sequence[float], *, both: bool = True) -> None:
    """A line with a head at both ends, or at its end alone."""
    begin, end = zip(x, y, strict=True)
    style = {"arrowstyle": "<|-|>" if both else "-|>", "shrinkA": 0.0, "shrinkB": 0.0, "mutation_scale": 8.0}
    axes.annotate("", end, begin, arrowprops={**style, **LINES[kind]})


def write(axes: Axes, kind: str, x: float, y: float, words: str, anchor: str) -> None:
    """Words whose ``anchor`` (left, center, right) is at a place, on their base line."""
    axes.text(x, y, words, ha=anchor, va="baseline", **TEXTS[kind])


def number(value: float, _: float | None = None) -> str:
    """A number at a tick."""
    return digits(round(value, 9))


def as_svg(drawing: Figure, kind: str, alt: str, salt: str) -> Markup:
    """A drawing as an element of a page, of a kind that the style sheet names, with its alternative text.

    ``salt`` makes the identifiers inside unique on a page.
    """
    file = io.StringIO()
    with matplotlib.rc_context({"svg.fonttype": "none", "svg.hashsalt": salt}):
        drawing.savefig(file, format="svg", metadata={"Date": None})
    _, _, inside = file.getvalue().partition("<metadata>")
    _, _, inside = inside.partition("</metadata>")
    for pattern, replacement in OF_PAGES:
        inside = re.sub(pattern, replacement, inside)
    width, height = 72.0 * drawing.get_size_inches()
    size = f'viewBox="0 0 {width:.4g} {height:.4g}" style="--width: {width / 0.75:.4g}px"'
    return Markup(f'<svg class="picture {kind}" {size} role="img" aria-label="{escape(alt)}">{inside}')


def as_file(drawing: Figure, file: Path | io.BytesIO, format: str) -> None:
    """Write a drawing into a file of a format."""
    metadata = {"svg": {"Date": None}, "pdf": {"CreationDate": None}}.get(format)
    drawing.savefig(file, format=format, dpi=DPI, metadata=metadata)
