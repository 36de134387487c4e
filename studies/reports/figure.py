"""Records of a figure: panels side by side, of series of points, lines and bands in SI.

Nothing here knows how a figure is drawn (:mod:`studies.reports.drawing`) or where its numbers come from
(:mod:`studies.reports.figures`); the report's JSON carries exactly these records.
"""

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Literal

SeriesKind = Literal[
    "simulation",
    "law",
    "curve",
    "band",
    "observation",
    "missing",
    "history",
    "quantity",
    "run",
    "level",
    "trend",
    "limit",
    "map",
]
Scales = Literal["shared", "own"]
# Where a figure stands: on the page, in diameters of the projectile behind one on the page, or on the appendix.
Where = Literal["page", "ratio", "appendix"]
Numbers = tuple[float | None, ...]

# Labels of series that have a look of their own.
SIMULATION, OBSERVED, MISSING = "simulation", "measured", "run without a value"
MUTED = "other laws"
FAILED, HELD, THIS = "shot: the wall failed", "shot: the wall held", "this shot"
RUN_PERFORATED, RUN_HELD, RUN_UNDECIDED = "run: wall perforated", "run: wall holds", "run: undecided"
INTERVAL = "simulation: from held to perforated"
CHANCES, EVEN_CHANCE = "10 to 90 % to fail, from all shots", "50 % to fail"
ERROR_BAR = "value and error bar"
LEVEL, MEAN, RUN = "resolution", "mean over offsets", "run at one offset"
CELL_OF_MESH, GRADY = "a cell of the mesh", "fragments after Grady"
EXTRAPOLATED, TREND = "extrapolated", "curve of the order used"


@dataclass(frozen=True)
class Scale:
    """Quantity and unit of an axis of a figure."""

    name: str  # variable of the cube, or "ratio"
    label: str
    unit: str | None  # SI; None for text


@dataclass(frozen=True)
class Series:
    """Points of one kind; every list has one entry a point, None where there is none."""

    kind: SeriesKind
    label: str
    x: tuple[float | str | None, ...]
    y: Numbers = ()
    uncertainty: Numbers = ()  # half length of the error bar
    outer: Numbers = ()  # half length of the bar with models
    low: Numbers = ()  # lower edge of a band
    high: Numbers = ()  # upper edge of a band
    z: Numbers = ()  # of a map: what its colours say; y is then its other axis
    in_range: tuple[bool, ...] = ()  # of a law
    flagged: tuple[bool, ...] = ()  # of a simulation: drawn open
    doubts: tuple[str, ...] = ()  # of a simulation: the flags of each point in words, "" without any
    notes: tuple[str, ...] = ()  # words for a point
    window: Numbers = ()  # of a history: begin and end of the time in which growth is judged
    muted: bool = False  # drawn in grey, and in the legend with all others that are
    connected: bool = True  # whether a line through the points means anything


@dataclass(frozen=True)
class Panel:
    """One picture: the points that share every axis but the abscissa, or one point."""

    title: str
    at: Mapping[str, float | str]  # axis -> value
    series: tuple[Series, ...]
    note: str = ""  # a second line under the title


@dataclass(frozen=True)
class Figure:
    """Panels side by side."""

    name: str
    title: str
    caption: str
    x: Scale
    y: Scale
    panels: tuple[Panel, ...]
    scales: Scales = "shared"  # own: each about its own middle, all as high in per cent
    z: Scale | None = None  # of a map
    where: Where = "page"


def numbers(values: Iterable[float]) -> Numbers:
    """Numbers of a series, None where there is none."""
    return tuple(float(value) if math.isfinite(value) else None for value in values)


def is_cut(value: float, bar: float | None) -> bool:
    """Whether an error bar is longer than its own value: it sets no axis, and the frame cuts it."""
    return bar is not None and bar > abs(value) > 0.0
