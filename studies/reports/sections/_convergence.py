"""Computes the section of accuracy: of each point its value, the parts of its bar, and its grids."""

import math
from collections.abc import Iterator, Mapping

import numpy as np
import xarray as xr

from studies.convergence.richardson import COVERAGE, ORDERS, SAFETY
from studies.cubes import reading
from studies.cubes import variables as cubes
from studies.cubes.points import (
    Refined,
    error_bars,
    main_quantities,
    mesh_part,
    places_of,
    refined,
    refinements_of,
    simulated_or_nan,
)
from studies.cubes.reading import finite
from studies.cubes.variable import Variable
from studies.reports.section import Part, Source
from studies.reports.sections.convergence import Convergence, GridLevel, PointConvergence, QuantityConvergence
from studies.sweeps.reading import OFFSET, RESOLUTION

RULES = (
    "The value is that of the finest resolution, the mean over its sub-cell offsets; the number behind ± is their "
    "standard deviation. Where the three finest resolutions show an order of "
    f"{ORDERS[0]:g} to {ORDERS[1]:g} (Celik et al. 2008, J. Fluids Eng. 130, 078001), with {COVERAGE:g} times their "
    "noise against it, a point is converging, and its mesh error is the grid convergence index of the values so "
    f"shifted, factor {SAFETY:g} (Roache 1994). Elsewhere the order and the mesh error are unknown."
)

# What is stated of each point whatever its grids, by the names of its record.
BESIDE: Mapping[str, Variable] = {
    "model": cubes.MODEL_PART,
    "lower": cubes.MODEL_SIDES[0][0],
    "upper": cubes.MODEL_SIDES[1][0],
}


def convergence_of(source: Source) -> Part | None:
    """The section; None where nothing was measured."""
    dataset, points = source.dataset, source.points
    main = main_quantities(points)
    quantities = tuple(
        QuantityConvergence(name, str(points[name].attrs["units"]), name in main, tuple(_points(dataset, points, name)))
        for name in reading.quantities_of(points)
        if name in main or refinements_of(dataset)
    )
    if not quantities:
        return None
    several = refinements_of(dataset)
    resolutions = tuple(map(float, dataset[RESOLUTION].values)) if RESOLUTION in several else ()
    return Part(Convergence(RULES, resolutions, dataset.sizes[OFFSET] if OFFSET in several else 1, quantities))


def _points(dataset: xr.Dataset, points: xr.Dataset, name: str) -> Iterator[PointConvergence]:
    places = places_of(points)
    columns = {key: simulated_or_nan(points, variable.named(name)) for key, variable in BESIDE.items()}
    beside = [{key: finite(float(column[number])) for key, column in columns.items()} for number in range(len(places))]
    if refinements_of(dataset):
        for point in refined(dataset, name):
            yield _of_grids(point, places[point.number], beside[point.number])
        return
    bars, mesh = error_bars(points, name).values.ravel(), np.ravel(mesh_part(points, name))
    values, raw, reading_error = (
        simulated_or_nan(points, each) for each in (name, cubes.RAW.named(name), cubes.UNCERTAINTY.named(name))
    )
    for number, (at, also) in enumerate(zip(places, beside, strict=True)):
        is_known = math.isfinite(mesh[number])
        yield PointConvergence(
            at=at,
            verdict="mesh error known" if is_known else "single grid",
            value=finite(float(values[number])),
            uncertainty=finite(float(bars[number])),
            mesh=finite(float(mesh[number])),
            # Of reading it off the grid; with a mesh error that is part of the bar.
            measurement=None if is_known else finite(float(reading_error[number])),
            raw=finite(float(raw[number])) if is_known else None,
            **also,  # type: ignore[arg-type] # numbers by the names of fields
        )


def _of_grids(point: Refined, at: Mapping[str, float | str], beside: Mapping[str, float | None]) -> PointConvergence:
    converged = point.converged
    numbers = ("value", "mesh", "offsets", "measurement", "order", "extrapolated", "gci")
    levels = (
        GridLevel(level.spacing, finite(level.value), finite(level.scatter), level.values, level.runs)
        for level in reversed(converged.levels)
    )
    return PointConvergence(
        at=at,
        verdict=converged.verdict,
        reason=converged.reason,
        uncertainty=None if math.isnan(converged.mesh) else finite(converged.uncertainty),
        **{name: finite(getattr(converged, name)) for name in numbers},
        **beside,
        levels=tuple(levels),
    )
