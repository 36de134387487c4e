"""Computes the section of residual velocities: a curve for each place of the axes beside the speed."""

import math
from collections.abc import Iterator

import numpy as np
import xarray as xr

from studies.cubes.points import axes_of, places_of, simulated_values
from studies.cubes.reading import finite
from studies.plugs.section import EQUATION, SOURCE, FittedConstant, ResidualCurve, ResidualVelocities
from studies.quantities.least_squares import NotIdentified, nonlinear
from studies.reports.figure import Figure, Panel, Scale, Series, numbers
from studies.reports.section import Part, Source
from studies.reports.view import title_of

RESIDUAL, SPEED = "residual_velocity", "speed"
CONSTANTS = ("a", "p", "v_bl")
# Points with a residual velocity that a fit takes: one more than constants, for an interval.
LEAST = len(CONSTANTS) + 1
CURVE = 60  # points of a drawn curve
ENERGY = 2.0  # p where nothing is lost but the energy at the limit: the start of the iteration


def residual_velocities_of(source: Source) -> Part | None:
    """The section; None where no residual velocity was measured along the speed."""
    dataset = source.dataset
    if RESIDUAL not in dataset or SPEED not in axes_of(dataset):
        return None
    curves = tuple(_curves(dataset))
    return Part(ResidualVelocities(EQUATION, SOURCE, curves), (_figure(dataset, curves),)) if curves else None


def _curves(dataset: xr.Dataset) -> Iterator[ResidualCurve]:
    """A curve for each combination of the axes beside the speed that has a residual velocity."""
    values = simulated_values(dataset, RESIDUAL).ravel()
    groups: dict[tuple[tuple[str, float | str], ...], list[tuple[float, float]]] = {}
    for place, value in zip(places_of(dataset), values, strict=True):
        others = tuple((name, at) for name, at in place.items() if name != SPEED)
        if math.isfinite(value):
            groups.setdefault(others, []).append((float(place[SPEED]), float(value)))
    for others, points in groups.items():
        speed, residual = np.array(sorted(points)).T
        through = residual > 0.0
        fitted = fitted_curve(speed[through], residual[through])
        yield ResidualCurve(
            at=dict(others),
            speed=tuple(speed.tolist()),
            residual_velocity=tuple(residual.tolist()),
            points=int(through.sum()),
            too_few=bool(through.sum() < LEAST),
            **{name: fitted.get(name) for name in CONSTANTS},
        )


def fitted_curve(v: np.ndarray, y: np.ndarray) -> dict[str, FittedConstant]:
    """The constants by residual velocities ``y`` (n,) at impact speeds ``v``, m/s; empty where they are not told."""
    if len(v) < LEAST:
        return {}
    # v_r^2 = a^2 v^2 - a^2 v_bl^2 gives the constants from which the iteration begins.
    slope, offset = np.polyfit(v**2, y**2, 1)
    begin = math.sqrt(max(-offset / slope, 0.0)) if slope > 0.0 else 0.0
    start = np.array([math.sqrt(abs(slope)), ENERGY, min(begin, 0.999 * v.min())])
    try:
        solution = nonlinear(lambda constants: recht_ipson(v, *constants), start, y)
    except (NotIdentified, np.linalg.LinAlgError):
        return {}
    return {
        name: FittedConstant(finite(value), finite(reach))
        for name, value, reach in zip(CONSTANTS, solution.constants, solution.intervals, strict=True)
    }


def recht_ipson(speed: np.ndarray, a: float, p: float, limit: float) -> np.ndarray:
    """Residual velocities (n,) at impact speeds (n,), m/s; 0 up to the limit.

    A projectile of 80 g with a plug of 20 g keeps four fifths of the speed that the energy beyond the limit gives:

    >>> recht_ipson(np.array([100.0, 150.0, 250.0]), 0.8, 2.0, 150.0).round(9).tolist()
    [0.0, 0.0, 160.0]
    """
    beyond = np.maximum((np.asarray(speed) / abs(limit)) ** p - 1.0, 0.0)
    velocity: np.ndarray = a * abs(limit) * beyond ** (1.0 / p)
    return velocity


def _figure(dataset: xr.Dataset, curves: tuple[ResidualCurve, ...]) -> Figure:
    """Residual velocities over the impact speed, each with its curve."""
    panels = []
    for curve in curves:
        series = [Series("quantity", "simulation", curve.speed, numbers(curve.residual_velocity), connected=False)]
        constants = [fitted.value for fitted in (curve.a, curve.p, curve.v_bl) if fitted and fitted.value is not None]
        if len(constants) == len(CONSTANTS):
            x = np.linspace(min(constants[2], *curve.speed), max(curve.speed), CURVE)
            y = recht_ipson(x, *constants)
            series.append(Series("trend", "Recht and Ipson", tuple(x.tolist()), numbers(y)))
        panels.append(Panel(title_of(dataset, curve.at), curve.at, tuple(series)))
    return Figure(
        name="residual_velocity_curve",
        title="Residual velocity against speed",
        caption=f"Residual velocities of all runs; curve: {EQUATION}, fitted to those that perforate.",
        x=Scale(SPEED, "speed", "m s-1"),
        y=Scale(RESIDUAL, "residual velocity", "m s-1"),
        panels=tuple(panels),
    )
