"""Outcomes of shots with what leaves them open, and the limits of a search for one."""

import math
from collections.abc import Iterator
from typing import Any

import numpy as np
import xarray as xr

from studies.cubes import limits, variables
from studies.cubes.points import axes_of, main_quantities, places_of, plain, simulated_values
from studies.cubes.reading import finite, flag_words
from studies.cubes.variable import BETWEEN_OUTCOMES, OUTCOMES
from studies.observations.shields.drawn import beside_held, briefly_beside_held
from studies.observations.shields.judged import Share
from studies.quantities.measured import doubts_of
from studies.reports.limits.shield import WALL, failures_found_at

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
            "found": _briefly_found(points, name),
        }
        for name in main_quantities(points)
        if OUTCOMES in points[name].attrs
    ]


def _founds(points: xr.Dataset, name: str) -> list[Share | None] | None:
    """Of the perforated walls those that simulations like each point perforate; None of another outcome."""
    return failures_found_at(points) if name == WALL and "failure" in points else None


def _briefly_found(points: xr.Dataset, name: str) -> str:
    """What stands beside walls that hold in a headline; empty without any."""
    founds = _founds(points, name)
    if founds is None:
        return ""
    held = simulated_values(points, name).ravel() == 0.0
    return " ".join(dict.fromkeys(briefly_beside_held(founds[place]) for place in np.flatnonzero(held)))


def _shots(points: xr.Dataset, name: str) -> Iterator[dict[str, Any]]:
    """A row for each shot that has a run which ended."""
    words = points[name].attrs[OUTCOMES].split(BETWEEN_OUTCOMES)
    shots: dict[tuple[Any, ...], list[tuple[str, float | None, str]]] = {}
    besides: dict[tuple[Any, ...], dict[str, None]] = {}
    places = places_of(points)
    founds = _founds(points, name)
    for number, (place, (outcome, reason)) in enumerate(zip(places, _outcomes(points, name), strict=True)):
        shot = tuple((axis, value) for axis, value in place.items() if axis not in OF_MODEL)
        model = ", ".join(f"{axis.replace('_', ' ')} {value}" for axis, value in place.items() if axis in OF_MODEL)
        if reason:
            shots.setdefault(shot, []).append((model, outcome, reason))
            besides.setdefault(shot, {}).update({beside_held(founds[number]): None} if founds else {})
    for shot, computed in shots.items():
        said = {outcome for _, outcome, _ in computed}
        reasons = [": ".join(filter(None, (model, reason))) for model, outcome, reason in computed if outcome is None]
        if len(said) == 2 and not reasons:
            reasons = [f"{words[int(outcome)]} with {model}" for model, outcome, _ in computed if outcome is not None]
        agreed = computed[0][1] if len(said) == 1 else None
        why = reasons or [
            *dict.fromkeys(reason for _, _, reason in computed),
            *(besides[shot] if agreed == 0.0 else ()),
        ]
        yield {"at": dict(shot), "outcome": agreed, "reason": "; ".join(why)}


def _outcomes(points: xr.Dataset, name: str) -> Iterator[tuple[float | None, str]]:
    """The outcome of each point and why it is known or open; no reason where no run succeeded."""
    words = points[name].attrs[OUTCOMES].split(BETWEEN_OUTCOMES)
    values, flags = simulated_values(points, name).ravel(), flag_words(variables.FLAGS.of(points, name))
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
    if not limits.LIMIT.is_in(dataset):
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
            "verdict": limits.VERDICTS[int(dataset.limit_verdict.values[place])].replace("_", " "),
            "reason": str(dataset.limit_reason.values[place]),
        }
        for place in range(dataset.sizes[limits.SEARCH])
    ]
    label = about["axis"].replace("_", " ")
    return {"axis": label, "of": about["limit_of"], "unit": about["units"], "rows": rows}
