"""Colours and marks of the labels of a figure.

Colours are those of Okabe and Ito (2008), told apart with any colour vision; every law has a mark of its own as well,
so that a page printed in grey still reads.
"""

from dataclasses import dataclass

from matplotlib.colors import LinearSegmentedColormap, to_hex

from studies.reports import figure as labels
from studies.reports.drawing.canvas import CRIMSON, GREY, INK
from studies.reports.figure import Figure

# Okabe and Ito (2008), without black (the simulation) and yellow (too pale on paper).
OKABE_ITO = ("#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9")
# Further laws, dashed.
COLOURS = (*OKABE_ITO, "#7e4fc9", "#8c5a3c", "#7a8a00", "#3f7f93")
MARKERS = ("s", "^", "D", "v", "P", "h")
AGAIN = ("o", "X", "<", "*", "p", "d")  # with the same colours, of the next labels
MUTE = "#9a9a9a"
# For lines that follow one number: lightness grows along it, and each step reads on white and on black.
RAMP = ("#5b4cc4", "#0072b2", "#009e9e", "#7fa800", "#d99000")

FLAGGED = "flagged"
WITH_MODELS = "bar with models"
OUTSIDE = "law outside its range: open marks, dotted"
NO_MESH_ERROR = "simulation without a mesh error: open marks"
WINDOW = "window in which growth is judged"


@dataclass(frozen=True)
class Style:
    """Colour, mark and place in the legend of the series of one label."""

    colour: str
    marker: str
    rank: int = 100
    dash: str = "-"  # of lines inside the range of a law
    is_open: bool = False  # marks have an outline alone


# Computed and observed values come first in the legend, laws next, gaps last.
STYLES = {
    labels.SIMULATION: Style(INK, "o", 1),
    labels.LEVEL: Style(INK, "o", 1),
    labels.MEAN: Style(INK, "o", 1),
    labels.RUN: Style(COLOURS[0], "o", 2, is_open=True),
    labels.OBSERVED: Style(CRIMSON, "D", 2, is_open=True),
    labels.FAILED: Style(CRIMSON, "o", 2),
    labels.HELD: Style(INK, "o", 3, is_open=True),
    labels.INTERVAL: Style(INK, "s", 0),
    labels.RUN_PERFORATED: Style(INK, "s", 1),
    labels.RUN_HELD: Style(INK, "s", 1, is_open=True),
    labels.RUN_UNDECIDED: Style(INK, "x", 1),
    labels.THIS: Style(CRIMSON, "*", 1),
    labels.CHANCES: Style(GREY, "s", 4),
    labels.EVEN_CHANCE: Style(INK, "o", 5, dash="--"),
    labels.ERROR_BAR: Style(GREY, "s"),
    labels.EXTRAPOLATED: Style(COLOURS[1], "*"),
    labels.TREND: Style(COLOURS[1], "o", dash=":"),
    labels.MISSING: Style(GREY, "x", 1000),
    labels.MUTED: Style(MUTE, "s", 800),
    WITH_MODELS: Style(INK, "o", 1),
    FLAGGED: Style(CRIMSON, "o", 3, is_open=True),
    NO_MESH_ERROR: Style(INK, "o", 2, is_open=True),
    OUTSIDE: Style(GREY, "s", 900, dash=":", is_open=True),
    WINDOW: Style(GREY, "o", 900),
}


@dataclass(frozen=True)
class Look:
    """Marks and lines of one kind of series; sizes and widths in points, 0 for what is not drawn."""

    size: float = 0.0  # of marks
    ring: float = 1.0  # width of their outline
    stroke: float = 0.0  # width of the line through the points
    own_entry: bool = False  # the legend shows it filled, whatever its points are
    clipped: bool = True  # at the frame


CURVE = Look(size=5.3, ring=1.2, stroke=1.2, own_entry=True)
LOOKS = {
    "simulation": CURVE,
    "quantity": CURVE,
    "level": CURVE,
    "law": Look(size=4.5, own_entry=True),
    "observation": Look(size=6.5, ring=1.5),
    "missing": Look(size=6.5, ring=1.5, clipped=False),
    "history": Look(stroke=1.4),
    "run": Look(size=4.5),  # small and open, so that the mean and its bar stay in sight
    "limit": Look(size=9, clipped=False),
    "trend": Look(stroke=1.0),
    "curve": Look(stroke=1.5),
}


def styles_of(figure: Figure) -> dict[str, Style]:
    """A colour and a mark for each label, the same in every panel."""
    series = [series for panel in figure.panels for series in panel.series]
    muted = {line.label: Style(MUTE, "s", 800) for line in series if line.muted}
    names = list(dict.fromkeys(line.label for line in series if not line.muted))
    if any(line.kind == "history" for line in series):
        ramp = LinearSegmentedColormap.from_list("", RAMP)
        shades = [to_hex(ramp(place / max(1, len(names) - 1))) for place in range(len(names))]
        return STYLES | {name: Style(shade, "o") for name, shade in zip(names, shades, strict=True)}
    marks = MARKERS + AGAIN
    return (
        STYLES
        | muted
        | {
            name: Style(
                COLOURS[place % len(COLOURS)], marks[place % len(marks)], dash="-" if place < len(OKABE_ITO) else "--"
            )
            for place, name in enumerate(name for name in names if name not in STYLES)
        }
    )
