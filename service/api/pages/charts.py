"""Line charts as SVG in the colours of the pages: light in bytes, without a script, drawn by the service itself."""

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass

from markupsafe import Markup

from studies.quantities.display import digits

WIDTH, HEIGHT = 360.0, 230.0  # size of the drawing in px, as wide as a telephone
LEFT, RIGHT, TOP, BOTTOM = 52.0, 8.0, 10.0, 38.0  # margins
MOST_POINTS = 200  # points of a line at most; a longer line is thinned evenly
MOST_LINES = 8  # in as many colours
TICKS = 5


@dataclass(frozen=True)
class ChartLine:
    """Points in the units of the axes; None where there is none."""

    label: str
    x: Sequence[float | None]
    y: Sequence[float | None]
    bars: Sequence[float | None] = ()  # half lengths of error bars


def chart(title: str, lines: Sequence[ChartLine], *, x: str, y: str, marked: bool = False) -> Markup:
    """A figure with a line for each label, points ``marked`` or not; empty where no point has a value.

    ``x`` is the label of the axis below, ``y`` the unit of the other one.
    """
    every, lines = len(lines), [line for k, line in enumerate(lines) if _is_drawn(k, len(lines))]
    known = [_known(line) for line in lines]
    points = [point for line in known for point in line]
    if not points:
        return Markup("")
    across = _Scale.over([at for at, _, _ in points], LEFT, WIDTH - RIGHT)
    up = _Scale.over([end for _, at, bar in points for end in (at - bar, at + bar)], HEIGHT - BOTTOM, TOP)
    parts = [*_grid(across, up, x, y)]
    for number, line in enumerate(known):
        if line:
            parts.append(_drawn(_thinned(line), across, up, number, marked=marked or len(line) == 1))
    legend = Markup("")
    if len(known) > 1:
        entries = (
            Markup('<li><span class="mark c{}"></span>{}</li>').format(number, line.label)
            for number, line in enumerate(lines)
        )
        legend = Markup('<ul class="legend">{}</ul>').format(Markup("").join(entries))
    if every > len(lines):
        legend += Markup("<p>{} of {} lines are drawn.</p>").format(len(lines), every)
    return Markup(
        '<figure class="chart"><figcaption>{}</figcaption><svg viewBox="0 0 {:g} {:g}" role="img" aria-label="{}">{}'
        "</svg>{}</figure>"
    ).format(
        title,
        WIDTH,
        HEIGHT,
        f"{title} ({y}) against {x}" if y else f"{title} against {x}",
        Markup("").join(parts),
        legend,
    )


def _is_drawn(number: int, count: int) -> bool:
    """Whether a line is one of the most that are drawn, which are spread evenly over all."""
    return count <= MOST_LINES or number * MOST_LINES // count != (number - 1) * MOST_LINES // count


ChartPoint = tuple[float, float, float]  # x, y, half length of its error bar


@dataclass(frozen=True)
class _Scale:
    """Values between two round ends, and where these are in the drawing."""

    low: float
    high: float
    step: float
    begin: float
    end: float

    @staticmethod
    def over(values: Sequence[float], begin: float, end: float) -> "_Scale":
        low, high = min(values), max(values)
        if high - low <= 1e-9 * max(abs(low), abs(high)):
            margin = 0.1 * abs(low) or 1.0
            low, high = low - margin, high + margin
        size = 10.0 ** math.floor(math.log10((high - low) / TICKS))
        step = next(size * factor for factor in (1, 2, 5, 10) if (high - low) / (size * factor) <= TICKS)
        return _Scale(math.floor(low / step) * step, math.ceil(high / step) * step, step, begin, end)

    def __call__(self, value: float) -> float:
        return self.begin + (value - self.low) / (self.high - self.low) * (self.end - self.begin)

    @property
    def ticks(self) -> list[float]:
        return [self.low + self.step * k for k in range(round((self.high - self.low) / self.step) + 1)]


def _known(line: ChartLine) -> list[ChartPoint]:
    bars = line.bars or [None] * len(line.x)
    return [
        (x, y, bar or 0.0) for x, y, bar in zip(line.x, line.y, bars, strict=True) if x is not None and y is not None
    ]


def _thinned(points: list[ChartPoint]) -> list[ChartPoint]:
    stride = -(-len(points) // MOST_POINTS)
    return points if stride == 1 else [*points[:-1:stride], points[-1]]


def _grid(across: _Scale, up: _Scale, x: str, y: str) -> Iterable[Markup]:
    lines = "".join(f"M{across(at):.1f} {TOP}V{HEIGHT - BOTTOM}" for at in across.ticks)
    lines += "".join(f"M{LEFT} {up(at):.1f}H{WIDTH - RIGHT}" for at in up.ticks)
    yield Markup('<path class="grid" d="{}"/>').format(lines)
    for at in across.ticks:
        yield _text(_rounded(at, across.step), across(at), HEIGHT - BOTTOM + 14, "middle")
    for at in up.ticks:
        yield _text(_rounded(at, up.step), LEFT - 4, up(at) + 4, "end")
    yield _text(x, (LEFT + WIDTH - RIGHT) / 2, HEIGHT - 4, "middle")
    yield Markup('<text x="{:g}" y="12" text-anchor="middle" transform="rotate(-90)">{}</text>').format(
        -(TOP + HEIGHT - BOTTOM) / 2, y
    )


def _rounded(value: float, step: float) -> str:
    return digits(round(value, 3 - math.floor(math.log10(step))))


def _text(text: str, x: float, y: float, anchor: str) -> Markup:
    return Markup('<text x="{:.1f}" y="{:.1f}" text-anchor="{}">{}</text>').format(x, y, anchor, text)


def _drawn(points: list[ChartPoint], across: _Scale, up: _Scale, number: int, *, marked: bool) -> Markup:
    path = "M" + "L".join(f"{across(x):.1f} {up(y):.1f}" for x, y, _ in points)
    marks = ""
    if marked:
        bars = "".join(f"M{across(x):.1f} {up(y - bar):.1f}V{up(y + bar):.1f}" for x, y, bar in points if bar)
        marks = f'<path class="bar" d="{bars}"/>' if bars else ""
        marks += "".join(f'<circle cx="{across(x):.1f}" cy="{up(y):.1f}" r="3"/>' for x, y, _ in points)
    return Markup('<g class="c{}"><path d="{}"/>{}</g>').format(number, path, Markup(marks))
