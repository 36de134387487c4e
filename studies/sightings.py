"""Observed shots, and what the simulation gives at their parameters."""

import itertools
import json
import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import xarray as xr

from studies.places import Place, axes_of, places_of, plain
from studies.points import simulated

ELSEWHERE = "not simulated: another"
SAME = 1e-9  # relative: axis values that differ by less are the same value written twice


@dataclass(frozen=True)
class Sighting:
    """An observed shot with what the simulation gives for it."""

    observation: int
    quantity: str
    unit: str
    source: str
    at: Place
    diameter: float | None  # of the equivalent sphere, m
    value: float
    uncertainty: float | None
    simulation: float | None
    simulation_uncertainty: float | None
    how: str  # how the simulation was brought to the shot's parameters, or why it could not be

    @property
    def elsewhere(self) -> bool:
        """Whether the shot is of another set-up than any run: it has no place among them."""
        return self.how.startswith(ELSEWHERE)


def sightings_of(dataset: xr.Dataset, name: str) -> Iterator[Sighting]:
    """The observed shots of a measured variable."""
    if f"{name}_observed" not in dataset:
        return
    for row in range(dataset.sizes["observation"]):
        shot = dataset.isel(observation=row)
        value = float(shot[f"{name}_observed"])
        if math.isfinite(value):
            at = _parameters_of(shot)
            simulation, uncertainty, how = bring_to(dataset, name, at)
            yield Sighting(
                observation=row,
                quantity=name,
                unit=dataset[name].attrs["units"],
                source=str(shot.observation_source.item()),
                at=at,
                diameter=_none(float(shot.observation_equivalent_diameter)),
                value=value,
                uncertainty=_none(float(shot[f"{name}_observed_uncertainty"])),
                simulation=_none(simulation),
                simulation_uncertainty=_none(uncertainty),
                how=how,
            )


def _parameters_of(shot: xr.Dataset) -> dict[str, float | str]:
    """What the shot states of itself, by parameter."""
    known = json.loads(shot.attrs["vocabulary"])["parameters"]
    names = {f"observation_{name}".replace(".", "_"): name for name in known}
    found = {
        name.removeprefix("observation_"): plain(shot[name].item())
        for name in names
        if name in shot
    }
    return {name: value for name, value in found.items() if value == value and value != ""}


def bring_to(dataset: xr.Dataset, name: str, at: Place) -> tuple[float, float, str]:
    """The simulated value and uncertainty at parameters off the grid, and how it was found.

    Linear between the neighbouring runs of a grid; the same axis values, along a zip. Never beyond
    the axes.
    """
    axes = axes_of(dataset)
    absent = [axis for axis in axes if axis not in at]
    if absent:
        return math.nan, math.nan, f"the shot does not state {', '.join(absent)}"
    other = [name for name in at if name not in axes and _is_another(dataset, name, at[name])]
    if other:
        return math.nan, math.nan, f"{ELSEWHERE} {', '.join(other)}"
    try:
        corners = _corners(dataset, axes, at)
    except LookupError as error:
        return math.nan, math.nan, str(error.args[0])
    value = _weighted(simulated(dataset, name), corners)
    uncertainty = _weighted(simulated(dataset, f"{name}_uncertainty"), corners)
    if math.isnan(value):
        return value, math.nan, "a neighbouring run has no value"
    return (
        value,
        uncertainty,
        "computed" if len(corners) == 1 else "linear between neighbouring runs",
    )


def _is_another(dataset: xr.Dataset, name: str, wanted: float | str) -> bool:
    """Whether the shot states a value for something fixed that no run of the sweep has."""
    if name not in dataset:
        return False
    return not any(_same(plain(value), wanted) for value in dataset[name].values.ravel())


Corner = tuple[float, dict[str, int]]  # weight, and the place of a run


def _corners(dataset: xr.Dataset, axes: Sequence[str], at: Place) -> list[Corner]:
    if "run" in dataset.dims:
        return [(1.0, {"run": _run_at(dataset, axes, at)})]
    sides = [_sides(dataset[axis].values, axis, at[axis]) for axis in axes]
    return [
        (
            math.prod(weight for weight, _ in corner),
            {axis: place for axis, (_, place) in zip(axes, corner, strict=True)},
        )
        for corner in itertools.product(*sides)
    ]


def _sides(values: np.ndarray, axis: str, wanted: float | str) -> list[tuple[float, int]]:
    """One value of an axis, or the two around it, with weights; LookupError outside the axis."""
    for place, value in enumerate(values):
        if _same(value, wanted):
            return [(1.0, place)]
    if isinstance(wanted, str) or not values.min() < wanted < values.max():
        raise LookupError(f"outside the axis {axis}")
    above = int(np.searchsorted(values, wanted))
    share = float((wanted - values[above - 1]) / (values[above] - values[above - 1]))
    return [(1.0 - share, above - 1), (share, above)]


def _run_at(dataset: xr.Dataset, axes: Sequence[str], at: Place) -> int:
    for run, place in enumerate(places_of(dataset)):
        if all(_same(place[axis], at[axis]) for axis in axes):
            return run
    raise LookupError("no run has these parameters")


def _same(one: Any, other: Any) -> bool:
    if isinstance(one, str) or isinstance(other, str):
        return str(one) == str(other)
    return math.isclose(one, other, rel_tol=SAME)


def _weighted(array: xr.DataArray, corners: Sequence[Corner]) -> float:
    return float(sum(weight * float(array.isel(place)) for weight, place in corners))


def _none(value: float) -> float | None:
    return value if math.isfinite(value) else None
