"""Small pictures inside a page, of points or of a line: no file, no process, no script."""

import math
import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass

from studies import measurements
from studies.quantities.parameters import Plain

WIDTH, HEIGHT, MARGIN = 120.0, 60.0, 4.0  # size of the drawing and its empty rim, in units of its view box
FEWEST, MOST_POINTS = 3, 200  # more are left out, evenly
SPEED = re.compile(r"speed \[.*\]")
NUMBER = re.compile(r"\d+(?:\.\d+)?(?:e-?\d+)?")

Point = tuple[float, float]


@dataclass(frozen=True)
class Spark:
    """Points in the box, y downwards, and what they show."""

    title: str
    points: tuple[Point, ...]
    open: tuple[Point, ...] = ()  # further ones, drawn as rings


def spark(title: str, points: Sequence[Point], rings: Sequence[Point] = ()) -> Spark:
    """A picture of points between their smallest and largest values."""
    every = [*points, *rings]
    low, high = ([of(point[k] for point in every) for k in (0, 1)] for of in (min, max))

    def placed(chosen: Sequence[Point]) -> tuple[Point, ...]:
        step = max(1, math.ceil(len(chosen) / MOST_POINTS))
        return tuple(within(point, low, high) for point in chosen[::step])

    return Spark(title, placed(points), placed(rings))


def within(point: Point, low: Sequence[float], high: Sequence[float]) -> Point:
    """A point in the box whose ends are two others."""
    x, y = ((at - begin) / ((end - begin) or 1.0) for at, begin, end in zip(point, low, high, strict=True))
    return round(MARGIN + x * (WIDTH - 2.0 * MARGIN), 1), round(HEIGHT - MARGIN - y * (HEIGHT - 2.0 * MARGIN), 1)


def spark_of_table(rows: Iterable[Mapping[str, Plain]]) -> Spark | None:
    """The first measured quantity of a table over the speed; None of a table without both."""
    rows = list(rows)
    names = list(rows[0]) if rows else []
    speed = next(filter(SPEED.fullmatch, names), None)
    quantity = next((name for name in names if name.partition(" ")[0] in measurements.names()), None)
    if speed is None or quantity is None:
        return None
    pairs = ((_number(row[speed]), _number(row[quantity])) for row in rows)
    points = [(x, y) for x, y in pairs if x is not None and y is not None]
    title = measurements.load(quantity.partition(" ")[0]).title
    return spark(f"{title} against speed, {len(points)} shots", points) if len(points) >= FEWEST else None


def _number(cell: Plain) -> float | None:
    """The number of a cell, or the middle of its range."""
    found = [float(number) for number in NUMBER.findall(str(cell or ""))]
    return sum(found) / len(found) if found else None
