"""Where a cell of a cube is: the values of its axes."""

from collections.abc import Mapping
from typing import Any

import numpy as np
import xarray as xr

from studies.reports.points import refinements_of

Place = Mapping[str, float | str]


def places_of(dataset: xr.Dataset) -> list[dict[str, float | str]]:
    """The axis values of each cell, in the order in which ``values.ravel()`` has them."""
    axes = axes_of(dataset)
    grid = np.broadcast_arrays(
        *(dataset[axis].broadcast_like(dataset.run_state).values for axis in axes)
    )
    columns = [array.ravel() for array in grid]
    return [
        {axis: plain(column[cell]) for axis, column in zip(axes, columns, strict=True)}
        for cell in range(dataset.run_state.size)
    ]


def axes_of(dataset: xr.Dataset) -> list[str]:
    """Names of the axes of the sweep, dimensions or not; where cells are runs, of refinements too."""
    return [*str(dataset.attrs["axes"]).split(), *refinements_of(dataset)]


def plain(value: Any) -> float | str:
    """A coordinate's value as a float or a text of Python's own."""
    return str(value) if isinstance(value, str) else float(value)
