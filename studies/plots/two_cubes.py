"""Two cubes beside each other: a figure of each main quantity with both, and a table of their differences."""

import json
import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import pandas as pd
import xarray as xr

from studies.cubes import reading
from studies.cubes.long_texts import short_texts
from studies.cubes.opening import whole_cube
from studies.cubes.points import Place, axes_of, is_same, main_quantities, places_of, plain, points_of
from studies.quantities.files import write_text
from studies.quantities.findings import refusal
from studies.reports.drawing.charts import draw
from studies.reports.figure import Figure, Panel, Scale
from studies.reports.figures import simulation
from studies.reports.view import PREFERRED, FigureView, title_of, view_of

TABLE = "differences.csv"


@dataclass(frozen=True)
class Difference:
    """A quantity at a point of two cubes; SI, over the diameter of the projectile where the figure has it so."""

    scale: Scale  # of the quantity
    at: Place
    values: tuple[float, float]  # NaN where a cube has none
    bars: tuple[float, float]  # error bars; NaN where a mesh error is unknown

    @property
    def relative(self) -> float:
        """The second less the first, over the first."""
        return self.values[1] / self.values[0] - 1.0 if self.values[0] else math.nan

    @property
    def in_bars(self) -> float:
        """The difference over the root of the sum of the squares of both error bars; NaN where one is unknown."""
        bar = math.hypot(*self.bars)
        return (self.values[1] - self.values[0]) / bar if bar else math.nan


@dataclass(frozen=True)
class TwoCubes:
    """Two cubes by their points, with what both have."""

    names: tuple[str, str]  # of the sweeps
    views: tuple[FigureView, FigureView]  # over the same abscissa
    axes: tuple[str, ...]  # that either sweep varies and both state
    quantities: tuple[str, ...]
    others: dict[str, tuple[str, str]]  # parameters that both fix, in words, where these differ

    def differences(self) -> Iterator[Difference]:
        """Each quantity at each point that both cubes have."""
        first, second = (places_of(view.dataset, self.axes) for view in self.views)
        pairs = [(i, j) for i, mine in enumerate(first) for j, other in enumerate(second) if _same(mine, other)]
        for name in self.quantities:
            scale = self.views[0].scale_of(name)
            values = [view.succeeded(name) for view in self.views]
            bars = [view.error_bars(name) for view in self.views]
            for i, j in pairs:
                both = float(values[0][i]), float(values[1][j])
                if np.isfinite(both).any():
                    yield Difference(scale, first[i], both, (float(bars[0][i]), float(bars[1][j])))

    def figure(self, name: str) -> Figure:
        """A quantity of both cubes over the abscissa, a panel for each value of the other axes that both have."""
        others = [axis for axis in self.axes if axis != self.views[0].abscissa.name]
        first, second = (places_of(view.dataset, others) for view in self.views)
        panels = []
        for piece in self.views[0].slices:
            at = first[piece.cells[0]]
            pieces = [other for other in self.views[1].slices if _same(at, second[other.cells[0]])]
            shown = [
                (self.views[0], piece, self.names[0]),
                *((self.views[1], other, self.names[1]) for other in pieces),
            ]
            series = [
                replace(points, kind="quantity", label=label)
                for view, cells, label in shown
                for points in simulation(view, name, cells)
            ]
            if len({line.label for line in series}) == len(self.names):
                panels.append(Panel(title_of(self.views[0].dataset, at), at, tuple(series)))
        scale = self.views[0].scale_of(name)
        words = f"{scale.label.capitalize()} against {self.views[0].abscissa.label}"
        title = f"{words}: {' and '.join(self.names)}"
        return Figure(f"{name}_two_cubes", title, "", self.views[0].abscissa, scale, tuple(panels))


def two_cubes(first: Path, second: Path) -> TwoCubes:
    """Two cubes of files or folders; raises InvalidInput where they have no quantity or no axis in common."""
    cubes = [_with_short_texts(whole_cube(path)) for path in (first, second)]
    names = [str(json.loads(cube.attrs["sweep"])["name"]) for cube in cubes]
    if names[0] == names[1]:
        names = [f"{name} ({path})" for name, path in zip(names, (first, second), strict=True)]
    points = [points_of(cube) for cube in cubes]
    quantities = [name for name in main_quantities(points[0]) if name in main_quantities(points[1])]
    own = [axes_of(cube) for cube in points]
    varied = [axis for axis in own[0] if axis in own[1]]
    for what, common, lists in (
        ("a quantity", quantities, [reading.quantities_of(cube) for cube in points]),
        ("an axis", varied, own),
    ):
        if not common:
            have = "; ".join(f"{name} has {', '.join(listed)}" for name, listed in zip(names, lists, strict=True))
            raise refusal("CUBES", " and ".join(names), f"{what} that both cubes have", have)
    numeric = [axis for axis in varied if all(cube[axis].dtype.kind == "f" for cube in points)]
    abscissa = PREFERRED if PREFERRED in varied else [*numeric, *varied][0]
    views = [view_of(cube, abscissa) for cube in points]
    axes = tuple(axis for axis in dict.fromkeys(own[0] + own[1]) if all(axis in cube.variables for cube in points))
    others = _others(points[0], points[1], axes)
    return TwoCubes((names[0], names[1]), (views[0], views[1]), axes, tuple(quantities), others)


def draw_two(cubes: TwoCubes, folder: Path, format: str) -> list[Path]:
    """Draw a figure for each quantity, and write the table of differences (CSV, SI); the files.

    Raises InvalidInput where no point and no panel has both.
    """
    figures = [figure for name in cubes.quantities if (figure := cubes.figure(name)).panels]
    rows = [
        {
            "quantity": difference.scale.label,
            **difference.at,
            **dict(zip(cubes.names, difference.values, strict=True)),
            **{f"{name}, error bar": bar for name, bar in zip(cubes.names, difference.bars, strict=True)},
            "relative difference": difference.relative,
        }
        for difference in cubes.differences()
    ]
    if not figures and not rows:
        values = f"they overlap in no value of {', '.join(cubes.axes)}"
        raise refusal("CUBES", " and ".join(cubes.names), "points or series that both cubes have", values)
    drawn = [draw(figure, folder / f"{figure.name}.{format}") for figure in figures]
    return [*drawn, write_text(folder / TABLE, pd.DataFrame(rows).to_csv(index=False, lineterminator="\n"))]


def _with_short_texts(cube: xr.Dataset) -> xr.Dataset:
    """A cube whose decks stand by first line and digest, which tell them apart as well."""
    short = short_texts(cube)
    long = [name for name, array in cube.coords.items() if array.dtype.kind in "OUT" and short]
    shorten = np.vectorize(lambda text: short.get(text, text), otypes=[object])
    return cube.assign_coords({name: cube[name].copy(data=shorten(cube[name].values)) for name in long})


def _same(first: Place, second: Place) -> bool:
    return all(is_same(value, second[axis]) for axis, value in first.items())


def _others(first: xr.Dataset, second: xr.Dataset, axes: Sequence[str]) -> dict[str, tuple[str, str]]:
    """The parameters that are one value in each cube, and not the same."""

    def fixed(cube: xr.Dataset) -> dict[str, float | str]:
        return {
            str(name): plain(array.item())
            for name, array in cube.coords.items()
            if not array.dims and name not in axes and array.attrs["group"] == "inputs"
        }

    mine, other = fixed(first), fixed(second)
    both = [name for name in mine if name in other and not is_same(mine[name], other[name])]
    return {name: (title_of(first, {name: mine[name]}), title_of(second, {name: other[name]})) for name in both}
