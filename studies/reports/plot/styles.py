"""Colours and marks of the labels of a figure.

Colours are those of Okabe and Ito (2008), told apart with any colour vision; every law has a mark of its own as well,
so that a page printed in grey still reads.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from studies.reports import figures as labels
from studies.reports.figures import Figure

# Okabe and Ito (2008), without black (the simulation) and yellow (too pale on paper).
OKABE_ITO = ("#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9")
# Further laws, dashed.
COLOURS = (*OKABE_ITO, "#7e4fc9", "#8c5a3c", "#7a8a00", "#3f7f93")
SYMBOLS = ("square", "triangle-up", "diamond", "triangle-down", "star-diamond", "hexagon")
AGAIN = ("circle", "cross", "x", "star", "pentagon", "bowtie")  # with the same colours, of the next labels
# For lines that follow one number: lightness grows along it, and each step reads on white and on black.
RAMP = ("#5b4cc4", "#0072b2", "#009e9e", "#7fa800", "#d99000")
INK, GREY, RULE, CRIMSON = "#1a1a1a", "#8a8a8a", "#e4e4e4", "#a3003c"

FLAGGED = "flagged: see Failed and flagged"
OUTSIDE = "law outside its range: open marks, dotted"
NO_MESH_ERROR = "simulation without a mesh error: open marks"
WINDOW = "window in which growth is judged"


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
    "missing": Look(size=9, ring=2, more={"hovertemplate": "%{x}: %{text}<extra></extra>", "cliponaxis": False}),
    "history": Look(stroke=1.8),
    "run": Look(size=6),  # small and open, so that the mean and its bar stay in sight
    "limit": Look(size=12, more={"cliponaxis": False}),
    "trend": Look(stroke=1.4, more={"hoverinfo": "skip"}),
}


def styles_of(figure: Figure) -> dict[str, Style]:
    """A colour and a mark for each label, the same in every panel."""
    series = [series for panel in figure.panels for series in panel.series]
    names = list(dict.fromkeys(each.label for each in series))
    if any(each.kind == "history" for each in series):
        return STYLES | {name: Style(_on_ramp(place, len(names)), "circle") for place, name in enumerate(names)}
    coloured = [name for name in names if name not in STYLES]
    marks = SYMBOLS + AGAIN
    return STYLES | {
        name: Style(
            COLOURS[place % len(COLOURS)], marks[place % len(marks)], dash="solid" if place < len(OKABE_ITO) else "dash"
        )
        for place, name in enumerate(coloured)
    }


def _on_ramp(place: int, count: int) -> str:
    """A colour of the ramp, mixed between its steps."""
    at = (len(RAMP) - 1) * place / max(1, count - 1)
    low = min(int(at), len(RAMP) - 2)
    pairs = zip(channels(RAMP[low]), channels(RAMP[low + 1]), strict=True)
    return "#" + "".join(f"{round(a + (b - a) * (at - low)):02x}" for a, b in pairs)


def channels(colour: str) -> list[int]:
    return [int(colour[place : place + 2], 16) for place in (1, 3, 5)]
