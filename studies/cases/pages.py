"""The page of computed cases: claim, expected, others, ours with its error bar and verdict, with pictures."""

import io
import math
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

from markupsafe import Markup
from matplotlib.axes import Axes
from matplotlib.figure import Figure as Canvas

from studies.cases.compared import Line, Picture
from studies.cases.validation import Cubes, ValidationCase, ValidationLevel
from studies.quantities.comparison import Comparison, Figure
from studies.quantities.display import NONE, digits
from studies.quantities.files import REPORT_HTML, write_text
from studies.reports.drawing.canvas import drawn_in_style
from studies.reports.drawing.styles import MARKERS, OKABE_ITO
from studies.reports.wording import environment_of

PAGE = "index.html"
COLOURS, MARKS = (*OKABE_ITO, "#7f7f7f"), ("o", *MARKERS)
LINE_STYLES = ("-", "--", ":")  # after every colour once
MOST_INSIDE = 5  # lines whose legend leaves room in the figure
NO_BREAK = "\N{NO-BREAK SPACE}"
HEADERS = ("compared", "expected", "others", "ours", "error", "verdict")


@dataclass(frozen=True)
class ComputedCase:
    """A case with its cubes, and what was compared."""

    case: ValidationCase
    comparisons: Sequence[Comparison]
    cubes: Cubes

    @cached_property
    def _verdicts(self) -> Mapping[str, int]:
        return Counter(comparison.verdict for comparison in self.comparisons)

    @property
    def failed(self) -> bool:
        """Whether a gate does not hold."""
        return self._verdicts["FAIL"] > 0

    @property
    def counts(self) -> str:
        """How many passed, failed and are reported."""
        return f"{self._verdicts['PASS']} passed, {self._verdicts['FAIL']} failed, {self._verdicts['REPORT']} reported"

    @property
    def reports(self) -> list[tuple[str, str]]:
        """Name and report of each of its sweeps."""
        return [(name, f"{self.case.name}/{name}/{REPORT_HTML}") for name in self.cubes]

    @cached_property
    def drawn(self) -> list[tuple[str, Markup]]:
        """Title and drawing of each of its pictures."""
        return [(picture.title, Markup(draw(picture))) for picture in self.case.pictures(self.cubes)]

    @property
    def rows(self) -> list[list[tuple[str, str]]]:
        """Headers and cells of its table."""
        return [list(zip(HEADERS, cells(comparison), strict=True)) for comparison in self.comparisons]


def write_page(cases: Sequence[ComputedCase], level: ValidationLevel, out: Path) -> Path:
    """Write the page of all cases."""
    template = environment_of(is_html=True).get_template("studies.cases:validation.html")
    return write_text(out / PAGE, template.render(cases=cases, level=level, headers=HEADERS, none=NONE))


def cells(row: Comparison) -> list[str]:
    """A row as the texts of a table under ``HEADERS``; the error of a gated row stands beside its tolerance."""
    bar = "" if row.bar is None else f"{NO_BREAK}±{NO_BREAK}{digits(row.bar, 2)}"
    others = ", ".join(f"{name} {shown(value)}" for name, value in row.others.items())
    error = f"{shown(row.error)} of {shown(row.tolerance)}" if row.tolerance else NONE
    return [row.claim, shown(row.expected), others or NONE, shown(row.got) + bar, error, row.verdict.lower()]


def shown(value: Figure | None) -> str:
    """A figure with four digits; a dash where there is none."""
    if isinstance(value, float):
        return digits(value, 4) if math.isfinite(value) else NONE
    return NONE if value in (None, "") else str(value)


def draw(picture: Picture) -> str:
    """A figure as SVG that reads on light and dark paper."""
    buffer = io.StringIO()
    with drawn_in_style("plain"):
        canvas = Canvas(figsize=(6.4, 4.0))
        axes = canvas.subplots()
        for number, line in enumerate(picture.lines):
            if line.points:
                _draw_line(axes, line, number)
        axes.set(title=picture.title, xlabel=picture.x, ylabel=picture.y, ylim=picture.ends)
        if len(picture.lines) > MOST_INSIDE:
            axes.legend(loc="center left", bbox_to_anchor=(1.0, 0.5))
        else:
            axes.legend()
        canvas.savefig(buffer, format="svg", transparent=True, metadata={"Date": None})
    return buffer.getvalue()


def _draw_line(axes: Axes, line: Line, number: int) -> None:
    colour = COLOURS[number % len(COLOURS)]
    x, y, bars = zip(*line.points, strict=True)
    if line.joined:
        style = LINE_STYLES[number // len(COLOURS) % len(LINE_STYLES)]
        axes.plot(x, y, style, color=colour, lw=1.5, label=line.label)
    else:
        mark = MARKS[number % len(MARKS)]
        axes.errorbar(x, y, bars if any(bars) else None, fmt=mark, ms=5, color=colour, capsize=2, label=line.label)
