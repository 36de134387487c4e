"""The cube: what a sweep computed, labelled, in one xarray Dataset and one NetCDF-4 file.

Dimensions are the axes of the sweep (grid), or one dimension ``run`` with the axes as coordinates along it (zip), and
resolutions and offsets, where a sweep names several; what converges over these lies over the axes alone. Every run
keeps its cell: one that has no result is NaN, with ``run_state`` and ``run_reason`` saying why.

The file is a tree (``groups``). Before and behind it the variables stand in one dataset, each with the name of its
group as an attribute. The laws are evaluated here, so that the file alone redoes the report.
"""

import json
import math
import re
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import asdict, replace
from datetime import UTC, datetime
from functools import partial
from math import prod
from pathlib import Path
from typing import TypeVar

import numpy as np
import xarray as xr

from studies.cubes import audit, limits
from studies.cubes import variables as declared
from studies.cubes.catalogue import Catalogue, Observed, answers, catalogue_of
from studies.cubes.cells import MISSING, Cell, Layout, Results, converge_points, definition_parts, lay_out
from studies.cubes.groups import as_tree
from studies.cubes.models import Assess, assessment
from studies.cubes.variable import (
    BETWEEN_OUTCOMES,
    GROUPS,
    OUTCOMES,
    POINTS,
    ROOT,
    RUNS,
    SYMBOLS,
    Column,
    Group,
    Quantity,
    Variable,
    variable_name,
)
from studies.laws import Code, Reason
from studies.measurements import distributions
from studies.quantities.files import write_atomically
from studies.quantities.measured import numerical_parts
from studies.quantities.parameters import Parameter, Plain
from studies.sweeps.axes import Axis
from studies.sweeps.screening import CONTRIBUTIONS
from studies.sweeps.sweep import Sweep

CHUNK_VALUES = 1_000_000  # 8 MB: a whole variable of most cubes, so that one read gets it
FEW_VALUES = 512  # fewer take more space in a chunk, with its index, than as they are
HISTORY_SAMPLES = 256  # of a run: a curve on paper shows no more
HISTORY_VALUES = 1_000_000  # of a quantity over all runs: 8 MB before compression
# Provenance that is no version of anything.
ONCE_A_RUN = ("started", "seconds", "threads", "checkpoint")

Version = TypeVar("Version", int, str)
Encoding = dict[str, float | str | tuple[int, ...] | None]


def build(
    sweep: Sweep, results: Results, catalogue: Catalogue | None = None, run_ids: Sequence[str] = ()
) -> xr.Dataset:
    """The cube of a sweep; ``results`` has what each run left, by its id.

    With the ids of all runs, in the order of ``Sweep.runs``, only those that have ended are read. That of a search has
    the values that it tried, with the limits; its attribute ``search`` is the document.
    """
    catalogue, search = catalogue or catalogue_of(sweep), sweep.search
    if search is None:
        return _built(sweep, results, catalogue, [], run_ids)
    searched = sweep.limits(lambda run: limits.outcome_of(results.get(run.id, MISSING), search.quantity))
    about = {"limit_of": search.quantity, "axis": variable_name(search.axis)}
    columns = limits.columns_of(searched, catalogue.parameters[search.axis], catalogue.parameters, about)
    dataset = _built(sweep.tried(searched), results, catalogue, columns)
    return dataset.assign_attrs(search=json.dumps(sweep.document(), ensure_ascii=False, sort_keys=True))


def _built(
    sweep: Sweep, results: Results, catalogue: Catalogue, first: Sequence[Column], run_ids: Sequence[str] = ()
) -> xr.Dataset:
    """The cube with these columns before all others."""
    layout = lay_out(sweep, results, catalogue.shot_of, run_ids)
    dataset = xr.Dataset(
        {
            variable.name: _labelled(variable, values, layout, attributes)
            for variable, values, attributes in (
                *first,
                *_in_order(layout, catalogue, sweep, assessment(sweep, results)),
            )
        }
    )
    axes = {*_names(layout.axes), *_names(layout.refinements)}
    dataset = dataset.set_coords([name for name in dataset if _is_coordinate(dataset[name], axes)])
    dataset.attrs = _about(sweep, layout, catalogue)
    # Numeric axes ascend, as CF asks of a coordinate; a sweep may list them in any order.
    numeric = [dim for dim in dataset.dims if dim in axes and dataset[dim].dtype.kind == "f"]
    return dataset.sortby(numeric) if numeric else dataset


def with_computation(dataset: xr.Dataset, results: Results) -> xr.Dataset:
    """The cube with the date, and the wall time and threads of each run: they are in no file, which has the same bytes
    whoever computes the sweep."""
    ids = dataset[declared.RUN_ID.name].variable
    made_by = _each(ids.values.astype(object), lambda id: results.get(id, MISSING).provenance)
    times = {
        variable.name: xr.Variable(ids.dims, variable.values(made_by), {**variable.attributes, "group": variable.group})
        for variable in (declared.SOLVER_SECONDS, declared.SOLVER_THREADS)
    }
    now = datetime.now(UTC).isoformat(timespec="seconds")
    return dataset.assign(times).assign_attrs(date_created=now)


def write(dataset: xr.Dataset, path: Path) -> Path:
    """Write a cube as NetCDF-4; the file is there whole or not at all.

    A half-written NetCDF-4 file opens and reads as NaN, so nothing is written in place.
    """
    tree = as_tree(dataset)
    encoding = {
        group.path: {
            str(name): _encoding(str(name), array) for name, array in group.to_dataset(inherit=False).variables.items()
        }
        for group in tree.subtree
    }
    return write_atomically(
        path, lambda file: tree.to_netcdf(file, engine="netcdf4", format="NETCDF4", encoding=encoding)
    )


# ---- columns: declared variables with their values -----------------------------------------------


def _in_order(layout: Layout, catalogue: Catalogue, sweep: Sweep, assess: Assess) -> list[Column]:
    """The columns as a reader wants them: group by group, axes first, and quantities of laws."""
    first = [*_names(layout.axes), *_names(layout.refinements), *map(variable_name, sweep.fixed)]
    main = {law.quantity for law in catalogue.laws}
    others = tuple(name for name in catalogue.quantities if name not in main)

    def place(column: Column) -> tuple[int, bool, int]:
        variable = column[0]
        place = first.index(variable.name) if variable.name in first else len(first)
        is_other = any(re.match(rf"{name}(_|$)", variable.name) for name in others)
        return GROUPS.index(variable.group), is_other, place

    return sorted(_columns(layout, catalogue, assess), key=place)


def _columns(layout: Layout, catalogue: Catalogue, assess: Assess) -> Iterator[Column]:
    for parameter in catalogue.parameters.values():
        yield from _of_parameter(layout, parameter)
    shots = _each(layout.runs_of_points[..., 0], lambda cell: cell.shot)
    if samples := _samples(layout):
        times = _each(layout.cells, _times)
        yield declared.HISTORY_TIME, _padded(times, samples), {}
        yield from _of_histories(layout, samples)
    yield from _of_distributions(layout)
    for quantity in catalogue.quantities.values():
        yield from _of_quantity(layout, quantity)
        yield from _of_models(layout, quantity, assess)
        yield from _of_laws(quantity, catalogue, shots)
    for quantity in catalogue.critical:
        yield from _of_laws(quantity, catalogue, shots)
    yield from _of_runs(layout)
    if catalogue.observations:
        yield from _of_observations(catalogue)


def _of_parameter(layout: Layout, parameter: Parameter) -> Iterator[Column]:
    """The coordinate of an axis, or another parameter: a scalar where all runs share it."""
    name = parameter.name
    axes = {axis.name: axis for axis in (*layout.axes, *layout.refinements)}
    axis = axes.get(name)
    if axis is None:
        variable = declared.parameter_variable(parameter, RUNS)
        records = _each(layout.cells, lambda cell: cell.parameters.get(name))
        if any(record is not None for record in records.flat):
            yield variable, _compact(variable.values(records), layout), {}
    elif layout.grid or axis in layout.refinements:
        group: Group = ROOT if axis in layout.axes else "refinement"
        variable = replace(declared.parameter_variable(parameter, (variable_name(name),)), group=group)
        yield variable, variable.values(_records(axis.values)), {}
    else:
        variable = replace(declared.parameter_variable(parameter, POINTS), group=ROOT)
        points = layout.runs_of_points[..., 0]
        yield variable, variable.values(_each(points, lambda cell: cell.coordinates[name])), {}


def _of_runs(layout: Layout) -> Iterator[Column]:
    """Identity, state, reason, flags, cost and audit of each run."""
    if not layout.grid:
        yield _column(declared.RUN_NUMBER, _records(range(layout.cells.shape[0])))
    for variable in declared.OF_RUN:
        yield _column(variable, layout.cells)
    diameters = declared.EQUIVALENT_DIAMETER.values(layout.cells)
    if np.isfinite(diameters).any():
        yield declared.EQUIVALENT_DIAMETER, _compact(diameters, layout), {}
    for number in audit.audit_numbers():
        if any(number.name in cell.result.numbers for cell in layout.cells.flat):
            yield _column(number.variable, layout.cells)


def _of_histories(layout: Layout, samples: int) -> Iterator[Column]:
    """Energy and momentum of each body over time, by its name, and what the run exchanged.

    Runs of one sweep may differ in their bodies: NaN marks a body that a run does not have.
    """
    of_runs = [cell.result.histories.get("bodies", ()) for cell in layout.cells.flat]
    bodies = list(dict.fromkeys(name for names in of_runs for name in names))
    if not bodies:
        return
    yield _column(audit.BODY_NAME, _records(bodies))
    for history in audit.HISTORIES:
        picked = _each(layout.cells, lambda cell, name=history.name: cell.result.histories.get(name))
        if history.by_body:
            by_body = np.full((picked.size, len(bodies)), None, object)
            for run, (names, values) in enumerate(zip(of_runs, picked.flat, strict=True)):
                for name, of_body in zip(names, values or (), strict=False):
                    by_body[run, bodies.index(name)] = of_body
            picked = by_body.reshape(*picked.shape, -1)
        yield history.variable, _padded(picked, samples), {}


def _of_distributions(layout: Layout) -> Iterator[Column]:
    """Arrays over bins, of the runs that have them."""
    for name in {name: None for cell in layout.cells.flat for name in cell.result.distributions}:
        distribution = distributions.load(name)
        for bins in distribution.bins:
            yield _column(declared.bins_variable(bins), _records(bins.middles))
        shape = [bins.count for bins in distribution.bins]
        values = np.full((*layout.cells.shape, *shape), np.nan)
        for place, cell in np.ndenumerate(layout.cells):
            if name in cell.result.distributions:
                values[place] = cell.result.distributions[name]["values"]
        yield declared.distribution_variable(distribution), values, {}


def _of_quantity(layout: Layout, quantity: Quantity) -> Iterator[Column]:
    """Value, uncertainty and its parts, flags and history of a quantity, and what refinement makes of it."""
    name = quantity.name
    measured = _each(layout.cells, lambda cell: cell.measured(name))
    parts = [declared.uncertainty_part(part) for part in _parts(layout, name)]
    companions = (declared.ERROR_BAR, declared.UNCERTAINTY, declared.FLAGS, declared.RUN_STATE)
    about = {"ancillary_variables": " ".join(variable.named(name) for variable in companions)}
    if quantity.outcomes:
        about[OUTCOMES] = BETWEEN_OUTCOMES.join(quantity.outcomes)
    yield declared.VALUE.filled(quantity), declared.VALUE.values(measured), about
    converged = converge_points(layout, name, quantity.outcomes) if layout.refinements else None
    if quantity.first:
        yield declared.ERROR_BAR.filled(quantity), _error_bars(measured, converged), {}
    for variable in (declared.UNCERTAINTY, declared.FLAGS, *parts):
        yield _column(variable.filled(quantity), measured)
    if any(name in cell.mesh_errors for cell in layout.cells.flat):
        yield _column(declared.RAW.filled(quantity), _each(layout.cells, lambda cell: cell.reading(name)))
    histories = _each(layout.cells, lambda cell: _history(cell, name))
    if any(history is not None for history in histories.flat):
        yield declared.HISTORY.filled(quantity), _padded(histories, _samples(layout)), {}
    definition = definition_parts(layout, name)
    if any(part is not None for part in definition.flat):
        yield _column(declared.DEFINITION_PART.filled(quantity), definition)
    if converged is not None:
        for variable in declared.OF_CONVERGENCE:
            yield _column(variable.filled(quantity), converged)
    diameters = declared.EQUIVALENT_DIAMETER.values(layout.cells)
    if name in SYMBOLS and np.isfinite(diameters).any():
        yield declared.OVER_DIAMETER.filled(quantity), declared.VALUE.values(measured) / diameters, {}


def _error_bars(measured: np.ndarray, converged: np.ndarray | None) -> np.ndarray:
    """The error bars of points, of what refinement says where there is any."""
    if converged is None:
        return declared.ERROR_BAR.values(measured)
    known = np.isfinite(declared.MESH_PART.values(converged))
    return np.where(known, declared.CONVERGED_UNCERTAINTY.values(converged), np.nan)


def _of_models(layout: Layout, quantity: Quantity, assess: Assess) -> Iterator[Column]:
    """The model part of a quantity, with the contributions that are assessed, or the reason why there is none."""
    parts = _each(layout.cells, lambda cell: assess(cell, quantity.name))
    assessed = [
        declared.model_contribution(name) for name in CONTRIBUTIONS if any(name in part.shares for part in parts.flat)
    ]
    if any(part.upper is not None for part in parts.flat):
        assessed += [variable for side in declared.MODEL_SIDES for variable in side]
    if any(part.thrown_out for part in parts.flat):
        assessed.append(declared.MODEL_THROWN_OUT)
    if any(part.distance is not None for part in parts.flat):
        assessed.append(declared.MODEL_DISTANCE)
    if any(part.alloy for part in parts.flat):
        assessed.append(declared.MODEL_ALLOY)
    for variable in (declared.MODEL_PART, declared.MODEL_REASON, *assessed):
        yield _column(variable.filled(quantity), parts)


def _of_laws(quantity: Quantity, catalogue: Catalogue, shots: np.ndarray) -> Iterator[Column]:
    """Answers of each law, with each of its variants, at each point; and the laws' own texts."""
    choices = catalogue.choices(quantity.name, shots.flat)
    if choices:
        yield _column(declared.LAW_LABEL.filled(quantity), _records(choices))
        asked = answers(choices, shots)
        for variable in declared.OF_ANSWERS:
            yield _column(variable.filled(quantity), asked)
        for variable in declared.OF_LAWS:
            yield _column(variable.filled(quantity), _records(choices))


def _of_observations(catalogue: Catalogue) -> Iterator[Column]:
    """The shots that the sweep brought, and the answers of the laws for each."""
    shots = _records(catalogue.observations)
    yield _column(declared.OBSERVATION_NUMBER, _records(range(len(shots))))
    yield _column(declared.OBSERVATION_SOURCE, shots)
    if any(shot.confidence for shot in catalogue.observations):
        yield _column(declared.OBSERVATION_CONFIDENCE, shots)
    yield _column(declared.OBSERVATION_DIAMETER, shots)
    for parameter in catalogue.parameters.values():
        stated = _each(shots, lambda shot, name=parameter.name: shot.parameters.get(name))
        if any(value is not None for value in stated):
            yield _column(declared.observed_parameter(parameter), stated)
    for quantity in catalogue.quantities.values():
        mine = _each(shots, lambda shot, name=quantity.name: shot if shot.quantity == name else None)
        if any(shot is not None for shot in mine):
            yield from _observed(quantity, mine, shots, catalogue)


def _observed(quantity: Quantity, mine: np.ndarray, shots: np.ndarray, catalogue: Catalogue) -> Iterator[Column]:
    """The shots of one quantity; the constants of laws are those of the shots' own materials."""
    yield _column(declared.OBSERVED.filled(quantity), mine)
    yield _column(declared.OBSERVED_UNCERTAINTY.filled(quantity), mine)
    if any(shot is not None and shot.bounds for shot in mine):
        for variable in declared.OBSERVED_BOUNDS:
            yield _column(variable.filled(quantity), mine)
    choices = catalogue.choices(quantity.name, [shot.shot for shot in mine if shot is not None])
    if choices:
        for variable in declared.OF_OBSERVED_LAWS:
            yield _column(variable.filled(quantity), _records(choices))
        asked = answers(choices, _each(shots, lambda shot: shot.shot))
        for (number, place), answer in np.ndenumerate(asked):
            observed: Observed | None = mine.item(number)
            if observed is None or observed.shot is None or observed.value is None:
                continue
            if choices[place].law.is_fitted_to(observed.shot, observed.value):
                asked[number, place] = replace(answer, reasons=(Reason(Code.FITTED),))
        for variable in declared.OF_ANSWERS_AT_OBSERVATIONS:
            yield _column(variable.filled(quantity), asked)


# ---- values --------------------------------------------------------------------------------------


def _column(variable: Variable, records: np.ndarray) -> Column:
    """A variable with one value a record."""
    if variable.kind != "mask":
        return variable, variable.values(records), {}
    flags = _each(records, lambda record: set(variable.pick(record) or ()))
    raised = {flag for words in flags.flat for flag in words or ()}
    meanings = (*variable.meanings, *sorted(raised - set(variable.meanings)))
    bits = {meaning: 1 << place for place, meaning in enumerate(meanings)}
    values: np.ndarray = np.zeros(records.shape, np.int32)
    for place, words in np.ndenumerate(flags):
        values[place] = sum(bits[flag] for flag in words or ())
    attributes: dict[str, str | np.ndarray] = {
        "flag_masks": np.array(list(bits.values()), np.int32),
        "flag_meanings": " ".join(meanings),
    }
    return variable, values, attributes


def _records(items: Iterable[object]) -> np.ndarray:
    """Records along one dimension."""
    listed = list(items)
    records = np.empty(len(listed), object)
    records[:] = listed
    return records


def _each(records: np.ndarray, pick: Callable[..., object]) -> np.ndarray:
    """The picks of all records; None stays None."""
    picked: np.ndarray = np.frompyfunc(lambda record: None if record is None else pick(record), 1, 1)(records)
    return picked


def _compact(values: np.ndarray, layout: Layout) -> np.ndarray:
    """Values by run: a scalar where all that are known are equal, by point where those of each point are."""
    known = values[layout.is_resolved]
    if (known == known[0]).all():
        return np.array(known[0], values.dtype)
    by_point = values.reshape(layout.runs_of_points.shape)
    return by_point[..., 0] if (by_point == by_point[..., :1]).all() else values


def _parts(layout: Layout, quantity: str) -> list[str]:
    """Names of the numerical parts that the runs state of the uncertainty of a quantity."""
    measured = (cell.measured(quantity) for cell in layout.cells.flat)
    return sorted({part for one in measured if one is not None for part in numerical_parts(one.parts)})


def _samples(layout: Layout) -> int:
    """Samples of every history: as many as the longest has, within the limits of a cube."""
    longest = max((len(_times(cell)) for cell in layout.cells.flat), default=0)
    allowed = max(8, HISTORY_VALUES // max(1, layout.cells.size))
    return min(longest, HISTORY_SAMPLES, allowed)


def _times(cell: Cell) -> Sequence[float | None]:
    """The times of a run's histories (s): those of the longest one."""
    histories = (measured.history.get("time", ()) for measured in cell.result.measurements.values())
    return max((cell.result.histories.get("time", ()), *histories), key=len)


def _history(cell: Cell, quantity: str) -> list[float] | None:
    """The values of a quantity at the times of the run, NaN where its own history has none; None without a history."""
    measured = cell.measured(quantity)
    if measured is None or not measured.history.get("time"):
        return None
    values = dict(zip(measured.history["time"], measured.history["value"], strict=True))
    return [math.nan if (value := values.get(time)) is None else value for time in _times(cell)]


def _padded(histories: np.ndarray, samples: int) -> np.ndarray:
    """Histories, each thinned evenly to at most ``samples``, both ends among them, and padded with NaN."""
    padded = np.full((*histories.shape, samples), np.nan)
    for place, history in np.ndenumerate(histories):
        values = np.array(() if history is None else history, float)
        if len(values) > samples:
            values = values[np.linspace(0, len(values) - 1, samples).round().astype(int)]
        padded[place][: len(values)] = values
    return padded


# ---- labels --------------------------------------------------------------------------------------


def _labelled(
    variable: Variable, values: np.ndarray, layout: Layout, more: Mapping[str, str | np.ndarray]
) -> xr.Variable:
    """Values with the dimensions and attributes of their variable, as CF wants to see them."""
    stands_for = {RUNS[0]: layout.dims, POINTS[0]: layout.point_dims}
    dims = [name for dim in variable.dims for name in stands_for.get(dim, (dim,))]
    return xr.Variable(dims[: values.ndim], values, {**variable.attributes, "group": variable.group, **more})


def _is_coordinate(array: xr.DataArray, axes: set[str]) -> bool:
    """Axes and parameters are coordinates; so is what labels a dimension or a limit, and a time."""
    is_parameter = array.attrs["group"] == "inputs" or not array.dims
    is_time = array.name == declared.HISTORY_TIME.name
    return str(array.name).removeprefix(limits.PREFIX) in axes or array.dims == (array.name,) or is_parameter or is_time


def _about(sweep: Sweep, layout: Layout, catalogue: Catalogue) -> dict[str, str | int]:
    """The origin of the cube: CF's attributes for people, and JSON for programs."""
    cells = list(layout.cells.flat)
    stated = ((name, str(value)) for cell in cells for name, value in cell.result.provenance.items())
    versions = _collected((name, version) for name, version in stated if name not in ONCE_A_RUN)
    definitions = _collected((name, one.version) for cell in cells for name, one in cell.result.measurements.items())
    spoken = ", ".join(f"{name} {'/'.join(values)}" for name, values in versions.items())
    numbers = {name for cell in cells for name in cell.result.numbers}
    predicted = [*catalogue.quantities, *(diameter.name for diameter in catalogue.critical)]
    laws = [law for law in catalogue.laws if law.quantity in predicted]
    json_text = partial(json.dumps, ensure_ascii=False, sort_keys=True)
    return {
        "Conventions": "CF-1.11",
        "title": sweep.title,
        "institution": "not stated",
        "source": f"{catalogue.title}; material point method, whipple {spoken}".strip(),
        "history": f"cube assembled from {len(cells)} runs",
        "references": "; ".join(dict.fromkeys(law.source for law in laws)) or "none",
        "comment": "Each cell is a run. NaN marks a value that a run does not have: run_state and run_reason give "
        "the reason where the run has no result, the flags of the quantity where it has one.",
        "schema_version": declared.SCHEMA_VERSION,
        "scenario": sweep.scenario,
        "scenario_title": catalogue.title,
        "axes": " ".join(_names(layout.axes)),
        "refinements": " ".join(_names(layout.refinements)),
        "quantities": " ".join(catalogue.quantities),
        "undeclared_numbers": " ".join(sorted(numbers - {number.name for number in audit.audit_numbers()})),
        "sweep": json_text(sweep.document()),
        "materials": json_text(catalogue.materials),
        "compared_shots": json_text([asdict(shots) for shots in catalogue.compared_shots]),
        "software": json_text(versions),
        "measurement_versions": json_text(definitions),
        "vocabulary": json_text(_vocabulary(layout, catalogue)),
    }


def _vocabulary(layout: Layout, catalogue: Catalogue) -> dict[str, Plain]:
    """The words of the sweep from which the names of the cube are made."""
    parts = {name: _parts(layout, name) for name in catalogue.quantities}
    return {
        "axes": layout.dims,
        "refinements": _names(layout.refinements),
        "quantities": {q.name: [q.unit, q.meaning] for q in catalogue.quantities.values()},
        "parameters": {p.name: [p.kind, p.unit, p.meaning] for p in catalogue.parameters.values()},
        "parts": {name: stated for name, stated in parts.items() if stated},
    }


def _names(axes: Sequence[Axis]) -> list[str]:
    return [variable_name(axis.name) for axis in axes]


def _collected(pairs: Iterable[tuple[str, Version]]) -> dict[str, list[Version]]:
    """The values of each name, each once; names and values sorted."""
    values: dict[str, set[Version]] = {}
    for name, value in pairs:
        values.setdefault(name, set()).add(value)
    return {name: sorted(values[name]) for name in sorted(values)}


# ---- files ---------------------------------------------------------------------------------------


def _encoding(name: str, array: xr.Variable) -> Encoding:
    """float64 as it is, many values deflated lightly; coordinates and flags have no fill value (CF).

    Many texts are arrays of letters, which are deflated too: as strings they were two fifths of a file.
    """
    packed: Encoding = {"zlib": True, "complevel": 1} if array.size >= FEW_VALUES else {}
    if array.dtype.kind in "OUT":
        return {"dtype": "S1", **packed} if packed else {}
    # An auxiliary coordinate may have gaps, as the times after the end of a run; that of a dimension has none.
    number = array.dtype.kind == "f" and array.dims != (name,)
    fill: Encoding = {"_FillValue": np.nan if number else None}
    if not packed:
        return fill
    # The whole variable, or as many rows of its first dimension as make a chunk.
    row = max(1, prod(array.shape[1:]))
    rows = min(array.shape[0], max(1, CHUNK_VALUES // row))
    return {**fill, **packed, "shuffle": True, "chunksizes": (rows, *array.shape[1:])}
