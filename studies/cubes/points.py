"""The points of a cube: what a user asked for, one value each, converged over resolutions and offsets.

A cube without refinements is its own points. Laws, observations and figures look at points; runs and audit at runs.
"""

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
import xarray as xr

from studies.convergence.richardson import VERDICTS, Convergence, Sample, levels_of
from studies.cubes import reading
from studies.cubes import variables as cubes
from studies.cubes.variable import Variable, is_reading
from studies.quantities.measured import MESH, NOT_COMPARED
from studies.quantities.parameters import Value
from studies.sweeps.reading import OFFSET, RESOLUTION

SAME = 1e-9  # relative: values of an axis that differ by less are the same value written twice
SUCCEEDED = cubes.STATES.index("succeeded")

Place = Mapping[str, float | str]  # axis -> value


@dataclass(frozen=True)
class Refined:
    """One quantity at one point, with the runs behind it."""

    number: int  # of the point
    spacings: np.ndarray  # (runs,) size of a cell over the projectile's diameter
    values: np.ndarray  # (runs,) NaN where a run has none
    converged: Convergence  # as stored in the cube; its levels from the runs


# ---- where cells are -----------------------------------------------------------------------------


def refinements_of(dataset: xr.Dataset) -> list[str]:
    """The dimensions over which points are refined: resolution and offset, where there are several."""
    return [name for name in str(dataset.attrs["refinements"]).split() if name in dataset.dims]


def axes_of(dataset: xr.Dataset) -> list[str]:
    """Names of the axes of the sweep, dimensions or not; where cells are runs, of refinements too."""
    return [*str(dataset.attrs["axes"]).split(), *refinements_of(dataset)]


def places_of(dataset: xr.Dataset, axes: Sequence[str] | None = None) -> list[dict[str, float | str]]:
    """The values of the axes, or of some, at each cell, in the order in which ``values.ravel()`` has them."""
    columns = {axis: by_run(dataset, axis) for axis in (axes_of(dataset) if axes is None else axes)}
    return [{axis: plain(column[cell]) for axis, column in columns.items()} for cell in range(dataset.run_state.size)]


def by_run(dataset: xr.Dataset, name: str) -> np.ndarray:
    """The values of a variable for each cell, (cells,), whatever it varies along."""
    return reading.by_run(dataset, dataset.variables[name]).ravel()


def plain(value: Value) -> float | str:
    """A coordinate's value as a float or a text of Python's own."""
    assert value is not None
    return str(value) if isinstance(value, str) else float(value)


def is_same(value: float | str, other: float | str, within: float = SAME) -> bool:
    """Whether two values of an axis are one: equal texts, or numbers that differ by no more than this share."""
    if isinstance(value, str) or isinstance(other, str):
        return bool(value == other)
    return math.isclose(value, other, rel_tol=within)


# ---- what may be used ----------------------------------------------------------------------------


def simulated(dataset: xr.Dataset, name: str, variable: Variable = cubes.VALUE) -> xr.DataArray:
    """A variable of a measured quantity where the run succeeded; NaN elsewhere."""
    named = variable.named(name)
    # A deep copy of its coordinates takes ten times as long (1.1 and 0.15 ms, November 2026).
    copied = dataset.run_state.copy(deep=False, data=simulated_values(dataset, named))
    copied.name, copied.attrs = named, dataset.variables[named].attrs
    return copied


def simulated_values(dataset: xr.Dataset, name: str) -> np.ndarray:
    """The values of a variable in the shape of ``run_state``, where the run succeeded; NaN elsewhere."""
    # A report asks some hundred times: ``where`` of xarray takes 4 ms, and to make an array with its coordinates 0.1.
    succeeded = dataset.variables["run_state"].values == SUCCEEDED
    return np.where(succeeded, reading.by_run(dataset, dataset.variables[name]), np.nan)


def simulated_or_nan(dataset: xr.Dataset, name: str) -> np.ndarray:
    """The same of each cell, (cells,); NaN everywhere where the cube does not have the variable."""
    if name not in dataset:
        return np.full(dataset.run_state.size, np.nan)
    return simulated_values(dataset, name).ravel()


def comparable(dataset: xr.Dataset, name: str) -> xr.DataArray:
    """A measured quantity where a law may be compared with it; NaN where its flags speak against it.

    NaN everywhere where runs were measured with several versions of its definition: they do not compare among
    themselves.
    """
    if reading.mixed_versions(dataset, name):
        return xr.full_like(simulated(dataset, name), np.nan)
    flags = cubes.FLAGS.of(dataset, name)
    against = sum(mask for mask, word in reading.flag_meanings(flags) if word in NOT_COMPARED)
    values = simulated(dataset, name)
    usable = reading.by_run(dataset, flags.variable) & against == 0
    return values.copy(deep=False, data=np.where(usable, values.values, np.nan))


def error_bars(points: xr.Dataset, name: str) -> xr.DataArray:
    """Error bars of a quantity at points where the run succeeded and its mesh error is known; NaN elsewhere.

    A single grid does not show how far off it is: what its measurement states for itself is no error bar.
    """
    bars = simulated(points, name, cubes.UNCERTAINTY)
    return bars.copy(deep=False, data=np.where(np.isfinite(mesh_part(points, name)), bars.values, np.nan))


def mesh_part(points: xr.Dataset, name: str) -> np.ndarray:
    """The mesh part of the uncertainty of a quantity, in the shape of ``run_state``; NaN where it is not known."""
    of_point = cubes.MESH_PART if cubes.MESH_PART.is_in(points, name) else cubes.uncertainty_part(MESH)
    if not of_point.is_in(points, name):
        return np.full(points.run_state.shape, np.nan)
    return reading.by_run(points, of_point.of(points, name).variable)


def main_quantities(dataset: xr.Dataset) -> list[str]:
    """Quantities that are no other reading of one (``hole_diameter_lip`` of ``hole_diameter``)."""
    names = reading.quantities_of(dataset)
    return [name for name in names if not is_reading(name, names)]


# ---- points --------------------------------------------------------------------------------------


def points_of(dataset: xr.Dataset) -> xr.Dataset:
    """The cube with one cell a point: converged values, and else those of the finest runs.

    A point has succeeded where any of its quantities has a value. Its flags are those of its finest runs and, where
    these have no value, those of the finest that do.
    """
    refinements = refinements_of(dataset)
    if not refinements:
        return dataset
    finest = dataset.isel({RESOLUTION: -1} if RESOLUTION in refinements else {}, drop=True)
    points = finest.isel({OFFSET: 0} if OFFSET in refinements else {}, drop=True)
    names = reading.quantities_of(dataset)
    # Variables without coordinates, all at once: xarray aligns and copies at each assignment.
    changed: dict[str, xr.Variable] = {"run_flags": _flags(dataset, cubes.FLAGS_OF_RUN.of(dataset), names)}
    for name in names:
        converged = cubes.CONVERGED.of(dataset, name)
        changed[name] = xr.Variable(converged.dims, converged.values, cubes.VALUE.of(dataset, name).attrs)
        changed[cubes.UNCERTAINTY.named(name)] = cubes.CONVERGED_UNCERTAINTY.of(dataset, name).variable
        changed[cubes.FLAGS.named(name)] = _flags(dataset, cubes.FLAGS.of(dataset, name), [name])
        changed |= _model_part(dataset, name)
    valued = np.logical_or.reduce([np.isfinite(changed[name].values) for name in names])
    state = points.run_state.variable
    changed["run_state"] = state.copy(data=np.where(valued, np.int8(SUCCEEDED), state.values).astype(np.int8))
    return points.assign(changed)


def refined(dataset: xr.Dataset, name: str) -> Iterator[Refined]:
    """A quantity of each point of a refined cube, in the order of its points."""
    shape = -1, math.prod(dataset.sizes[axis] for axis in refinements_of(dataset))
    by_point = simulated_values(dataset, name).reshape(shape)
    several = RESOLUTION in refinements_of(dataset)  # one alone has no name
    spacings = 1.0 / by_run(dataset, RESOLUTION).reshape(shape) if several else np.ones(by_point.shape)
    columns = [variable.of(dataset, name).values.ravel() for variable in cubes.OF_CONVERGENCE]
    rows = zip(*columns, strict=True)
    for number, (sizes, values, row) in enumerate(zip(spacings, by_point, rows, strict=True)):
        value, _, mesh, offsets, measurement, order, extrapolated, gci = map(float, row[:-2])
        levels = levels_of(Sample(float(h), float(value)) for h, value in zip(sizes, values, strict=True))
        parts = (value, mesh, offsets, measurement, order, extrapolated, gci)
        yield Refined(number, sizes, values, Convergence(VERDICTS[row[-2]], str(row[-1]), *parts, levels))


def verdicts_of(dataset: xr.Dataset, name: str) -> xr.DataArray:
    """The verdict on the convergence of a quantity at each point, in words."""
    verdicts = cubes.VERDICT.of(dataset, name)
    return verdicts.copy(data=np.asarray(np.take(VERDICTS, verdicts.values)))


def _flags(dataset: xr.Dataset, flags: xr.DataArray, names: Sequence[str]) -> xr.Variable:
    """Flags of the points: of the finest runs, and of the finest with a value of one of the names, at any offset."""
    raised = np.bitwise_or.reduce(_finest_first(dataset, reading.by_run(dataset, flags.variable)), -1)
    of_points = raised[..., 0]
    for name in names:
        valued = np.isfinite(_finest_first(dataset, simulated_values(dataset, name))).any(-1)
        finest = np.take_along_axis(raised, valued.argmax(-1, keepdims=True), -1)
        of_points = of_points | finest[..., 0]
    return xr.Variable(_point_dims(dataset), of_points, flags.attrs)


def _model_part(dataset: xr.Dataset, name: str) -> dict[str, xr.Variable]:
    """The model part of each point, with its reason and shares: that of the finest run with a value, at any offset."""

    def by_point(values: np.ndarray) -> np.ndarray:
        """(points..., runs of a point), the finest first."""
        by_grid = _finest_first(dataset, values)
        return by_grid.reshape(*by_grid.shape[:-2], -1)

    first = np.isfinite(by_point(simulated_values(dataset, name))).argmax(-1, keepdims=True)
    chosen = {}
    for part in (part for part in dataset.data_vars if str(part).startswith(cubes.MODEL_PART.named(name))):
        stored = dataset.variables[part]
        values = np.take_along_axis(by_point(reading.by_run(dataset, stored)), first, -1)[..., 0]
        chosen[str(part)] = xr.Variable(_point_dims(dataset), values, stored.attrs)
    return chosen


def _point_dims(dataset: xr.Dataset) -> list[str]:
    """The dimensions of the runs before those of their refinements."""
    refinements = refinements_of(dataset)
    return [str(name) for name in dataset.run_state.dims if name not in refinements]


def _finest_first(dataset: xr.Dataset, values: np.ndarray) -> np.ndarray:
    """Values of the runs as (points..., resolutions, offsets), the finest resolution first."""
    sizes = [dataset.sizes[name] if name in refinements_of(dataset) else 1 for name in (RESOLUTION, OFFSET)]
    return np.flip(values.reshape(*values.shape[: len(_point_dims(dataset))], *sizes), -2)
