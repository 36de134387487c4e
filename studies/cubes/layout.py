"""The places of a cube: its dimensions, and each run in its cell."""

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from studies.cubes.variables import STATES, variable_name


@dataclass(frozen=True)
class MissingResult:
    """What became of a run that left no result."""

    state: str  # "cancelled", "crashed", "pending", ...
    reason: str


MISSING = MissingResult("missing", "no result, and no word of what became of it")


@dataclass(frozen=True)
class Cell:
    """One run in its place."""

    index: tuple[int, ...]
    coordinates: Mapping[str, Any]  # of the axes, by the names a user writes
    run: Any  # studies.runs.run.Run
    shot: Any | None  # studies.laws.Shot: what the laws are asked about
    result: Any | None  # studies.results.RunResult, when the run left one
    outcome: MissingResult  # state and reason in any case

    @property
    def state(self) -> str:
        return self.outcome.state if self.outcome.state in STATES else "other"

    @property
    def reason(self) -> str:
        """Why there is no result; a state that is not listed is kept here."""
        words = self.outcome.reason
        return words if self.outcome.state in STATES else f"{self.outcome.state}: {words}"

    @property
    def measurements(self) -> Mapping[str, Any]:
        return self.result.measurements if self.result is not None else {}

    @property
    def numbers(self) -> Mapping[str, float]:
        return self.result.numbers if self.result is not None else {}

    @property
    def provenance(self) -> Mapping[str, Any]:
        return self.result.provenance if self.result is not None else {}


@dataclass(frozen=True)
class Layout:
    """The dimensions of a cube, and its cells.

    The last dimensions are the refinements: resolution and offset, where a sweep names several.
    """

    axes: tuple[Any, ...]  # studies.sweeps.sweep.Axis
    refinements: tuple[Any, ...]  # studies.sweeps.sweep.Axis
    dims: tuple[str, ...]
    shape: tuple[int, ...]
    cells: tuple[Cell, ...]

    @property
    def grid(self) -> bool:
        """Whether the axes are the dimensions; otherwise they run along ``run``."""
        return self.dims[:1] != ("run",)

    @property
    def points(self) -> "Layout":
        """The points that a user asked for, each with its first run: for what no refinement changes."""
        kept = len(self.dims) - len(self.refinements)
        return replace(
            self,
            refinements=(),
            dims=self.dims[:kept],
            shape=self.shape[:kept],
            cells=tuple(
                replace(cell, index=cell.index[:kept])
                for cell in self.cells
                if not any(cell.index[kept:])
            ),
        )

    def refined(self) -> dict[tuple[int, ...], list[Cell]]:
        """The runs of each point, by its place among the points."""
        kept = len(self.dims) - len(self.refinements)
        found: dict[tuple[int, ...], list[Cell]] = {}
        for cell in self.cells:
            found.setdefault(cell.index[:kept], []).append(cell)
        return found

    def numbers(self, pick: Callable[[Cell], Any], *more: int) -> np.ndarray:
        """One number a cell, or an array of the shape ``more``; NaN where there is none."""
        values = np.full((*self.shape, *more), np.nan)
        for cell in self.cells:
            found = pick(cell)
            if found is not None:
                values[cell.index] = found
        return values

    def integers(self, pick: Callable[[Cell], Any], dtype: Any, *more: int) -> np.ndarray:
        """One whole number a cell, or an array of the shape ``more``."""
        values = np.zeros((*self.shape, *more), dtype)
        for cell in self.cells:
            values[cell.index] = pick(cell)
        return values

    def texts(self, pick: Callable[[Cell], Any], *more: int) -> np.ndarray:
        """One text a cell, or an array of the shape ``more``; empty where there is none."""
        values = np.full((*self.shape, *more), "", object)
        for cell in self.cells:
            values[cell.index] = pick(cell) or ""
        return values


def lay_out(sweep: Any, results: Mapping[str, Any], shot_of: Callable[[Any], Any | None]) -> Layout:
    """The places of a sweep's runs, with what is known of each."""
    axes, refinements = tuple(sweep.axes), tuple(sweep.refinements)
    points = list(sweep.runs())
    own = axes if sweep.combine == "grid" else ()
    names = [variable_name(axis.name) for axis in (*own, *refinements)]
    shape = [len(axis.values) for axis in (*own, *refinements)]
    if not own:
        names = ["run", *names]
        shape = [len(points) // math.prod(shape), *shape]
    return Layout(
        axes=axes,
        refinements=refinements,
        dims=tuple(names),
        shape=tuple(shape),
        cells=tuple(_cell(point, results, shot_of(point.run)) for point in points),
    )


def _cell(point: Any, results: Mapping[str, Any], shot: Any | None) -> Cell:
    found = results.get(point.run.id, MISSING)
    lost = isinstance(found, MissingResult)
    outcome = found if lost else MissingResult(found.state, found.reason or "")
    return Cell(
        tuple(point.index), point.coordinates, point.run, shot, None if lost else found, outcome
    )


def labels(values: Iterable[Any]) -> np.ndarray:
    """Texts as an array of objects; nothing is the empty text."""
    return np.array(["" if value is None else str(value) for value in values], object)


def floats(values: Iterable[float | None]) -> np.ndarray:
    """Numbers as an array of floats; nothing is NaN."""
    return np.array([math.nan if value is None else value for value in values], float)


def shared(values: Sequence[Any]) -> bool:
    """Whether all values are the same."""
    return all(value == values[0] for value in values)
