"""Residual velocities with the curve of Recht and Ipson."""

import math
from collections.abc import Iterator
from typing import Any

import numpy as np
import xarray as xr

from studies.cubes.points import axes_of, places_of, simulated_values
from studies.cubes.reading import finite
from studies.laws.fitting.least_squares import NotIdentified, nonlinear
from studies.reports.figure import Figure, Panel, Scale, Series, numbers
from studies.reports.view import title_of

RESIDUAL, SPEED, PERFORATED = "residual_velocity", "speed", "perforated"
CONSTANTS = ("a", "p", "v_bl")
EQUATION = "v_r = a (v^p - v_bl^p)^(1/p)"
SOURCE = "Recht and Ipson (1963), J. Appl. Mech. 30, 384 (recalled, not read)"
# Points with a residual velocity that a fit takes: one more than constants, for an interval.
LEAST = len(CONSTANTS) + 1
CURVE = 60  # points of a drawn curve
ENERGY = 2.0  # p where nothing is lost but the energy at the limit: the start of the iteration


def residual_curves(dataset: xr.Dataset) -> dict[str, Any] | None:
    """Residual velocities by impact speed with the constants of their curve; None where none were measured."""
    if RESIDUAL not in dataset or SPEED not in axes_of(dataset):
        return None
    rows = list(_curves(dataset))
    return {"equation": EQUATION, "source": SOURCE, "rows": rows} if rows else None


def _curves(dataset: xr.Dataset) -> Iterator[dict[str, Any]]:
    """A row for each combination of the axes beside the speed that has a residual velocity."""
    values = simulated_values(dataset, RESIDUAL).ravel()
    groups: dict[tuple[tuple[str, Any], ...], list[tuple[float, float]]] = {}
    for place, value in zip(places_of(dataset), values, strict=True):
        others = tuple((name, each) for name, each in place.items() if name != SPEED)
        if math.isfinite(value):
            groups.setdefault(others, []).append((float(place[SPEED]), float(value)))
    for others, points in groups.items():
        speed, residual = np.array(sorted(points)).T
        yield {
            "at": dict(others),
            "speed": speed.tolist(),
            "residual_velocity": residual.tolist(),
            **fitted_curve(speed, residual),
        }


def fitted_curve(speed: np.ndarray, residual: np.ndarray) -> dict[str, Any]:
    """The constants with the half lengths of their intervals, or the reason why there are none."""
    empty: dict[str, Any] = dict.fromkeys(CONSTANTS)
    through = residual > 0.0
    if through.sum() < LEAST:
        reason = f"not fitted: {through.sum()} perforations, {len(CONSTANTS)} constants take {LEAST} or more"
        return {**empty, "points": int(through.sum()), "reason": reason}
    v, y = speed[through], residual[through]
    # v_r^2 = a^2 v^2 - a^2 v_bl^2 gives the constants from which the iteration begins.
    slope, offset = np.polyfit(v**2, y**2, 1)
    begin = math.sqrt(max(-offset / slope, 0.0)) if slope > 0.0 else 0.0
    start = np.array([math.sqrt(abs(slope)), ENERGY, min(begin, 0.999 * v.min())])
    try:
        solution = nonlinear(lambda constants: recht_ipson(v, *constants), start, y)
    except (NotIdentified, np.linalg.LinAlgError):
        reason = "not fitted: the points do not tell its constants apart"
        return {**empty, "points": len(v), "reason": reason}
    constants = {
        name: {"value": finite(value), "half_interval": finite(reach)}
        for name, value, reach in zip(CONSTANTS, solution.constants, solution.intervals, strict=True)
    }
    return {**constants, "points": len(v), "reason": ""}


def recht_ipson(speed: np.ndarray, a: float, p: float, limit: float) -> np.ndarray:
    """Residual velocities (n,) at impact speeds (n,), m/s; 0 up to the limit.

    A projectile of 80 g with a plug of 20 g keeps four fifths of the speed that the energy beyond the limit gives:

    >>> recht_ipson(np.array([100.0, 150.0, 250.0]), 0.8, 2.0, 150.0).round(9).tolist()
    [0.0, 0.0, 160.0]
    """
    beyond = np.maximum((np.asarray(speed) / abs(limit)) ** p - 1.0, 0.0)
    velocity: np.ndarray = a * abs(limit) * beyond ** (1.0 / p)
    return velocity


def residual_figure(dataset: xr.Dataset, curves: dict[str, Any] | None) -> Iterator[Figure]:
    """Residual velocities over the impact speed, each with its curve."""
    if curves is None:
        return
    panels = []
    for row in curves["rows"]:
        speed = np.array(row["speed"])
        series = [
            Series("quantity", "simulation", tuple(row["speed"]), numbers(row["residual_velocity"]), connected=False)
        ]
        if row["a"]:
            constants = [row[name]["value"] for name in CONSTANTS]
            x = np.linspace(min(constants[2], speed.min()), speed.max(), CURVE)
            y = recht_ipson(x, *constants)
            series.append(Series("trend", "Recht and Ipson", tuple(x.tolist()), numbers(y)))
        panels.append(Panel(title_of(dataset, row["at"]), row["at"], tuple(series)))
    yield Figure(
        name="residual_velocity_curve",
        title="Residual velocity against speed",
        caption=f"Residual velocities of all runs; curve: {EQUATION}, fitted to those that perforate.",
        x=Scale(SPEED, "speed", "m s-1"),
        y=Scale(RESIDUAL, "residual velocity", "m s-1"),
        panels=tuple(panels),
    )
