"""Computes the sections of accuracy: of each point its value, parts of its bar and grids; and the model part."""

import math
from collections import Counter
from collections.abc import Iterator, Mapping

import numpy as np
import xarray as xr

from studies.convergence.richardson import COVERAGE, ORDERS, SAFETY
from studies.cubes import reading
from studies.cubes import variables as cubes
from studies.cubes.points import (
    Refined,
    by_run,
    error_bars,
    main_quantities,
    mesh_part,
    places_of,
    refined,
    refinements_of,
    simulated_or_nan,
)
from studies.cubes.reading import finite
from studies.cubes.variable import OUTCOMES, Variable
from studies.reports.section import Part, Source
from studies.reports.sections.accuracy import (
    Convergence,
    GridLevel,
    ModelPart,
    Models,
    PointConvergence,
    QuantityConvergence,
    Side,
)
from studies.sweeps.reading import OFFSET, RESOLUTION
from studies.sweeps.screening import CONTRIBUTIONS

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
    several = refinements_of(dataset)
    main = [name for name in main_quantities(points) if several or OUTCOMES not in points[name].attrs]
    quantities = tuple(
        QuantityConvergence(name, str(points[name].attrs["units"]), name in main, tuple(_points(dataset, points, name)))
        for name in reading.quantities_of(points)
        if name in main or several
    )
    if not quantities:
        return None
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
        simulated_or_nan(points, variable) for variable in (name, cubes.RAW.named(name), cubes.UNCERTAINTY.named(name))
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


# ---- the model part -------------------------------------------------------------------------------


def models_of(source: Source) -> Part | None:
    """The section; None where no run states any."""
    parts = tuple(_model_parts(source.dataset))
    return Part(Models(parts)) if parts else None


def _model_parts(dataset: xr.Dataset) -> Iterator[ModelPart]:
    """Each statement with the runs that it is about."""
    for quantity in reading.quantities_of(dataset):
        shares = {name: _by_run(dataset, cubes.model_contribution(name), quantity) for name in CONTRIBUTIONS}
        factors = _by_run(dataset, cubes.MODEL_DISTANCE, quantity)
        texts = by_run(dataset, cubes.MODEL_REASON.named(quantity)).astype(str)
        for text, count in Counter(filter(None, texts.tolist())).items():
            mine = texts == text
            distances = factors[mine & np.isfinite(factors)]
            yield ModelPart(
                quantity=quantity,
                statement=text,
                contributions={name: finite(float(share[mine][0])) for name, share in shares.items()},
                lower=_side(dataset, quantity, cubes.MODEL_SIDES[0], mine),
                upper=_side(dataset, quantity, cubes.MODEL_SIDES[1], mine),
                thrown_out=_thrown_out(dataset, quantity, mine),
                distance=float(distances.max()) if distances.size else None,
                runs=count,
            )


def _side(dataset: xr.Dataset, quantity: str, side: tuple[Variable, Variable], mine: np.ndarray) -> Side | None:
    sizes, values = _by_run(dataset, side[0], quantity)[mine], by_run(dataset, quantity)[mine]
    if not np.isfinite(sizes[0]):
        return None
    failure = by_run(dataset, side[1].named(quantity))[mine][0]
    return Side(abs(float(sizes[0] / values[0])) if values[0] else None, str(failure))


def _thrown_out(dataset: xr.Dataset, quantity: str, mine: np.ndarray) -> tuple[str, ...]:
    if not cubes.MODEL_THROWN_OUT.is_in(dataset, quantity):
        return ()
    names = by_run(dataset, cubes.MODEL_THROWN_OUT.named(quantity))[mine][0]
    return tuple(name for name in str(names).split(cubes.BETWEEN_FAILURES) if name)


def _by_run(dataset: xr.Dataset, variable: Variable, quantity: str) -> np.ndarray:
    """A number of a quantity for each run, (runs,); NaN where no run has it."""
    if not variable.is_in(dataset, quantity):
        return np.full(dataset.run_state.size, np.nan)
    return by_run(dataset, variable.named(quantity))
