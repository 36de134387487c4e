"""Outcomes with what leaves them open, the limits of a search, and residual velocities with their curve."""

import math
from collections.abc import Iterator
from typing import Any

import numpy as np
import xarray as xr

from studies.cubes import limits as cubes
from studies.cubes import variables
from studies.cubes.points import axes_of, main_quantities, places_of, plain, simulated
from studies.cubes.reading import finite, flag_words
from studies.cubes.variable import BETWEEN_OUTCOMES, OUTCOMES
from studies.laws.fitting.least_squares import NotIdentified, nonlinear
from studies.quantities.measured import doubts_of
from studies.reports.figures import Figure, Panel, Series, numbers
from studies.reports.view import Scale, title_of

RESIDUAL, SPEED, PERFORATED = "residual_velocity", "speed", "perforated"
CONSTANTS = ("a", "p", "v_bl")
EQUATION = "v_r = a (v^p - v_bl^p)^(1/p)"
SOURCE = "Recht and Ipson (1963), J. Appl. Mech. 30, 384 (recalled, not read)"
# Points with a residual velocity that a fit takes: one more than constants, for an interval.
LEAST = len(CONSTANTS) + 1
CURVE = 60  # points of a drawn curve
ENERGY = 2.0  # p where nothing is lost but the energy at the limit: the start of the iteration

# Axes that choose how a shot is computed, and not which: where their values disagree its outcome is open.
OF_MODEL = ("geometry", "method", "recipe", "failure", "tension", "shape", "contact", "rubble_friction")


def outcomes_of(points: xr.Dataset) -> list[dict[str, Any]]:
    """Outcomes of the points of a cube: what each shot says, 1 or 0, or None with the reason why it is open.

    Points that differ in the way in which they are computed are one shot.
    """
    return [
        {
            "quantity": name,
            "label": name.replace("_", " "),
            "words": points[name].attrs[OUTCOMES].split(BETWEEN_OUTCOMES),
            "rows": list(_shots(points, name)),
        }
        for name in main_quantities(points)
        if OUTCOMES in points[name].attrs
    ]


def _shots(points: xr.Dataset, name: str) -> Iterator[dict[str, Any]]:
    """A row for each shot that has a run which ended."""
    words = points[name].attrs[OUTCOMES].split(BETWEEN_OUTCOMES)
    shots: dict[tuple[Any, ...], list[tuple[str, float | None, str]]] = {}
    for place, (outcome, reason) in zip(places_of(points), _outcomes(points, name), strict=True):
        shot = tuple((axis, value) for axis, value in place.items() if axis not in OF_MODEL)
        model = ", ".join(f"{axis.replace('_', ' ')} {value}" for axis, value in place.items() if axis in OF_MODEL)
        if reason:
            shots.setdefault(shot, []).append((model, outcome, reason))
    for shot, computed in shots.items():
        said = {outcome for _, outcome, _ in computed}
        reasons = [": ".join(filter(None, (model, reason))) for model, outcome, reason in computed if outcome is None]
        if len(said) == 2 and not reasons:
            reasons = [f"{words[int(outcome)]} with {model}" for model, outcome, _ in computed if outcome is not None]
        agreed = computed[0][1] if len(said) == 1 else None
        reason = "; ".join(reasons) or "; ".join(dict.fromkeys(reason for _, _, reason in computed))
        yield {"at": dict(shot), "outcome": agreed, "reason": reason}


def _outcomes(points: xr.Dataset, name: str) -> Iterator[tuple[float | None, str]]:
    """The outcome of each point and why it is known or open; no reason where no run succeeded."""
    words = points[name].attrs[OUTCOMES].split(BETWEEN_OUTCOMES)
    values, flags = simulated(points, name).values.ravel(), flag_words(variables.FLAGS.of(points, name))
    refined = variables.VERDICT_REASON.is_in(points, name)
    reasons = variables.VERDICT_REASON.of(points, name).values.ravel() if refined else [""] * len(values)
    states = np.isfinite(values) | (variables.RUN_STATE.of(points).values.ravel() == 0)
    for value, flagged, reason, has_run in zip(values, flags, reasons, states, strict=True):
        if not has_run:
            yield None, ""
        elif refined:
            yield finite(float(value)), str(reason)
        elif math.isnan(value):
            yield None, " and ".join(flagged).replace("_", " ")
        elif doubts := doubts_of(value, flagged):
            yield None, f"{words[int(value)]}, but {doubts}"
        else:
            yield float(value), "one grid"


def limits_of(dataset: xr.Dataset) -> dict[str, Any] | None:
    """The limits of a search with their intervals; None without a search."""
    if not cubes.LIMIT.is_in(dataset):
        return None
    about = dataset.limit.attrs
    others = [name for name in axes_of(dataset) if f"limit_{name}" in dataset]
    rows = [
        {
            "at": {name: plain(dataset[f"limit_{name}"].values[place]) for name in others},
            "limit": finite(dataset.limit.values[place]),
            "lower": finite(dataset.limit_lower.values[place]),
            "upper": finite(dataset.limit_upper.values[place]),
            "runs": int(dataset.limit_runs.values[place]),
            "verdict": cubes.VERDICTS[int(dataset.limit_verdict.values[place])].replace("_", " "),
            "reason": str(dataset.limit_reason.values[place]),
        }
        for place in range(dataset.sizes[cubes.SEARCH])
    ]
    label = about["axis"].replace("_", " ")
    return {"axis": label, "of": about["limit_of"], "unit": about["units"], "rows": rows}


def residual_curves(dataset: xr.Dataset) -> dict[str, Any] | None:
    """Residual velocities by impact speed with the constants of their curve; None where none were measured."""
    if RESIDUAL not in dataset or SPEED not in axes_of(dataset):
        return None
    rows = list(_curves(dataset))
    return {"equation": EQUATION, "source": SOURCE, "rows": rows} if rows else None


def _curves(dataset: xr.Dataset) -> Iterator[dict[str, Any]]:
    """A row for each combination of the axes beside the speed that has a residual velocity."""
    values = simulated(dataset, RESIDUAL).values.ravel()
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
