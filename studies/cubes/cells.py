"""The cells of a cube: each run of a sweep in its place, with what is known of it."""

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any

import numpy as np

from studies.convergence.experience import MeshError, combined, without_mesh_error
from studies.convergence.outcomes import agree
from studies.convergence.richardson import Convergence, ConvergenceVerdict, Sample, converge, levels_of
from studies.cubes.variable import variable_name
from studies.cubes.variables import STATES
from studies.quantities.measured import (
    BY_ONE_GRID,
    DEFINITION,
    ENOUGH_GRIDS,
    OF_MESH,
    SUB_CELL,
    Measured,
    numerical_parts,
)
from studies.runs.results import RunResult, with_mesh_errors
from studies.sweeps.reading import RESOLUTION

Results = Mapping[str, RunResult]  # what each run left, by its id
MISSING = RunResult("", "missing", "no result was recorded for this run")


UNFINISHED = frozenset({"pending", "running"})  # states


@dataclass(frozen=True)
class UnfinishedRun:
    """A run that has not ended, in a cube before the end of its sweep: nothing but its id is known of it."""

    id: str
    parameters: Mapping[str, Any] = field(default_factory=dict)


@dataclass(frozen=True)
class Cell:
    """One run in its place."""

    coordinates: Mapping[str, Any]  # of the axes, by the names a user writes
    run: Any  # studies.runs.run.Run, or an UnfinishedRun
    shot: Any | None  # studies.laws.Shot: what the laws are asked about
    result: RunResult  # without measurements, where the run left none
    state: str  # one of STATES
    reason: str  # why there is no result

    @property
    def is_resolved(self) -> bool:
        """Whether more than the id of the run is known."""
        return not isinstance(self.run, UnfinishedRun)

    @property
    def mesh_errors(self) -> Mapping[str, MeshError]:
        """What the mesh does to each measurement, where experience tells it."""
        return self.run.mesh_errors if self.is_resolved and self.state == "succeeded" else {}

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

    axes: tuple[Any, ...]  # studies.sweeps.sweep.Axis
    refinements: tuple[Any, ...]  # studies.sweeps.sweep.Axis
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
        return np.reshape([cell.is_resolved for cell in self.cells.flat], self.cells.shape)

    @property
    def runs_of_points(self) -> np.ndarray:
        """The cells as (points..., runs of a point); the first run stands for what no refinement changes."""
        return self.cells.reshape(*self.cells.shape[: len(self.point_dims)], -1)


def results_of(outcomes: Mapping[str, Mapping[str, Any]]) -> Results:
    """Results from their JSON by run id, that of a run which left none with its state and reason alone."""
    nothing: dict[str, Any] = {"measurements": {}, "flags": ()}
    return {id: RunResult.from_json({"run_id": id, **nothing, **plain}) for id, plain in outcomes.items()}


def lay_out(sweep: Any, results: Results, shot_of: Callable[[Any], Any | None], run_ids: Sequence[str] = ()) -> Layout:
    """The runs of a sweep in their places; expands its grid, once.

    Where the ids of the runs are known, in this order, those that have not ended are not resolved.
    """
    grid = sweep.combine == "grid"
    axes = (*(sweep.axes if grid else ()), *sweep.refinements)
    names = tuple(variable_name(axis.name) for axis in axes)
    cells = np.full(sweep.grid.shape, None, object)
    for index, coordinates, run in _placed_runs(sweep, results, run_ids):
        shot = None if isinstance(run, UnfinishedRun) else shot_of(run)
        cells[index] = _cell(coordinates, run, results, shot)
    layout = Layout(tuple(sweep.axes), tuple(sweep.refinements), names if grid else ("run", *names), cells)
    for place in np.ndindex(layout.runs_of_points.shape[:-1]):
        layout.runs_of_points[place] = _on_grids(layout.runs_of_points[place])
    return layout


def _placed_runs(
    sweep: Any, results: Results, run_ids: Sequence[str]
) -> list[tuple[tuple[int, ...], Mapping[str, Any], Any]]:
    """Index, coordinates and run of each point."""
    ids = run_ids[: sweep.size]
    has_ended = [results.get(id, MISSING).state not in UNFINISHED for id in ids]
    if len(ids) == sweep.size and any(has_ended) and not all(has_ended):
        points = [*sweep.computed_runs(has_ended)]
        placed = [
            (point.index, point.coordinates, point.run if ended else UnfinishedRun(id))
            for point, id, ended in zip(points, ids, has_ended, strict=True)
        ]
        if all(run.id == id for (_, _, run), id in zip(placed, ids, strict=True)):
            return placed
    return [(point.index, point.coordinates, point.run) for point in sweep.runs()]


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
    flagged = {name for name in seen if {*BY_ONE_GRID} & {*getattr(cell.measured(name), "flags", ())}}
    if not flagged:
        return cell
    measurements = dict(cell.result.measurements)
    for name in flagged:
        kept = tuple(flag for flag in measurements[name].flags if flag not in BY_ONE_GRID)
        measurements[name] = replace(measurements[name], flags=kept)
    return replace(cell, result=replace(cell.result, measurements=measurements))


def _cell(coordinates: Mapping[str, Any], run: Any, results: Results, shot: Any | None) -> Cell:
    result = results.get(run.id, MISSING)
    if result.measurements and not isinstance(run, UnfinishedRun):
        result = with_mesh_errors(run, result)
    state, reason = result.state, result.reason or ""
    if state not in STATES:
        state, reason = "other", f"{state}: {reason}"
    return Cell(coordinates, run, shot, result, state, reason)


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
        (sample, cell.mesh_errors[quantity], cell.reading(quantity))
        for cell, sample in zip(cells, samples, strict=True)
        if quantity in cell.mesh_errors and math.isfinite(sample.value)
    ]
    if not known:
        return None
    spacings = sorted({sample.spacing for sample, _, _ in known})
    grids = []
    for spacing in spacings:
        here = [(error, reading) for sample, error, reading in known if sample.spacing == spacing]
        # The position of a grid changes no cell: its runs have one mesh error.
        grids.append((math.fsum(reading.value for _, reading in here) / len(here), here[0][0]))
    point = combined(grids)
    rest = [sample.rest for sample, _, _ in known if sample.spacing == spacings[0]]
    verdict: ConvergenceVerdict = "grids disagree" if point.disagree else "mesh error known"
    reason = "the grids differ by more than 99 % of what the ensemble expects" if point.disagree else ""
    measurement = math.hypot(*rest) / math.sqrt(len(rest))
    return Convergence(verdict, reason, point.value, point.bar, 0.0, measurement, levels=levels_of(samples))


def definition_part(cells: np.ndarray, quantity: str) -> float | None:
    """Mean of the part of a definition over the finest runs, (runs,), of one point that state it; None without any."""
    by_spacing: dict[float, list[float]] = {}
    for cell in cells:
        measured = cell.measured(quantity)
        if cell.state == "succeeded" and measured is not None and DEFINITION in measured.parts:
            by_spacing.setdefault(_spacing(cell), []).append(measured.parts[DEFINITION])
    return float(np.mean(by_spacing[min(by_spacing)])) if by_spacing else None


def _spacing(cell: Cell) -> float:
    """Size of a cell of the grid in diameters; 1 where a sweep has one resolution alone."""
    return float(1.0 / cell.coordinates.get(RESOLUTION, 1.0))


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
