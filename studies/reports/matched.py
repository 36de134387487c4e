"""Measured shots beside the simulation: those of the sweep's own table, and those that ship and repeat a point."""

import json
import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import fields
from functools import cache
from typing import NamedTuple

import numpy as np
import xarray as xr

from studies import materials, observations
from studies.cubes import variables as cubes
from studies.cubes.points import Place, axes_of, by_run, comparable, error_bars, is_same, places_of, plain, simulated
from studies.cubes.reading import finite
from studies.cubes.variable import variable_name
from studies.observations import UNKNOWN_ALLOY, Observation
from studies.quantities.findings import InvalidInput
from studies.reports.evidence import FIRST_HAND
from studies.reports.records import Doubt, MatchedObservation, MeasuredShot, StatedShot, Where
from studies.reports.wording import words
from studies.sweeps.reading import published_shots

NEAR = 0.10  # relative: a shot is like a point where no number that both state differs by more
SAME = 0.01  # relative: what is fixed in the sweep and differs by more is another size
A_RANGE = "a range alone is published: nothing is compared with it"
LINEAR = "linear between neighbouring runs"


class Interpolated(NamedTuple):
    """The simulation at the parameters of a shot, in the unit of the quantity; NaN where there is none."""

    value: float
    uncertainty: float
    how: str  # how it was found, or why it could not be
    where: Where = Where.AMONG


def matched_observations(dataset: xr.Dataset, name: str) -> Iterator[MatchedObservation]:
    """The observed shots of a measured quantity; ``dataset`` is of points."""
    if not cubes.OBSERVED.is_in(dataset, name):
        return
    confidence = cubes.OBSERVATION_CONFIDENCE  # in no cube of shots without any
    barred = dataset.assign({cubes.UNCERTAINTY.named(name): error_bars(dataset, name)})
    for row in range(dataset.sizes["observation"]):
        shot = dataset.isel(observation=row)
        value, *bounds = (
            finite(float(variable.of(shot, name))) if variable.is_in(shot, name) else None
            for variable in (cubes.OBSERVED, *cubes.OBSERVED_BOUNDS)
        )
        if value is not None or any(bound is not None for bound in bounds):
            at = _parameters_of(shot)
            without = Interpolated(math.nan, math.nan, A_RANGE)
            found = without if value is None else interpolate(barred, name, at)
            yield MatchedObservation(
                quantity=name,
                unit=dataset[name].attrs["units"],
                at=at,
                value=value,
                uncertainty=finite(float(cubes.OBSERVED_UNCERTAINTY.of(shot, name))),
                lower=bounds[0],
                upper=bounds[1],
                source=str(cubes.OBSERVATION_SOURCE.of(shot).item()),
                confidence=str(confidence.of(shot).item()) if confidence.is_in(shot) else "",
                observation=row,
                diameter=finite(float(cubes.OBSERVATION_DIAMETER.of(shot))),
                simulation=finite(found.value),
                simulation_uncertainty=finite(found.uncertainty),
                how=found.how,
                where=found.where,
                is_alike=value is not None
                and not any(
                    isinstance(value, str) and _is_another(dataset, parameter, value) for parameter, value in at.items()
                ),
            )


def _parameters_of(shot: xr.Dataset) -> dict[str, float | str]:
    """The parameters that a shot states."""
    stated = {}
    for parameter in json.loads(shot.attrs["vocabulary"])["parameters"]:
        name = variable_name(parameter)
        if f"observation_{name}" in shot:
            stated[name] = plain(shot[f"observation_{name}"].item())
    return {name: value for name, value in stated.items() if value == value and value != ""}


def interpolate(dataset: xr.Dataset, name: str, at: Place) -> Interpolated:
    """The simulated value and uncertainty at parameters off the grid, and how it was found.

    Linear between the neighbouring runs of a grid; the same axis values, along a zip. Never beyond
    the axes. The uncertainty is that of the runs, weighted, and between runs the error of the
    interpolation with it, root of the sum of squares; NaN where a run has none.
    """
    axes = axes_of(dataset)
    absent = [axis for axis in axes if axis not in at]
    if absent:
        return Interpolated(math.nan, math.nan, f"the shot does not state {words(', '.join(absent))}", Where.UNKNOWN)
    other = [name for name in at if name not in axes and _is_another(dataset, name, at[name])]
    if other:
        return Interpolated(math.nan, math.nan, f"the shot has another {words(', '.join(other))}", Where.ELSEWHERE)
    try:
        sides = _sides_of(dataset, axes, at)
    except LookupError as error:
        return Interpolated(math.nan, math.nan, *error.args)
    values = comparable(dataset, name)
    value = float(_weighted(values, sides))
    chords = [axis for axis, around in sides.items() if len(around) > 1]
    if math.isnan(value):
        which = "a neighbouring run" if chords else "the run at these parameters"
        return Interpolated(value, math.nan, f"{which} has no comparable value")
    weighted = float(_weighted(simulated(dataset, name, cubes.UNCERTAINTY), sides))
    if not chords:
        return Interpolated(value, weighted, "computed")
    # Plainly summed: chords err by the curve's bend, and two axes that bend the same way err the same way.
    bent = sum(_chord_error(values, sides, axis, dataset[axis].values) for axis in chords)
    barred = "" if math.isnan(weighted) else "; the error bar includes the interpolation error"
    return Interpolated(value, math.hypot(weighted, bent), LINEAR + barred)


def _is_another(dataset: xr.Dataset, name: str, wanted: float | str) -> bool:
    """Whether the shot states a value for something fixed that no run of the sweep has."""
    return name in dataset and not any(is_same(plain(value), wanted) for value in dataset[name].values.ravel())


Sides = Mapping[str, list[tuple[float, int]]]  # by dimension: weights, and places around the shot


def _sides_of(dataset: xr.Dataset, axes: Sequence[str], at: Place) -> Sides:
    """The neighbours of a shot; LookupError where there are none."""
    if "run" not in dataset.dims:
        return {axis: _sides(dataset[axis].values, axis, at[axis]) for axis in axes}
    for run, place in enumerate(places_of(dataset)):
        if all(is_same(place[axis], at[axis]) for axis in axes):
            return {"run": [(1.0, run)]}
    raise LookupError("no run has the parameters of the shot", Where.UNKNOWN)


def _sides(values: np.ndarray, axis: str, wanted: float | str) -> list[tuple[float, int]]:
    """One value of an axis, or the two around it, with weights; LookupError outside the axis."""
    for place, value in enumerate(values):
        if is_same(value, wanted):
            return [(1.0, place)]
    if isinstance(wanted, str) or not values.min() < wanted < values.max():
        raise LookupError(f"the shot lies outside the axis {words(axis)}", Where.BEYOND_AXES)
    above = int(np.searchsorted(values, wanted))
    share = float((wanted - values[above - 1]) / (values[above] - values[above - 1]))
    return [(1.0 - share, above - 1), (share, above)]


def _weighted(values: xr.DataArray, sides: Sides) -> xr.DataArray:
    """Values with each dimension of ``sides`` interpolated to the shot; NaN where a run has none."""
    for dimension, around in sides.items():
        weights = xr.DataArray([weight for weight, _ in around], dims=dimension)
        values = values.isel({dimension: [place for _, place in around]}).dot(weights)
    return values


def _chord_error(values: xr.DataArray, sides: Sides, axis: str, x: np.ndarray) -> float:
    """Error bound of a chord along one axis, at the shot's place on the others.

    The next order, |f[x0, x1, x2] (x - x0) (x - x1)|, estimates it: x2 is the next value of the axis
    on either side, the one that gives more. Where neither has a run with a value the next order is
    unknown: then it is half the difference of the chord's ends times 4 w (1 - w), w the weight, which is
    twice the most that a monotonic quadratic can be off.
    """
    others = {name: around for name, around in sides.items() if name != axis}
    f = _weighted(values, others).values
    (below, low), (above, high) = sides[axis]
    rise = f[high] - f[low]
    bends = [
        ((f[third] - f[high]) / (x[third] - x[high]) - rise / (x[high] - x[low])) / (x[third] - x[low])
        for third in (low - 1, high + 1)
        if 0 <= third < len(x) and math.isfinite(f[third])
    ]
    if not bends:
        return 0.5 * abs(float(rise)) * 4.0 * below * above
    # (x - x0) (x1 - x) = w (1 - w) (x1 - x0)^2
    return max(abs(float(bend)) for bend in bends) * below * above * float(x[high] - x[low]) ** 2


# ---- shots that a point repeats --------------------------------------------------------------------


def measured_shots(points: xr.Dataset, name: str, own: Iterable[StatedShot]) -> Iterator[MeasuredShot]:
    """The shots of a quantity that are like a point; each once. A shot that does not state an axis is like none."""
    unit = str(points[name].attrs["units"])
    shots = [shot for shot in own if shot.quantity == name]
    shots += [_of_table(shot, unit) for shot in _shipped(str(points.attrs["scenario"]), name)]
    columns = {key: by_run(points, key) for shot in shots for key in shot.at if key in points}
    axes = axes_of(points)
    needed = {axis for axis in axes if axis in columns}
    barred = points.assign({cubes.UNCERTAINTY.named(name): error_bars(points, name)})
    places, seen = places_of(points), set()
    for shot in shots:
        # As exactly as a table prints them: the same shot may come from two tables.
        rounded = {key: float(f"{value:.6g}") for key, value in shot.at.items() if isinstance(value, float)}
        told = (shot.value, shot.lower, shot.upper, *sorted(rounded.items()))
        near = _nearest(shot.at, columns, axes) if needed <= shot.at.keys() else None
        if near is None or told in seen:
            continue
        seen.add(told)
        number, doubts = near
        if shot.confidence not in FIRST_HAND:
            doubts = (*doubts, Doubt.SECOND_HAND)
        place = places[number]
        # At its own values of the axes that are numbers.
        own_place = {key: value for key, value in shot.at.items() if key in place and isinstance(value, float)}
        value, bar, *_ = interpolate(barred, name, {**place, **own_place})
        stated = {field.name: getattr(shot, field.name) for field in fields(StatedShot)}
        yield MeasuredShot(**stated, point=place, doubts=doubts, simulation=finite(value), simulation_bar=finite(bar))


def _of_table(shot: Observation, unit: str) -> StatedShot:
    """A shot that ships, with texts and numbers of its parameters by the names of the cube."""
    at = {
        variable_name(key): value if isinstance(value, str) else float(value)
        for key, value in shot.parameters.items()
        if isinstance(value, str | float)
    }
    bounds = shot.bounds or (None, None)
    return StatedShot(shot.quantity, unit, at, shot.value, shot.uncertainty, *bounds, shot.source, shot.confidence)


@cache
def _shipped(scenario: str, quantity: str) -> Sequence[Observation]:
    """The shots that ship and have a quantity of a scenario."""
    found: list[Observation] = []
    for table in observations.names():
        if quantity in observations.text(table):
            with suppress(InvalidInput):  # of another scenario
                found += [shot for shot in published_shots(table, scenario) if shot.quantity == quantity]
    return found


def _nearest(at: Place, columns: dict[str, np.ndarray], axes: Sequence[str]) -> tuple[int, tuple[Doubt, ...]] | None:
    """The number of the point that is nearest to a shot, with the doubts about the shot; None where none is like it.

    A shot between the points of an axis is like the nearest of them: the simulation is brought to it.
    """
    stated = [key for key in at if key in columns]
    if not any(isinstance(at[key], float) for key in stated):
        return None
    distance = np.zeros(len(columns[stated[0]]))
    is_metal = False
    differs = np.zeros(len(distance), bool)
    for key in stated:
        wanted, column = at[key], columns[key]
        if isinstance(wanted, str):
            kinds = [_likeness(wanted, str(own)) for own in column]
            distance += [0.0 if kind else math.inf for kind in kinds]
            is_metal |= "metal" in kinds
        else:
            numbers = np.asarray(column, float)
            off, scale = np.abs(numbers - wanted), NEAR * abs(wanted)
            is_near = off <= scale
            if key in axes:
                is_near |= bool(numbers.min() <= wanted <= numbers.max())
            else:
                differs |= off > SAME * abs(wanted)
            distance += np.where(np.isnan(off), 0.0, np.where(is_near, off, np.inf) / (scale or 1.0))
    number = int(np.argmin(distance))
    doubts = (Doubt.UNKNOWN_ALLOY,) * is_metal + (Doubt.OTHER_SIZE,) * bool(differs[number])
    return (number, doubts) if math.isfinite(distance[number]) else None


def _likeness(wanted: str, own: str) -> str:
    """How far a word of a shot is that of a run: "same", "metal" of an alloy that its source does not name, or ""."""
    if wanted == own:
        return "same"
    with suppress(InvalidInput):
        mine = materials.load(own)
        if wanted.endswith(UNKNOWN_ALLOY):
            return "metal" * (mine.family == wanted.removesuffix(UNKNOWN_ALLOY))
        return "same" * (mine.alloy == materials.load(wanted).alloy)
    return ""
