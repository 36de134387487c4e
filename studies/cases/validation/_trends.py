"""Trends of residuals against the axes, with their intervals."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from studies.cubes.points import Place
from studies.quantities.display import display_of
from studies.quantities.least_squares import linear


@dataclass(frozen=True)
class AxisOfSweep:
    """The name of an axis of a sweep, and its unit."""

    name: str
    unit: str | None  # SI; None for text


@dataclass(frozen=True)
class Slope:
    """The change of a relative residual along one axis."""

    axis: str
    unit: str  # in which people read the axis
    value: float  # change of the residual for one such unit
    interval: float  # half length


@dataclass(frozen=True)
class Trend:
    """A plane fitted to residuals by least squares."""

    n: int
    slopes: tuple[Slope, ...]  # none where there are too few points


def trend_of(places: Sequence[Place], residuals: np.ndarray, axes: Sequence[AxisOfSweep]) -> Trend:
    """The plane r = r0 + sum of slope x axis, by least squares; only the axes that the points can tell apart."""
    varied = [
        (axis, np.array([float(place[axis.name]) for place in places]) * display_of(axis.unit).factor)
        for axis in axes
        if axis.unit is not None
        and len({place.get(axis.name) for place in places} - {None}) > 1
        and all(axis.name in place for place in places)
    ]
    columns: list[np.ndarray] = []
    fitted: list[AxisOfSweep] = []
    for axis, values in varied:
        wider = np.column_stack([np.ones(len(places)), *columns, values - values.mean()])
        if len(places) > wider.shape[1] and np.linalg.matrix_rank(wider) == wider.shape[1]:
            columns.append(values - values.mean())
            fitted.append(axis)
    if not fitted:
        return Trend(len(places), ())
    plane = linear([np.ones(len(places)), *columns], residuals)
    slopes, intervals = plane.constants[1:], plane.intervals[1:]
    return Trend(
        len(places),
        tuple(
            Slope(axis.name, display_of(axis.unit).unit, float(slope), float(interval))
            for axis, slope, interval in zip(fitted, slopes, intervals, strict=True)
        ),
    )
