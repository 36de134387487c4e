"""Sketches as SVG: the set-up with its dimensions, and how measured lengths grew during a run."""

import math
from collections.abc import Callable, Iterator, Mapping
from typing import Any

from markupsafe import Markup

from studies.reports.setup import upward
from studies.reports.svg import arrow, line, px, step_of, svg, text, ticks
from studies.values.formats import digits, display_of

Document = Mapping[str, Any]
Place = Callable[[float, float], tuple[float, float]]  # of a point (across, along; m), in px

# px
WIDTH = 440
ROOM = 280  # width of the set-up itself: labels stand beside it
TALLEST = 260  # of the set-up itself
ABOVE, BELOW = 66, 44  # room for flight and dimensions, and for dimensions below
APART = 9  # between a body and its dimension
LETTER = 7.0  # width of a letter of a label, on average
LINE = 15  # between the lines of a label
FLIGHT = 30  # length of the arrow of flight
LEFT, RIGHT = 44, 14  # of a growth history
TOP, HIGH = 20, 190
DASHES = ("first", "second", "third")  # kinds of lines


def setup_sketch(document: dict[str, Any]) -> Markup:
    """The set-up to scale."""
    outline, labels = document["outline"], document["labels"]
    shapes = outline["shapes"]
    # Bodies come from above, whatever their coordinate says.
    sign = upward(document)
    left, right = min(s["left"] for s in shapes), max(s["right"] for s in shapes)
    ends = [sign * s[key] for s in shapes for key in ("top", "bottom")]
    top, bottom = min(ends), max(ends)
    scale = min(ROOM / (right - left), TALLEST / (bottom - top))

    def place(across: float, along: float) -> tuple[float, float]:
        return (0.5 * (WIDTH - 60) + scale * (across - 0.5 * (left + right)), ABOVE + scale * (sign * along - top))

    parts: list[str] = []
    for shape in shapes:
        parts += _shape(shape, place, sign, document)
    middle, deepest = place(0.0, 0.0)[0], ABOVE + scale * (bottom - top)
    parts.append(line("thin", middle, ABOVE - 12, middle, deepest + 8))
    for dimension in outline["dimensions"]:
        parts += _dimension(dimension, place, labels[dimension["parameter"]])
    return Markup(svg("full setup", WIDTH, deepest + BELOW, parts, document["alt"]))


def _shape(shape: Document, place: Place, sign: float, document: Document) -> Iterator[str]:
    """A body with its material, and its flight."""
    corners = place(shape["left"], shape["top"]), place(shape["right"], shape["bottom"])
    x, right = sorted(corner[0] for corner in corners)
    y, bottom = sorted(corner[1] for corner in corners)
    kind = "wall" if shape["body"] == "wall" else "body"
    if shape["is_disc"]:
        centre = f'cx="{px(0.5 * (x + right))}" cy="{px(0.5 * (y + bottom))}"'
        yield f'<circle class="{kind}" {centre} r="{px(0.5 * (right - x))}"/>'
    else:
        size = f'width="{px(right - x)}" height="{px(bottom - y)}"'
        yield f'<rect class="{kind}" x="{px(x)}" y="{px(y)}" {size}/>'
    name = document["materials"].get(shape["body"])
    if shape["heading"]:
        yield from _flight(shape, 0.5 * (x + right), y, sign, document["labels"].get("speed", ""))
        if name:
            # Beside the arrow: its dimensions stand beside the body.
            left = 0.5 * (x + right) - FLIGHT * max(0.0, shape["heading"][0]) - 12
            lines = _label(shape["body"], name, left)
            yield from _lines(left, y - APART - FLIGHT, lines, "end")
    elif name:
        # Left of the axis where the body is wide enough.
        lines = _label(shape["body"], name, 0.5 * (right - x) - 10)
        inside = bottom - y > 12 + LINE * len(lines)
        yield from _lines(x + 6, y + 18 if inside else bottom + 16, lines, "start")


def _label(body: str, material: str, room: float) -> list[str]:
    """The label of a body, in two lines where one is wider than the room (px)."""
    line = f"{body}: {material}"
    return [line] if LETTER * len(line) <= room else [f"{body}:", material]


def _lines(x: float, y: float, lines: list[str], anchor: str) -> Iterator[str]:
    for number, words in enumerate(lines):
        yield text("tick", x, y + LINE * number, words, anchor)


def _flight(shape: Document, x: float, y: float, sign: float, speed: str) -> Iterator[str]:
    """An arrow above a body, in the direction in which it flies."""
    across, along = shape["heading"]
    end = x, y - APART - 9
    begin = end[0] - FLIGHT * across, end[1] - FLIGHT * sign * along
    yield arrow("flight", *begin, *end, both=False)
    yield text("tick", begin[0] + 8, begin[1] + 9, speed, "start")


def _dimension(dimension: Document, place: Place, label: str) -> Iterator[str]:
    """A length beside what it measures: above or below it, or to its right."""
    (x1, y1), (x2, y2) = place(*dimension["begin"]), place(*dimension["end"])
    if abs(x2 - x1) < abs(y2 - y1):
        x, low, high = x1 + APART, *sorted((y1, y2))
        yield line("measured thin", x1, y1, x + 4, y1)
        yield line("measured thin", x2, y2, x + 4, y2)
        yield arrow("measured", x, low, x, high)
        yield text("measured", x + 7, 0.5 * (low + high) + 4, label, "start")
        return
    is_above = y1 <= ABOVE + 1
    y = y1 - APART if is_above else y1 + APART
    yield line("measured thin", x1, y1, x1, y)
    yield line("measured thin", x2, y2, x2, y)
    yield arrow("measured", x1, y, x2, y)
    if is_above:
        yield text("measured", min(x1, x2) - 6, y + 4, label, "end")
    else:
        yield text("measured", 0.5 * (x1 + x2), y + 16, label, "middle")


def growth_sketch(document: Document) -> Markup:
    """Measured lengths over the time of a run, with the window in which they were found settled."""
    lines = document["lines"]
    seconds, metres = display_of("s"), display_of("m")
    last = max(each["time"][-1] for each in lines) * seconds.factor
    values = [value * metres.factor for each in lines for value in each["value"] if value is not None]
    least, most = min(0.0, *values), 1.12 * max(values)
    wide, bottom = WIDTH - LEFT - RIGHT, TOP + HIGH

    def place(time: float, value: float) -> tuple[float, float]:
        share = (value * metres.factor - least) / (most - least)
        return LEFT + wide * time * seconds.factor / last, bottom - HIGH * share

    parts = []
    if document["window"]:
        begin, end = (place(time, 0.0)[0] for time in document["window"])
        parts.append(f'<rect class="window" x="{px(begin)}" y="{TOP}" width="{px(end - begin)}" height="{HIGH}"/>')
    parts += _grid(last, least, most, wide, bottom)
    for number, each in enumerate(lines):
        kind = DASHES[number % len(DASHES)]
        for piece in _pieces(each["time"], each["value"]):
            points = " ".join(",".join(map(px, place(*point))) for point in piece)
            parts.append(f'<polyline class="grown {kind}" points="{points}"/>')
        x, y = place(each["time"][-1], each["value"][-1] or 0.0)
        parts.append(text("small", x - 4, y - 7, each["label"], "end"))
    parts.append(text("tick", LEFT + wide, bottom + 32, f"time ({seconds.unit})", "end"))
    parts.append(text("tick", LEFT - 6, 12, metres.unit, "end"))
    return Markup(svg("full growth", WIDTH, bottom + 38, parts, document["alt"]))


def _grid(last: float, least: float, most: float, wide: float, bottom: float) -> Iterator[str]:
    """Ticks of time and length, in the units that people read."""
    for at in ticks(0.0, last, step_of(last / 5.0)):
        x = LEFT + wide * at / last
        yield line("axis", x, bottom, x, bottom + 4)
        yield text("tick", x, bottom + 17, digits(round(at, 9)), "middle")
    for at in ticks(least, most, step_of((most - least) / 4.0)):
        y = bottom - HIGH * (at - least) / (most - least)
        yield line("rule", LEFT, y, LEFT + wide, y)
        yield text("tick", LEFT - 6, y + 4, digits(round(at, 9)), "end")


def _pieces(times: list[float], values: list[float | None]) -> Iterator[list[tuple[float, float]]]:
    """Stretches of a history without a gap."""
    piece: list[tuple[float, float]] = []
    for time, value in [*zip(times, values, strict=True), (math.nan, None)]:
        if value is not None:
            piece.append((time, value))
        elif piece:
            yield piece
            piece = []
