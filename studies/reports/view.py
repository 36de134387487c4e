"""A cube as figures look at it: points in a row, an abscissa, and panels."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TypeVar

import numpy as np
import xarray as xr

from studies.cubes import reading
from studies.cubes import variables as cubes
from studies.cubes.points import axes_of, by_run, error_bars, mesh_part, places_of, simulated_values
from studies.cubes.variable import Variable
from studies.quantities.measured import flags_in_words
from studies.quantities.units import readable
from studies.reports.figure import Scale
from studies.reports.records import Place
from studies.reports.wording import words
from studies.sweeps.reading import RESOLUTION

MOST_PANELS = 6  # panels of a figure; further panels are in the cube
MOST_POINTS = 150  # in curves; more, over two axes of numbers, are maps
PREFERRED = "speed"  # the abscissa where the sweep varies it

Item = TypeVar("Item")


@dataclass(frozen=True)
class Slice:
    """Points of one panel, in the order of the abscissa: places in the flattened arrays."""

    title: str
    at: Place
    cells: np.ndarray
    connected: bool


@dataclass(frozen=True)
class FigureView:
    """A cube as figures see it: flat arrays over its points, and how they fall into panels."""

    dataset: xr.Dataset  # of points
    abscissa: Scale
    x: tuple[float | str, ...]  # of each point
    diameter: np.ndarray  # of each point, m; NaN where unknown
    slices: tuple[Slice, ...]
    left_out: int  # panels that are not shown
    in_diameters: bool = False  # whether lengths are shown over the projectile's diameter

    def flat(self, variable: Variable, name: str = "") -> np.ndarray:
        """Values of each point: (points,) or (points, more); NaN where the cube does not have the variable."""
        if not variable.is_in(self.dataset, name):
            return np.full(len(self.x), np.nan)
        values = variable.of(self.dataset, name).values
        return values.reshape(len(self.x), *values.shape[len(self.dataset.variables["run_state"].dims) :])

    def succeeded(self, name: str) -> np.ndarray:
        """Measured values of each point; NaN where no run succeeded."""
        return simulated_values(self.dataset, name).ravel()

    def error_bars(self, name: str) -> np.ndarray:
        """Error bars (points,); NaN where the mesh error is unknown."""
        return error_bars(self.dataset, name).values.ravel()

    @property
    def refinements(self) -> list[str]:
        """Parameters over which each point was computed several times: resolution, offset, or neither."""
        return str(self.dataset.attrs["refinements"]).split()

    def is_open(self, name: str) -> np.ndarray:
        """Whether a point (points,) is drawn open: it carries a flag, or resolutions tell no mesh error."""
        flags = self.flat(cubes.FLAGS_OF_RUN) | reading.doubts(cubes.FLAGS.of(self.dataset, name)).values.ravel()
        unknown = np.isnan(mesh_part(self.dataset, name)).ravel()
        return (flags != 0) | (unknown & (RESOLUTION in self.refinements))

    def doubts(self, name: str) -> list[str]:
        """The flags of a quantity and of its run at each point, in words; empty without any."""
        return [", ".join(flags_in_words(flags)) for flags in reading.doubts_at(self.dataset, name)]

    def normed(self, name: str) -> bool:
        """Whether it is shown over the projectile's diameter."""
        return self.in_diameters and self.is_length(name)

    def is_length(self, name: str) -> bool:
        """Whether it is a length that diameters of projectiles can divide: all are known."""
        return bool(self.dataset[name].attrs["units"] == "m" and np.isfinite(self.diameter).all())

    def norm(self, name: str) -> np.ndarray:
        """The divisor of the values of each point."""
        return self.diameter if self.normed(name) else np.ones(len(self.x))

    def scale_of(self, name: str) -> Scale:
        """A quantity over the projectile's diameter where that makes sense, else in its own unit."""
        label = words(name)
        if self.normed(name):
            return Scale("ratio", f"{label} / projectile diameter", "1")
        return Scale(name, label, self.dataset[name].attrs["units"])

    def xs(self, piece: Slice) -> tuple[float | str, ...]:
        return tuple(self.x[cell] for cell in piece.cells)


def views_of(dataset: xr.Dataset) -> list[FigureView]:
    """Views of a cube of points: over the speed, or else the first axis, and if its points are listed over each axis.

    Points of a list, pairs or a sample, fill no panels of equal other axes: each axis then shows its own scatter.
    """
    first = view_of(dataset)
    if "run" not in dataset.dims or len(first.slices) > 1:
        return [first]
    others = [axis for axis in axes_of(dataset) if axis != first.abscissa.name]
    varied = (axis for axis in others if len(np.unique(dataset[axis].values)) > 1)
    return [first, *(view_of(dataset, axis) for axis in varied)]


def view_of(dataset: xr.Dataset, abscissa: str = "") -> FigureView:
    """Choose the abscissa, unless it is named, and the panels of a cube of points."""
    places, axes = places_of(dataset), axes_of(dataset)
    numeric = [axis for axis in axes if dataset[axis].dtype.kind == "f"]
    name = abscissa or (PREFERRED if PREFERRED in axes else [*numeric, *axes][0])
    slices = _slices(dataset, places, name)
    shown = spread(slices, MOST_PANELS)
    has_diameter = cubes.EQUIVALENT_DIAMETER.is_in(dataset)
    return FigureView(
        dataset,
        Scale(name, words(name), dataset[name].attrs.get("units")),
        tuple(place[name] for place in places),
        by_run(dataset, "equivalent_diameter") if has_diameter else np.full(len(places), np.nan),
        shown,
        len(slices) - len(shown),
    )


def second_axis(view: FigureView) -> Scale | None:
    """The other axis of maps: of those with numbers the one with most values; None of few points or of one axis."""
    dataset = view.dataset
    counts = {
        axis: len(np.unique(dataset[axis].values))
        for axis in axes_of(dataset)
        if axis != view.abscissa.name and dataset[axis].dtype.kind == "f"
    }
    if len(view.x) <= MOST_POINTS or view.abscissa.unit is None or max(counts.values(), default=1) < 2:
        return None
    name = max(counts, key=lambda axis: counts[axis])
    return Scale(name, words(name), dataset[name].attrs.get("units"))


def groups_of(places: Sequence[Place], axes: Sequence[str]) -> dict[tuple[float | str, ...], list[int]]:
    """The numbers of the points that share their values of some axes, by these."""
    groups: dict[tuple[float | str, ...], list[int]] = {}
    for cell, place in enumerate(places):
        groups.setdefault(tuple(place[axis] for axis in axes), []).append(cell)
    return groups


def _slices(dataset: xr.Dataset, places: Sequence[Place], abscissa: str) -> list[Slice]:
    """The points that share every axis but the abscissa; all of them where hardly two share anything."""
    others = [axis for axis in axes_of(dataset) if axis != abscissa]
    groups = groups_of(places, others)
    if "run" in dataset.dims and 2 * len(groups) > len(places):
        groups = {(): list(range(len(places)))}
    connected = len(groups) > 1 or not others
    numeric = dataset[abscissa].dtype.kind == "f"
    slices = []
    for key, cells in groups.items():
        at = dict(zip(others, key, strict=False))
        ordered = sorted(cells, key=lambda cell: places[cell][abscissa]) if numeric else cells
        slices.append(Slice(title_of(dataset, at), at, np.array(ordered), connected and numeric))
    return slices


def title_of(dataset: xr.Dataset, at: Place) -> str:
    """A place in words: "plate thickness 2 mm, target al-6061-t6"."""
    return ", ".join(f"{words(axis)} {told(value, dataset[axis].attrs.get('units'))}" for axis, value in at.items())


def told(value: float | str, unit: str | None) -> str:
    """A value of an axis in words: "2 mm"."""
    return value if isinstance(value, str) else readable(value, unit or "1")


def spread(items: Sequence[Item], most: int) -> tuple[Item, ...]:
    """At most so many items, evenly, first and last among them."""
    if len(items) <= most:
        return tuple(items)
    return tuple(items[place] for place in np.linspace(0, len(items) - 1, most).round().astype(int))
