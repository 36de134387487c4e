"""Pages of cases: claim, expected, others, ours with its error bar and verdict, with pictures; and an index."""

import base64
import io
import math
from collections import Counter
from collections.abc import Mapping, Sequence
from functools import cache
from importlib.resources import files
from pathlib import Path
from typing import Any

from jinja2 import Environment, FunctionLoader, StrictUndefined
from markupsafe import Markup

from studies.cases.compared import Line, Picture
from studies.cases.rows import Row, Verified
from studies.cases.validation import Cubes, ValidationCase, ValidationLevel
from studies.cases.verification import VerificationCase
from studies.quantities.display import NONE, digits
from studies.quantities.files import REPORT_HTML, write_text

INDEX = "index.html"
COLOURS = ("#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9", "#7f7f7f")
MARKS = "osD^vP*"
LINE_STYLES = ("-", "--", ":")  # after every colour once
GREY = "#7f7f7f"
MOST_INSIDE = 5  # lines whose legend leaves room in the figure
STYLE: dict[Any, Any] = {
    "svg.fonttype": "none",
    "svg.hashsalt": "whipple",
    "font.family": "sans-serif",
    "font.size": 10,
    "text.color": GREY,
    "axes.edgecolor": GREY,
    "axes.labelcolor": GREY,
    "axes.grid": True,
    "grid.color": GREY,
    "grid.alpha": 0.25,
    "xtick.color": GREY,
    "ytick.color": GREY,
    "legend.frameon": False,
    "legend.labelcolor": GREY,
    "legend.fontsize": 9,
    "figure.constrained_layout.use": True,
}
NO_BREAK = "\N{NO-BREAK SPACE}"

AnyCase = VerificationCase | ValidationCase
Done = Sequence[tuple[AnyCase, Sequence[Verified]]]


def write_case(case: AnyCase, rows: Sequence[Verified], cubes: Cubes, out: Path) -> Path:
    """Write the page of a case, its pictures, and a link to the report of each of its sweeps."""
    pictures = case.pictures(cubes) if isinstance(case, ValidationCase) else ()
    drawn = [(each, draw(each)) for each in pictures]
    for picture, svg in drawn:
        folder = out / case.name
        folder.mkdir(parents=True, exist_ok=True)
        write_text(folder / f"{picture.name}.svg", svg)
    page = _template("case.html").render(
        case=case,
        rows=[list(zip(HEADERS, cells(each.row), strict=True)) for each in rows],
        headers=HEADERS,
        none=NONE,
        counts=_counts(rows),
        drawn=[(each.title, Markup(svg)) for each, svg in drawn],
        reports=[(name, f"{case.name}/{name}/{REPORT_HTML}") for name in cubes],
    )
    return write_text(out / f"{case.name}.html", page)


def write_index(done: Done, level: ValidationLevel, out: Path) -> Path:
    """Write the list of the cases, with the first picture of each."""
    entries = [
        {
            "case": case,
            "kind": "published" if isinstance(case, ValidationCase) else "exact answer",
            "counts": _counts(rows),
            "failed": any(each.row.passed is False for each in rows),
            "picture": _first_picture(out / case.name),
        }
        for case, rows in done
    ]
    return write_text(out / INDEX, _template("index.html").render(entries=entries, level=level))


def _first_picture(folder: Path) -> str:
    """The first picture of a folder as a URL; empty without any."""
    for file in sorted(folder.glob("*.svg")):
        return f"data:image/svg+xml;base64,{base64.b64encode(file.read_bytes()).decode()}"
    return ""


HEADERS = ("compared", "expected", "others", "ours", "error", "verdict")


def cells(row: Row) -> list[str]:
    """A row as the texts of a table under ``HEADERS``; the error of a gated row stands beside its tolerance."""
    bar = "" if row.bar is None else f"{NO_BREAK}±{NO_BREAK}{digits(row.bar, 2)}"
    others = ", ".join(f"{name} {shown(value)}" for name, value in row.others.items())
    error = f"{shown(row.error)} of {shown(row.tolerance)}" if row.tolerance else NONE
    ours = shown(row.got) + bar
    return [row.claim, shown(row.expected), others or NONE, ours, error, row.verdict.lower()]


def shown(value: Any) -> str:
    """A figure with four digits; a dash where there is none."""
    if isinstance(value, float):
        if not math.isfinite(value):
            return NONE
        return digits(value, 4)
    return NONE if value in (None, "") else str(value)


def draw(picture: Picture) -> str:
    """A figure as SVG that reads on light and dark paper."""
    import matplotlib
    from matplotlib.figure import Figure

    buffer = io.StringIO()
    with matplotlib.rc_context(STYLE):
        figure = Figure(figsize=(6.4, 4.0))
        axes = figure.subplots()
        for number, line in enumerate(picture.lines):
            if line.points:
                _draw_line(axes, line, number)
        axes.set(title=picture.title, xlabel=picture.x, ylabel=picture.y, ylim=picture.ends)
        if len(picture.lines) > MOST_INSIDE:
            axes.legend(loc="center left", bbox_to_anchor=(1.0, 0.5))
        else:
            axes.legend()
        figure.savefig(buffer, format="svg", transparent=True, metadata={"Date": None})
    return buffer.getvalue()


def _draw_line(axes: Any, line: Line, number: int) -> None:
    colour = COLOURS[number % len(COLOURS)]
    x, y, bars = zip(*line.points, strict=True)
    if line.joined:
        style = LINE_STYLES[number // len(COLOURS) % len(LINE_STYLES)]
        axes.plot(x, y, style, color=colour, lw=1.5, label=line.label)
        return
    mark = MARKS[number % len(MARKS)]
    shown_bars = bars if any(bars) else None
    axes.errorbar(x, y, shown_bars, fmt=mark, ms=5, color=colour, capsize=2, label=line.label)


def _counts(rows: Sequence[Verified]) -> str:
    counts: Mapping[str, int] = Counter(each.row.verdict for each in rows)
    return f"{counts['PASS']} passed, {counts['FAIL']} failed, {counts['REPORT']} reported"


@cache
def _environment() -> Environment:
    def source(name: str) -> str:
        return files("studies.cases").joinpath(name).read_text(encoding="utf-8")

    loader = FunctionLoader(source)
    return Environment(loader=loader, autoescape=True, undefined=StrictUndefined, trim_blocks=True)


def _template(name: str) -> Any:
    return _environment().get_template(name)
