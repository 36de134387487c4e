"""The cells of a cube: each run of a sweep in its place, with what is known of it."""

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from studies.convergence.experience import MeshError, combined, without_mesh_error
from studies.convergence.outcomes import agree
from studies.convergence.richardson import Convergence, ConvergenceVerdict, Sample, converge, levels_of
from studies.cubes.variable import variable_name
from studies.cubes.variables import STATES
from studies.laws import Shot
from studies.quantities.measured import (
    BY_ONE_GRID,
    DEFINITION,
    ENOUGH_GRIDS,
    OF_MESH,
    SUB_CELL,
    Measured,
    numerical_parts,
)
from studies.quantities.parameters import Plain, Value
from studies.runs.results import RunResult, with_mesh_errors
from studies.runs.run import Run
from studies.sweeps.axes import Axis
from studies.sweeps.reading import RESOLUTION
from studies.sweeps.sweep import Sweep

Results = Mapping[str, RunResult]  # what each run left, by its id
MISSING = RunResult("", "missing", "no result was recorded for this run")


UNFINISHED = frozenset({"pending", "running"})  # states


@dataclass(frozen=True)
class Cell:
    """One run in its place."""

    coordinates: Mapping[str, Value]  # of the axes, by the names a user writes
    id: str  # of the run
    run: Run | None  # None of one that has not ended, in a cube before the end of its sweep
    shot: Shot | None  # what the laws are asked about
    result: RunResult  # without measurements, where the run left none
    state: str  # one of STATES
    reason: str  # why there is no result

    @property
    def parameters(self) -> Mapping[str, Value]:
        """The parameters of its run; empty where nothing but its id is known."""
        return self.run.parameters if self.run else {}

    @property
    def mesh_errors(self) -> Mapping[str, MeshError]:
        """What the mesh does to each measurement, where experience tells it."""
        return self.run.mesh_errors if self.run and self.state == "succeeded" else {}

    def reading(self, quantity: str) -> Measured | None:
        """The measurement of a quantity, as it was read off the grid of its run."""
        return self.result.measurements.get(quantity)

    def measured(self, quantity: str) -> Measured | None:
        """The measurement of a quantity, without its expected mesh error where that is known."""
        reading, error = self.reading(quantity), self.mesh_errors.get(quantity)
        if reading is None or error is None:
            return reading
        return without_mesh_error(reading, error)


@dataclass(frozen=True)
class Layout:
    """The dimensions of a cube, and its cells.

    The last dimensions are the refinements: resolution and offset, where a sweep names several.
    """

    axes: tuple[Axis, ...]
    refinements: tuple[Axis, ...]
    dims: tuple[str, ...]
    cells: np.ndarray  # of Cell, one dimension for each of dims

    @property
    def grid(self) -> bool:
        """Whether the axes are the dimensions; otherwise they run along ``run``."""
        return self.dims[:1] != ("run",)

    @property
    def point_dims(self) -> tuple[str, ...]:
        """The dimensions of the points that a user asked for, before they are refined."""
        return self.dims[: len(self.dims) - len(self.refinements)]

    @cached_property
    def is_resolved(self) -> np.ndarray:
        """Whether more than the id of each run is known: an array like the cells."""
        return np.reshape([cell.run is not None for cell in self.cells.flat], self.cells.shape)

    @property
    def runs_of_points(self) -> np.ndarray:
        """The cells as (points..., runs of a point); the first run stands for what no refinement changes."""
        return self.cells.reshape(*self.cells.shape[: len(self.point_dims)], -1)


def results_of(outcomes: Mapping[str, Mapping[str, Plain]]) -> Results:
    """Results from their JSON by run id, that of a run which left none with its state and reason alone."""
    nothing: dict[str, Plain] = {"measurements": {}, "flags": ()}
    return {id: RunResult.from_json({"run_id": id, **nothing, **plain}) for id, plain in outcomes.items()}


def lay_out(
    sweep: Sweep, results: Results, shot_of: Callable[[Run], Shot | None], run_ids: Sequence[str] = ()
) -> Layout:
    """The runs of a sweep in their places; expands its grid, once.

    Where the ids of the runs are known, in this order, those that have not ended are not resolved.
    """
    grid = sweep.combine == "grid"
    axes = (*(sweep.axes if grid else ()), *sweep.refinements)
    names = tuple(variable_name(axis.name) for axis in axes)
    cells = np.full(sweep.grid.shape, None, object)
    for index, coordinates, id, run in _placed_runs(sweep, results, run_ids):
        result = results.get(id, MISSING)
        if result.measurements and run:
            result = with_mesh_errors(run, result)
        state, reason = result.state, result.reason or ""
        if state not in STATES:
            state, reason = "other", f"{state}: {reason}"
        cells[index] = Cell(coordinates, id, run, shot_of(run) if run else None, result, state, reason)
    layout = Layout(sweep.axes, sweep.refinements, names if grid else ("run", *names), cells)
    for place in np.ndindex(layout.runs_of_points.shape[:-1]):
        layout.runs_of_points[place] = _on_grids(layout.runs_of_points[place])
    return layout


def _placed_runs(
    sweep: Sweep, results: Results, run_ids: Sequence[str]
) -> Sequence[tuple[tuple[int, ...], Mapping[str, Value], str, Run | None]]:
    """Index, coordinates, id and run of each point."""
    ids = run_ids[: sweep.size]
    has_ended = [results.get(id, MISSING).state not in UNFINISHED for id in ids]
    if len(ids) == sweep.size and any(has_ended) and not all(has_ended):
        placed = [(*place, id, run) for (place, run), id in zip(sweep.computed_runs(has_ended), ids, strict=True)]
        if all(run is None or run.id == id for _, _, id, run in placed):
            return placed
    return [(point.index, point.coordinates, point.run.id, point.run) for point in sweep.runs()]


def _on_grids(cells: np.ndarray) -> np.ndarray:
    """The runs of one point, (runs,), without flags of one grid alone on values that enough grids have."""
    grids: dict[str, set[float]] = {}
    for cell in cells:
        for name, measured in cell.result.measurements.items():
            if measured.value is not None:
                grids.setdefault(name, set()).add(_spacing(cell))
    seen = {name for name, spacings in grids.items() if len(spacings) >= ENOUGH_GRIDS}
    changed = np.empty_like(cells)
    changed[:] = [_without_flag(cell, seen) for cell in cells]
    return changed


def _without_flag(cell: Cell, seen: set[str]) -> Cell:
    """The run without flags of one grid alone on some of its values."""
    measurements = {
        name: replace(measured, flags=tuple(flag for flag in measured.flags if flag not in BY_ONE_GRID))
        if name in seen and {*BY_ONE_GRID} & {*getattr(cell.measured(name), "flags", ())}
        else measured
        for name, measured in cell.result.measurements.items()
    }
    return replace(cell, result=replace(cell.result, measurements=measurements))


def converge_points(layout: Layout, quantity: str, outcomes: Sequence[str] = ()) -> np.ndarray:
    """Convergence of a quantity at each point; of an outcome ``outcomes`` say what 0 and 1 mean."""
    points = layout.runs_of_points
    converged = np.empty(points.shape[:-1], object)
    for place in np.ndindex(converged.shape):
        samples = [_sample(cell, cell.measured(quantity)) for cell in points[place]]
        known = _by_experience(points[place], quantity, samples)
        converged[place] = agree(samples, outcomes) if outcomes else known or converge(samples)
    return converged


def _by_experience(cells: np.ndarray, quantity: str, samples: Sequence[Sample]) -> Convergence | None:
    """A quantity of one point from those of its grids whose mesh errors are known; None without any."""
    known = [
        (sample, cell.mesh_errors[quantity], cell.result.measurements[quantity].value)
        for cell, sample in zip(cells, samples, strict=True)
        if quantity in cell.mesh_errors and math.isfinite(sample.value)
    ]
    if not known:
        return None
    spacings = sorted({sample.spacing for sample, _, _ in known})
    grids = []
    for spacing in spacings:
        here = [(error, value) for sample, error, value in known if sample.spacing == spacing]
        # The position of a grid changes no cell: its runs have one mesh error.
        grids.append(([value for _, value in here], here[0][0]))
    point = combined(grids)
    rest = [sample.rest for sample, _, _ in known if sample.spacing == spacings[0]]
    verdict: ConvergenceVerdict = "grids disagree" if point.disagree else "mesh error known"
    reason = "grids or offsets differ by more than 99 % of what the ensemble expects" if point.disagree else ""
    measurement = math.hypot(*rest) / math.sqrt(len(rest))
    return Convergence(verdict, reason, point.value, point.bar, 0.0, measurement, levels=levels_of(samples))


def definition_parts(layout: Layout, quantity: str) -> np.ndarray:
    """Mean of the part of a definition over the finest runs of each point that state it; None without any."""
    points = layout.runs_of_points
    parts = np.full(points.shape[:-1], None, object)
    for place in np.ndindex(parts.shape):
        by_spacing: dict[float, list[float]] = {}
        for cell in points[place]:
            measured = cell.measured(quantity)
            if cell.state == "succeeded" and measured is not None and DEFINITION in measured.parts:
                by_spacing.setdefault(_spacing(cell), []).append(measured.parts[DEFINITION])
        parts[place] = float(np.mean(by_spacing[min(by_spacing)])) if by_spacing else None
    return parts


def _spacing(cell: Cell) -> float:
    """Size of a cell of the grid in diameters; 1 where a sweep has one resolution alone."""
    return 1.0 / float(cell.coordinates.get(RESOLUTION) or 1.0)


def _sample(cell: Cell, measured: Measured | None) -> Sample:
    """A run as convergence sees it; one that did not succeed has no value."""
    spacing = _spacing(cell)
    if measured is None or cell.state != "succeeded":
        return Sample(spacing, np.nan)
    if measured.value is None:
        return Sample(spacing, np.nan, nothing=True)
    parts = numerical_parts(measured.parts)
    rest = math.hypot(*(size for part, size in parts.items() if part not in OF_MESH))
    flags = (*cell.result.flags, *measured.flags)
    return Sample(spacing, measured.value, measured.parts.get(SUB_CELL, 0.0), rest, quality_flags=flags)
