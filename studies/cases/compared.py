"""Rows and pictures of a case: values of a cube on one grid and converged, beside published numbers."""

import math
from collections.abc import Hashable, Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
import xarray as xr

from studies.cubes import variables as cubes
from studies.cubes.points import Place, simulated, verdicts_of
from studies.observations import Observation
from studies.quantities.comparison import Comparison, absolute, relative
from studies.quantities.display import NONE, digits, display_of, with_bar, with_unit
from studies.sweeps.reading import RESOLUTION

EXACT = 1e-9  # relative: the place in a cube of a number that was written in a document


@dataclass(frozen=True)
class PublishedNumber:
    """A published number of a case."""

    by: str  # "experiment", or the code that computed it
    shot: Observation

    @property
    def value(self) -> float:
        """The number, SI."""
        assert self.shot.value is not None
        return self.shot.value

    def at(self, axis: str) -> float:
        """Its place along an axis, SI."""
        return float(self.shot.parameters[axis] or 0.0)


@dataclass(frozen=True)
class Line:
    """The points of a picture that belong together."""

    label: str
    points: tuple[tuple[float, float, float], ...]  # x, y and the error bar of y; 0: none
    joined: bool = False  # drawn as a line, and not as marks


@dataclass(frozen=True)
class Picture:
    """A figure of a case; numbers in the units of its labels."""

    name: str  # of the file
    title: str
    x: str
    y: str
    lines: tuple[Line, ...]
    ends: tuple[float, float] | None = None  # of y, which cut the bars: a share lies between 0 and 1


@dataclass(frozen=True)
class ComparedReading:
    """A measured quantity of a cube at one point."""

    cube: xr.Dataset
    name: str
    at: Place  # values of the axes, SI

    @property
    def factor(self) -> float:
        """Display units over SI."""
        return display_of(self._unit).factor

    @property
    def label(self) -> str:
        """Its words with the display unit: "crater depth (mm)"."""
        return with_unit(self.name.replace("_", " "), self._unit)

    @property
    def _unit(self) -> str:
        return str(self.cube[self.name].attrs["units"])

    def on(self, cells: float | None = None) -> float:
        """The value on a grid (cells per diameter), in display units; NaN where the run has none."""
        at = self.at if cells is None else {**self.at, RESOLUTION: cells}
        return float(_pick(simulated(self.cube, self.name), at)) * self.factor

    @property
    def grids(self) -> list[float]:
        """The resolutions of its runs, coarse to fine; none where the sweep has a single one."""
        return [float(cells) for cells in self.cube[RESOLUTION]] if self.is_refined else []

    @property
    def is_refined(self) -> bool:
        """Whether the sweep has several grids."""
        return RESOLUTION in self.cube.dims

    @cached_property
    def converged(self) -> tuple[float, float | None, str]:
        """The converged value, its error bar (display units) and the verdict on the convergence, as a text."""
        value, bar, mesh = (
            float(_pick(variable.of(self.cube, self.name), self.at)) * self.factor
            for variable in (cubes.CONVERGED, cubes.CONVERGED_UNCERTAINTY, cubes.MESH_PART)
        )
        verdict = str(_pick(verdicts_of(self.cube, self.name), self.at).item())
        return value, None if math.isnan(bar) or not math.isfinite(mesh) else bar, verdict

    @property
    def convergence(self) -> str:
        """The verdict and the value of each grid in words."""
        grids = ", ".join(f"{self.on(grid):.4g}" for grid in self.grids)
        return f"converged ({self.converged[2]}; grids {grids})"

    @property
    def best(self) -> tuple[float, float | None]:
        """The converged value with its bar, or the only one, which has none."""
        return self.converged[:2] if self.is_refined else (self.on(), None)

    @property
    def point(self) -> tuple[float, float]:
        """The best value of a picture with its bar; 0: none."""
        value, bar = self.best
        return value, bar or 0.0

    @property
    def text(self) -> str:
        """The best value with its error bar; a dash without a value."""
        value, bar = self.best
        return NONE if math.isnan(value) else with_bar(digits(value, 4), None if bar is None else digits(bar, 2))


def _pick(array: xr.DataArray, at: Place) -> xr.DataArray:
    """The value at a place, of crossed or zipped axes; raises KeyError where the sweep has no such point."""
    places: dict[Hashable, np.ndarray] = {}
    for axis, value in at.items():
        if axis not in array.coords or array[axis].ndim == 0:
            continue
        (along,) = array[axis].dims
        column = array[axis].values
        matches = (
            column == value if isinstance(value, str) else np.isclose(column.astype(float), value, rtol=EXACT, atol=0.0)
        )
        places[along] = places.get(along, True) & matches
    for along, matches in places.items():
        if matches.sum() != 1:
            raise KeyError(f"{array.name} has no point at {dict(at)}")
        array = array.isel({along: int(matches.argmax())})
    return array.squeeze()


def compared(
    where: str,
    quantity: ComparedReading,
    numbers: Iterable[PublishedNumber],
    reference: str,
    *,
    mesh: tuple[float, str] | None = None,
    within: float | None = None,
    share: float | None = None,
) -> Iterator[Comparison]:
    """Rows of a quantity against the number by ``reference``: on the mesh of the source, and converged as a report.

    ``mesh`` is that mesh, cells per diameter and its name; ``within`` is a tolerance in display units, or ``share`` a
    relative one, on that mesh alone.
    """
    beside = {each.by: quantity.factor * each.value for each in numbers if each.shot.quantity == quantity.name}
    expected = beside.pop(reference)
    cells, mesh_name = mesh or (None, "one grid")
    value = quantity.on(cells if quantity.is_refined else None)
    claim = f"{where}, {mesh_name}: {quantity.label}"
    row = absolute if share is None else relative
    made = row(claim, expected=expected, got=value, within=within if share is None else share)
    yield replace(made, others=beside)
    if quantity.is_refined:
        value, bar, _ = quantity.converged
        claim = f"{where}, {quantity.convergence}: {quantity.label}"
        yield replace(absolute(claim, expected=expected, got=value), bar=bar, others=beside)


def grids_of(cube: xr.Dataset) -> Iterator[tuple[float, xr.Dataset]]:
    """The runs on each grid, coarse to fine, with its cells per diameter."""
    if RESOLUTION not in cube.dims:
        yield float(cube[RESOLUTION]), cube
        return
    for cells in cube[RESOLUTION].values:
        yield float(cells), cube.sel({RESOLUTION: cells})


def kinetic_energy(run: xr.Dataset) -> tuple[np.ndarray, np.ndarray]:
    """Times, s, and kinetic energy of all bodies, J, of a run; (samples,)."""
    time = run.history_time.values
    energy = run.body_kinetic_energy_history.sum("body", min_count=1).values
    there = np.isfinite(time) & np.isfinite(energy)
    return time[there], energy[there]


def energy_line(label: str, run: xr.Dataset) -> Line:
    """The kinetic energy over time of a run; J, and us."""
    points = zip(*kinetic_energy(run), strict=True)
    return Line(label, tuple((1e6 * float(x), float(y), 0.0) for x, y in points), joined=True)


def against(
    name: str, title: str, cube: xr.Dataset, quantity: str, axis: str, numbers: Sequence[PublishedNumber]
) -> Picture:
    """A quantity over an axis: each grid, the converged value with its bar, and the published numbers."""
    points = [ComparedReading(cube, quantity, {axis: float(value)}) for value in cube[axis].values]
    first, along = points[0], display_of(cube[axis].attrs.get("units"))
    x = [along.factor * float(value) for value in cube[axis].values]

    def line(label: str, values: Iterable[tuple[float, float]]) -> Line:
        triples = ((place, *point) for place, point in zip(x, values, strict=True))
        return Line(label, tuple(each for each in triples if math.isfinite(each[1])))

    lines = [line(f"{grid:g} cells per diameter", [(each.on(grid), 0.0) for each in points]) for grid in first.grids]
    ours = "whipple, converged" if first.is_refined else "whipple"
    lines.append(line(ours, [each.point for each in points]))
    for by in dict.fromkeys(each.by for each in numbers):
        theirs = [
            (along.factor * each.at(axis), first.factor * each.value, 0.0)
            for each in numbers
            if each.by == by and each.shot.quantity == quantity
        ]
        lines.append(Line(by, tuple(theirs)))
    x_label = with_unit(axis.replace("_", " "), cube[axis].attrs.get("units"))
    return Picture(name, title, x_label, first.label, tuple(lines))
