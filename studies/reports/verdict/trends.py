"""Trends of residuals against the axes, and exponents of a quantity beside those of a law, with their intervals."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from studies.cubes.points import Place
from studies.laws.fitting.least_squares import linear
from studies.quantities.display import display_of
from studies.reports.verdict.evidence import AxisOfSweep, JudgedPoint

# Beyond this ratio of the largest to the smallest residual an average hides what the residuals do.
UNEVEN = 2.0
ROUNDING = 1e-6  # exponents that differ by less are the same
FEWEST = 3  # values of an axis to which an exponent is fitted: fewer leave no scatter to judge it by


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


@dataclass(frozen=True)
class Exponent:
    """Exponents of a reference and of a law over one axis, fitted to the same points."""

    axis: str
    at: Place  # values of the other axes
    n: int
    reference: float
    interval: float  # half length, of the scatter about the power and the error bars of the points together
    law: float

    @property
    def is_refuted(self) -> bool:
        """Whether that of the law is outside of the interval of that of the reference."""
        return abs(self.law - self.reference) > self.interval + ROUNDING


def is_uneven(residuals: np.ndarray) -> bool:
    """Whether an average would hide what residuals do: they change sign, or vary by more than ``UNEVEN``.

    >>> [is_uneven(np.array(pair)) for pair in ((-0.1, 0.1), (0.1, 0.3), (0.1, 0.2))]
    [True, True, False]
    """
    if residuals.size < 2:
        return False
    sizes = np.abs(residuals)
    return bool(residuals.min() < 0.0 < residuals.max() or sizes.max() > UNEVEN * sizes.min())


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


def exponents_of(points: Sequence[JudgedPoint], axes: Sequence[AxisOfSweep]) -> Iterator[Exponent]:
    """The exponents over each axis, for each combination of the others that has ``FEWEST`` values or more."""
    for axis in axes:
        if axis.unit is None:
            continue
        others = [other.name for other in axes if other != axis]
        groups: dict[tuple[float | str | None, ...], list[JudgedPoint]] = {}
        for point in points:
            if axis.name in point.at:
                key = tuple(point.at.get(name) for name in others)
                groups.setdefault(key, []).append(point)
        for key, mine in groups.items():
            x = np.array([float(point.at[axis.name]) for point in mine])
            y = np.array([(point.reference, point.law) for point in mine])
            if len(set(x)) < FEWEST or (x <= 0.0).any() or (y <= 0.0).any():
                continue
            power = (np.ones(len(x)), np.log(x))
            reference, law = (linear(power, np.log(column)) for column in y.T)
            # The slope is sum of (x - mean) y / sum of (x - mean)^2: so much of it are the error bars of y.
            leverage = power[1] - power[1].mean()
            barred = np.linalg.norm(leverage * [point.bar for point in mine]) / (leverage**2).sum()
            at = {name: value for name, value in zip(others, key, strict=True) if value is not None}
            yield Exponent(
                axis.name,
                at,
                len(mine),
                float(reference.constants[1]),
                float(np.hypot(reference.intervals[1], barred)),
                float(law.constants[1]),
            )
