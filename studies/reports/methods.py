"""What the method does to an answer: points that several methods computed, beside the bars of both."""

import math
from collections.abc import Iterator, Sequence
from typing import Any

import xarray as xr

from studies.cubes import variables as cubes
from studies.cubes.points import axes_of, by_run, comparable, error_bars, main_quantities, places_of
from studies.cubes.reading import finite
from studies.quantities.display import NARROW_SPACE, digits

METHOD = "method"
DIGITS = 2  # of a difference in per cent


def methods_of(dataset: xr.Dataset, points: xr.Dataset) -> dict[str, Any] | None:
    """Values by each method less those by the first one; None of a sweep without several methods.

    ``points`` are those of the cube ``dataset``. A joint bar is the root of the sum of the squares of both error bars,
    where both include the mesh error; parts of the definition and of the model are common to the methods.
    """
    if METHOD not in axes_of(points):
        return None
    first, *others = dict.fromkeys(map(str, by_run(points, METHOD)))
    if not others:
        return None
    quantities = []
    for name in main_quantities(points):
        rows = list(_rows(points, name, first))
        sentences = [_sentence(name, first, other, [row for row in rows if row[METHOD] == other]) for other in others]
        unit = points[name].attrs["units"]
        label = name.replace("_", " ")
        quantities.append({"quantity": name, "label": label, "unit": unit, "sentences": sentences, "rows": rows})
    costs = [_cost(dataset, first, other) for other in others]
    return {"first": first, "quantities": quantities, "costs": list(filter(None, costs))}


def _rows(points: xr.Dataset, name: str, first: str) -> Iterator[dict[str, Any]]:
    """A row for each point of another method that the first one computed too."""
    columns = [array.values.ravel() for array in (comparable(points, name), error_bars(points, name))]
    known: dict[tuple[Any, ...], tuple[float, float]] = {}
    later = []
    for place, value, bar in zip(places_of(points), *columns, strict=True):
        at = {axis: each for axis, each in place.items() if axis != METHOD}
        if place[METHOD] == first:
            known[tuple(at.items())] = float(value), float(bar)
        else:
            later.append((at, str(place[METHOD]), float(value), float(bar)))
    for at, method, value, bar in later:
        if tuple(at.items()) not in known:
            continue
        reference, reference_bar = known[tuple(at.items())]
        yield {
            "at": at,
            METHOD: method,
            "reference": finite(reference),
            "reference_bar": finite(reference_bar),
            "value": finite(value),
            "bar": finite(bar),
            "difference": finite(value - reference),
            "joint": finite(math.hypot(bar, reference_bar)),
            "relative": finite(value / reference - 1.0) if reference else None,
        }


def _sentence(name: str, first: str, other: str, rows: Sequence[dict[str, Any]]) -> str:
    """ "By method sph the hole is 8.1 to 12 % smaller than by mpm (3 points): more than the error bars of both." """
    quantity = name.replace("_", " ")
    compared = [row for row in rows if row["relative"] is not None]
    if not compared:
        return f"No {quantity} was measured by both {first} and {other}."
    count = f"{len(compared)} point{'s' * (len(compared) > 1)}"
    text = f"By method {other} the {quantity} is {_spread(compared)} by {first} ({count})"
    judged = [row for row in compared if row["joint"] is not None]
    if not judged:
        return f"{text}; their error bars lack the mesh, so that nothing says whether that is the method or the mesh."
    beyond = sum(abs(row["difference"]) > row["joint"] for row in judged)
    if not beyond:
        return f"{text}: no more than the error bars of both together."
    where = "" if beyond == len(judged) == len(compared) else f" at {beyond} of {len(judged)}"
    return f"{text}: more than the error bars of both together{where}."


def _spread(rows: Sequence[dict[str, Any]]) -> str:
    low, high = (100.0 * end(row["relative"] for row in rows) for end in (min, max))
    if low < 0.0 < high:
        return f"{_percent(-low)} smaller to {_percent(high)} larger than"
    small, large = sorted((abs(low), abs(high)))
    word = "smaller" if low < 0.0 else "larger"
    numbers = dict.fromkeys((digits(small, DIGITS), digits(large, DIGITS)))
    return f"{' to '.join(numbers)}{NARROW_SPACE}% {word} than"


def _percent(number: float) -> str:
    return f"{digits(number, DIGITS)}{NARROW_SPACE}%"


def _cost(dataset: xr.Dataset, first: str, other: str) -> str:
    """How many times as long the runs of a method took; empty where a time is unknown."""
    if not cubes.SOLVER_SECONDS.is_in(dataset):
        return ""
    seconds, methods = (by_run(dataset, cubes.SOLVER_SECONDS.name), by_run(dataset, METHOD).astype(str))
    ours, theirs = (float(seconds[methods == method].sum()) for method in (other, first))
    if not (theirs > 0.0 and math.isfinite(ours)):
        return ""
    times = digits(ours / theirs, DIGITS)
    return f"Runs by method {other} took {times} times as long as those by {first}, by the clock."
