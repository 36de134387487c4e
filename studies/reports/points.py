"""The points of a cube: what a user asked for, one value each, converged over resolutions and offsets.

A cube without refinements is its own points. Laws, observations and figures look at points; runs and audit at runs.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
import xarray as xr

from studies.convergence.richardson import VERDICTS, Level, Sample, Verdict, levels_of
from studies.cubes.variables import STATES
from studies.results import NOT_COMPARED
from studies.sweeps.sweep import OFFSET, RESOLUTION

SUCCEEDED = STATES.index("succeeded")
# Verdicts under which the value is the finest resolution's although refinement was asked about.
UNSETTLED: tuple[Verdict, ...] = (
    "oscillatory",
    "not in the asymptotic range",
    "two grids",
    "single grid",
)


@dataclass(frozen=True)
class Refined:
    """One quantity at one point, with the runs behind it."""

    number: int  # of the point
    spacings: np.ndarray  # (runs,) size of a cell over the projectile's diameter
    values: np.ndarray  # (runs,) NaN where a run has none
    levels: tuple[Level, ...]  # the finest first
    value: float
    uncertainty: float
    mesh: float  # parts of the uncertainty
    offsets: float
    measurement: float
    order: float
    extrapolated: float
    gci: float
    verdict: Verdict
    reason: str


def refinements_of(dataset: xr.Dataset) -> list[str]:
    """The dimensions over which points are refined: resolution and offset, where there are several."""
    named = str(dataset.attrs.get("refinements", "")).split()  # a cube of schema 1 names none
    return [name for name in named if name in dataset.dims]


def simulated(dataset: xr.Dataset, name: str) -> xr.DataArray:
    """A measured variable where the run succeeded; NaN elsewhere."""
    return dataset[name].where(dataset.run_state == SUCCEEDED)


def comparable(dataset: xr.Dataset, name: str) -> xr.DataArray:
    """A measured variable where a law may be compared with it; NaN where its flags speak against it."""
    flags = dataset[f"{name}_flags"]
    masks = np.atleast_1d(flags.attrs["flag_masks"])
    meanings = str(flags.attrs["flag_meanings"]).split()
    against = sum(mask for mask, word in zip(masks, meanings, strict=True) if word in NOT_COMPARED)
    return simulated(dataset, name).where(flags & int(against) == 0)


def points_of(dataset: xr.Dataset) -> xr.Dataset:
    """The cube with one cell a point: converged values, and else what the finest runs say.

    A point has succeeded where any of its quantities has a value. Its flags are those of its finest runs and, where
    these have no value, those of the finest that do.
    """
    refinements = refinements_of(dataset)
    if not refinements:
        return dataset
    finest = dataset.isel({RESOLUTION: -1} if RESOLUTION in refinements else {}, drop=True)
    points = finest.isel({OFFSET: 0} if OFFSET in refinements else {}, drop=True)
    names = str(dataset.attrs["quantities"]).split()
    for name in names:
        points[name] = dataset[f"{name}_converged"].assign_attrs(dataset[name].attrs)
        points[f"{name}_uncertainty"] = dataset[f"{name}_converged_uncertainty"]
    for name in names:
        points[f"{name}_flags"] = _flags(dataset, f"{name}_flags", [name])
    points["run_flags"] = _flags(dataset, "run_flags", names)
    valued = np.logical_or.reduce([np.isfinite(points[name].values) for name in names])
    points["run_state"] = points.run_state.where(~valued, np.int8(SUCCEEDED))
    return points


def refined(dataset: xr.Dataset, name: str) -> Iterator[Refined]:
    """A quantity of each point of a refined cube, in the order of its points."""
    by_point = _flat(simulated(dataset, name), dataset)
    several = RESOLUTION in refinements_of(dataset)
    cells = dataset[RESOLUTION] if several else xr.DataArray(1.0)  # one alone has no name
    spacings = _flat((1.0 / cells).broadcast_like(dataset.run_state), dataset)
    columns = {key: dataset[f"{name}_converged{key}"].values.ravel() for key in _NUMBERS}
    verdicts = dataset[f"{name}_converged_verdict"].values.ravel()
    reasons = dataset[f"{name}_converged_reason"].values.ravel()
    for number, (cells, values) in enumerate(zip(spacings, by_point, strict=True)):
        samples = [Sample(float(h), float(value)) for h, value in zip(cells, values, strict=True)]
        yield Refined(
            number,
            cells,
            values,
            levels_of(samples),
            **{field: float(columns[key][number]) for key, field in _NUMBERS.items()},
            verdict=VERDICTS[verdicts[number]],
            reason=str(reasons[number]),
        )


_NUMBERS = {
    "": "value",
    "_uncertainty": "uncertainty",
    "_uncertainty_mesh": "mesh",
    "_uncertainty_offsets": "offsets",
    "_uncertainty_measurement": "measurement",
    "_order": "order",
    "_extrapolated": "extrapolated",
    "_gci": "gci",
}


def _flags(dataset: xr.Dataset, flags: str, names: Sequence[str]) -> xr.DataArray:
    """Flags of the points: of the finest runs, and of the finest with a value of one of the names, at any offset."""
    found = dataset[flags]
    if OFFSET in found.dims:
        found = found.reduce(np.bitwise_or.reduce, OFFSET, keep_attrs=True)
    if RESOLUTION not in found.dims:
        return found
    points = found.isel({RESOLUTION: -1}, drop=True)
    for name in names:
        valued = simulated(dataset, name).notnull()
        valued = valued.any(OFFSET) if OFFSET in valued.dims else valued
        coarser = valued.isel({RESOLUTION: slice(None, None, -1)}).argmax(RESOLUTION)  # by so many
        last = dataset.sizes[RESOLUTION] - 1
        points = points | found.isel({RESOLUTION: last - coarser}).drop_vars(RESOLUTION)
    return points.assign_attrs(found.attrs)


def _flat(array: xr.DataArray, dataset: xr.Dataset) -> np.ndarray:
    """A variable of the runs as (points, runs of a point)."""
    kept = len(dataset.run_state.dims) - len(refinements_of(dataset))
    values = array.transpose(*dataset.run_state.dims).values
    return values.reshape(int(np.prod(values.shape[:kept])), -1)
