"""Computes the section of methods.

Parts of the definition and of the model are common to the methods, so that bars are those of the mesh and the reading.
"""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import xarray as xr

from studies.cubes import variables as cubes
from studies.cubes.points import by_run, comparable, error_bars, main_quantities, places_of
from studies.cubes.reading import finite
from studies.methods.section import ByMethod, ComparedMethod, Cost, Methods, QuantityByMethod
from studies.reports.records import Place
from studies.reports.section import Part, Source
from studies.reports.wording import text_template, worded

METHOD = "method"


def methods_of(source: Source) -> Part | None:
    """Values by each method less those by the first one; None of a sweep without several methods."""
    points = source.points
    if METHOD not in str(points.attrs["axes"]).split():
        return None
    first, *others = dict.fromkeys(map(str, by_run(points, METHOD)))
    if not others:
        return None
    quantities = []
    for name in main_quantities(points):
        rows = tuple(_rows(points, name, first))
        compared = tuple(_compared(other, [row for row in rows if row.method == other]) for other in others)
        quantities.append(QuantityByMethod(name, str(points[name].attrs["units"]), compared, rows))
    record = Methods(first, tuple(quantities), tuple(_costs(source.dataset, first, others)))
    return Part(record, opening=_opening(record))


def _rows(points: xr.Dataset, name: str, first: str) -> Iterator[ByMethod]:
    """A row for each point of another method that the first one computed too."""
    columns = [array.values.ravel() for array in (comparable(points, name), error_bars(points, name))]
    known: dict[tuple[tuple[str, float | str], ...], tuple[float, float]] = {}
    later: list[tuple[Place, str, float, float]] = []
    for place, value, bar in zip(places_of(points), *columns, strict=True):
        at = {axis: where for axis, where in place.items() if axis != METHOD}
        if place[METHOD] == first:
            known[tuple(at.items())] = float(value), float(bar)
        else:
            later.append((at, str(place[METHOD]), float(value), float(bar)))
    for there, method, value, bar in later:
        if tuple(there.items()) in known:
            reference, reference_bar = known[tuple(there.items())]
            yield ByMethod(
                at=there,
                method=method,
                reference=finite(reference),
                reference_bar=finite(reference_bar),
                value=finite(value),
                bar=finite(bar),
                difference=finite(value - reference),
                joint=finite(math.hypot(bar, reference_bar)),
                relative=finite(value / reference - 1.0) if reference else None,
            )


def _compared(method: str, rows: Sequence[ByMethod]) -> ComparedMethod:
    relative = [row.relative for row in rows if row.relative is not None]
    judged = [abs(row.difference) > row.joint for row in rows if row.difference is not None and row.joint is not None]
    smallest, largest = (min(relative), max(relative)) if relative else (None, None)
    return ComparedMethod(method, len(relative), smallest, largest, len(judged), sum(judged))


def _costs(dataset: xr.Dataset, first: str, others: Sequence[str]) -> Iterator[Cost]:
    if cubes.SOLVER_SECONDS.is_in(dataset):
        seconds, methods = by_run(dataset, cubes.SOLVER_SECONDS.name), by_run(dataset, METHOD).astype(str)
        took = {method: float(seconds[methods == method].sum()) for method in (first, *others)}
        for other in others:
            if took[first] > 0.0 and math.isfinite(took[other]):
                yield Cost(other, took[other] / took[first])


@dataclass(frozen=True)
class MethodsOpening:
    """What is said of a quantity that several methods measured."""

    quantity: str
    first: str
    others: tuple[str, ...]
    ends: tuple[float, float]  # smallest and largest difference, over the value by the first method
    bar: float | None  # largest joint bar over the same; None where no mesh error is known


def _opening(methods: Methods) -> str:
    """ "Contact time by fem: −3 % beside mpm; ±4 %.", of the first quantity that several methods measured."""
    for quantity in methods.quantities:
        rows = [row for row in quantity.rows if row.relative is not None]
        if rows:
            relative = [row.relative for row in rows if row.relative is not None]
            bars = [row.joint / abs(row.reference) for row in rows if row.joint is not None and row.reference]
            opening = MethodsOpening(
                quantity=quantity.quantity,
                first=methods.first,
                others=tuple(dict.fromkeys(row.method for row in rows)),
                ends=(min(relative), max(relative)),
                bar=max(bars, default=None),
            )
            return worded(text_template("studies.methods:headline.txt"), opening=opening)
    return ""
