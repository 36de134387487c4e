"""A cube as figures look at it: runs in a row, an abscissa, and panels."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TypeVar

import numpy as np
import xarray as xr

from studies.cubes.variables import VERDICT_WORDS
from studies.reports.places import Place, axes_of, places_of
from studies.reports.points import UNSETTLED, comparable, simulated
from studies.values.quantities import readable

MOST_PANELS = 12  # more are in the cube; a page of small pictures is read by nobody
PREFERRED = "speed"  # the abscissa where the sweep varies it

Item = TypeVar("Item")


@dataclass(frozen=True)
class Scale:
    """What an axis of a figure measures."""

    name: str  # variable of the cube, or "ratio"
    label: str
    unit: str | None  # SI; None for text


@dataclass(frozen=True)
class Slice:
    """Runs of one panel, in the order of the abscissa: places in the flattened arrays."""

    title: str
    at: Place
    cells: np.ndarray
    connected: bool


@dataclass(frozen=True)
class FigureView:
    """A cube as figures see it: flat arrays over its points, and how they fall into panels."""

    dataset: xr.Dataset  # of points
    abscissa: Scale
    x: tuple[float | str, ...]  # of each run
    diameter: np.ndarray  # of each run, m; NaN where unknown
    slices: tuple[Slice, ...]
    left_out: int  # panels that are not shown

    def flat(self, name: str) -> np.ndarray:
        """Values of each run: (runs,) or (runs, more)."""
        values = self.dataset[name].values
        return values.reshape(len(self.x), *values.shape[len(self.dataset.run_state.dims) :])

    def succeeded(self, name: str) -> np.ndarray:
        """Measured values of each run; NaN where the run did not succeed."""
        return simulated(self.dataset, name).values.ravel()

    def compared(self, name: str) -> np.ndarray:
        """Measured values of each run with which laws are compared; NaN elsewhere."""
        return comparable(self.dataset, name).values.ravel()

    @property
    def refined(self) -> bool:
        """Whether points are converged over resolutions or offsets, or single runs."""
        return bool(self.dataset.attrs.get("refinements"))

    def unsettled(self, name: str) -> np.ndarray:
        """Whether refinement of a point has not settled its value."""
        if not self.refined:
            return np.zeros(len(self.x), bool)
        words = [VERDICT_WORDS.index(verdict.replace(" ", "_")) for verdict in UNSETTLED]
        return np.isin(self.flat(f"{name}_converged_verdict"), words)

    def law_words(self, name: str, key: str) -> list[str]:
        """A word of each law of a quantity, along its law dimension."""
        return [str(word) for word in self.dataset[f"{name}_law_{key}"].values]

    def normed(self, name: str) -> bool:
        """Whether it is shown over the projectile's diameter: a length, all diameters known."""
        return bool(self.dataset[name].attrs["units"] == "m" and np.isfinite(self.diameter).all())

    def norm(self, name: str) -> np.ndarray:
        """What the values of each run are divided by."""
        return self.diameter if self.normed(name) else np.ones(len(self.x))

    def xs(self, piece: Slice) -> tuple[float | str, ...]:
        return tuple(self.x[cell] for cell in piece.cells)


def main_quantities(dataset: xr.Dataset) -> list[str]:
    """Quantities that are no other reading of one (``hole_diameter_lip`` of ``hole_diameter``)."""
    names = str(dataset.attrs["quantities"]).split()
    return [
        name
        for name in names
        if not any(name.startswith(f"{other}_") for other in names if other != name)
    ]


def view_of(dataset: xr.Dataset) -> FigureView:
    """Choose the abscissa and the panels of a cube."""
    places = places_of(dataset)
    axes = axes_of(dataset)
    name = _abscissa(dataset, axes)
    x = (
        tuple(place.get(name, "this run") for place in places)
        if name
        else ("this run",) * len(places)
    )
    slices = _slices(dataset, places, [axis for axis in axes if axis != name], x)
    shown = spread(slices, MOST_PANELS)
    return FigureView(
        dataset, _scale(dataset, name), x, _diameters(dataset), shown, len(slices) - len(shown)
    )


def _abscissa(dataset: xr.Dataset, axes: Sequence[str]) -> str | None:
    if PREFERRED in axes:
        return PREFERRED
    numeric = [axis for axis in axes if dataset[axis].dtype.kind == "f"]
    return next(iter([*numeric, *axes]), None)


def _scale(dataset: xr.Dataset, name: str | None) -> Scale:
    if name is None:
        return Scale("run", "run", None)
    return Scale(name, name.replace("_", " "), dataset[name].attrs.get("units"))


def _diameters(dataset: xr.Dataset) -> np.ndarray:
    if "equivalent_diameter" not in dataset:
        return np.full(dataset.run_state.size, math.nan)
    return (
        dataset.equivalent_diameter.broadcast_like(dataset.run_state)
        .transpose(*dataset.run_state.dims)
        .values.ravel()
    )


def _slices(
    dataset: xr.Dataset, places: Sequence[Place], others: Sequence[str], x: Sequence[float | str]
) -> list[Slice]:
    groups: dict[tuple[float | str, ...], list[int]] = {}
    for cell, place in enumerate(places):
        groups.setdefault(tuple(place[axis] for axis in others), []).append(cell)
    if "run" in dataset.dims and 2 * len(groups) > len(places):
        groups = {(): list(range(len(places)))}  # hardly two runs share anything: one picture
    connected = len(groups) > 1 or not others
    return [
        _slice(dataset, dict(zip(others, key, strict=False)), cells, x, connected)
        for key, cells in groups.items()
    ]


def _slice(
    dataset: xr.Dataset, at: Place, cells: list[int], x: Sequence[float | str], connected: bool
) -> Slice:
    title = ", ".join(named_value(dataset, axis, value) for axis, value in at.items())
    numeric = all(not isinstance(x[cell], str) for cell in cells)
    ordered = sorted(cells, key=lambda cell: x[cell]) if numeric else cells
    return Slice(title, at, np.array(ordered), connected and numeric)


def named_value(dataset: xr.Dataset, name: str, value: float | str) -> str:
    """A value with its name: "plate thickness 2 mm"."""
    words = name.replace("_", " ")
    if isinstance(value, str):
        return f"{words} {value}"
    return f"{words} {readable(value, dataset[name].attrs.get('units', '1'))}"


def spread(items: Sequence[Item], most: int) -> tuple[Item, ...]:
    """At most so many, first and last among them."""
    if len(items) <= most:
        return tuple(items)
    return tuple(items[place] for place in np.linspace(0, len(items) - 1, most).round().astype(int))


def flag_words(dataset: xr.Dataset, name: str) -> list[tuple[str, ...]]:
    """The flags of each run, in words."""
    masks = np.atleast_1d(dataset[name].attrs["flag_masks"])
    meanings = str(dataset[name].attrs["flag_meanings"]).split()
    return [
        tuple(word for mask, word in zip(masks, meanings, strict=True) if value & mask)
        for value in dataset[name].values.ravel()
    ]
