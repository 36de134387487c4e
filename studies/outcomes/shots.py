"""Computes the section of outcomes: what each shot says, with what leaves it open."""

import math
from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import groupby
from operator import itemgetter

import numpy as np
import xarray as xr

from studies.cubes import variables
from studies.cubes.points import Place, axes_of, main_quantities, places_of, simulated_values
from studies.cubes.reading import flag_words
from studies.cubes.variable import BETWEEN_OUTCOMES, OUTCOMES
from studies.outcomes.found import Share, found_at
from studies.outcomes.section import ComputedWay, Outcomes, QuantityOutcomes, ShotOutcome
from studies.quantities.measured import doubting_flags
from studies.reports.section import Part, Source
from studies.reports.wording import text_template, worded

# Axes that choose how a shot is computed, and not which: where their values disagree its outcome is open.
OF_MODEL = (
    *("geometry", "method", "recipe", "failure", "tension", "thermal_softening", "pieces_seed", "shape", "contact"),
    "rubble_friction",
)
MOST_STRETCHES = 4  # of an axis with one outcome each, that a headline lists


def outcomes_part(source: Source) -> Part | None:
    """The section; None where no run has an outcome."""
    quantities = tuple(told for told in outcomes_of(source.points) if told.shots)
    if not quantities:
        return None
    units = {name: source.points[name].attrs.get("units") for name in axes_of(source.points)}
    is_fixed = "speed" in source.dataset and not source.dataset.speed.dims
    fixed = float(source.dataset.speed) if is_fixed else None
    return Part(Outcomes(quantities), opening=headline(quantities[0], units, fixed))


def outcomes_of(points: xr.Dataset) -> list[QuantityOutcomes]:
    """Outcomes of the points of a cube. Points that differ in the way in which they are computed are one shot."""
    return [
        QuantityOutcomes(name, (no, yes), found_at(points, name) is not None, tuple(_shots(points, name)))
        for name in main_quantities(points)
        if OUTCOMES in points[name].attrs
        for no, yes in [points[name].attrs[OUTCOMES].split(BETWEEN_OUTCOMES)]
    ]


def _shots(points: xr.Dataset, name: str) -> Iterator[ShotOutcome]:
    """A row for each shot that has a run which ended."""
    shots: dict[tuple[tuple[str, float | str], ...], list[ComputedWay]] = {}
    for place, computed in zip(places_of(points), _computed(points, name), strict=True):
        if computed:
            shot = tuple((axis, value) for axis, value in place.items() if axis not in OF_MODEL)
            shots.setdefault(shot, []).append(computed)
    for shot, ways in shots.items():
        said = {way.outcome for way in ways}
        yield ShotOutcome(dict(shot), ways[0].outcome if len(said) == 1 else None, tuple(ways))


def _computed(points: xr.Dataset, name: str) -> Iterator[ComputedWay | None]:
    """What each point says; None where no run succeeded, or it measured nothing without a flag."""
    values, flags = simulated_values(points, name).ravel(), flag_words(variables.FLAGS.of(points, name))
    refined = variables.VERDICT_REASON.is_in(points, name)
    grids = variables.VERDICT_REASON.of(points, name).values.ravel() if refined else [""] * len(values)
    ended = np.isfinite(values) | (variables.RUN_STATE.of(points).values.ravel() == 0)
    founds = found_at(points, name) or [None] * len(values)
    columns = zip(places_of(points), values, flags, grids, ended, founds, strict=True)
    for place, value, flagged, told, has_run, found in columns:
        says = None if math.isnan(value) else bool(value > 0.5)
        # Several grids have left it open where their finest says so.
        doubting = () if refined else flagged if says is None else doubting_flags(value, flagged)
        model: Place = {axis: value for axis, value in place.items() if axis in OF_MODEL}
        computed = ComputedWay(model, None if doubting else says, says, doubting, str(told), found)
        yield computed if has_run and (says is not None or flagged or told) else None


# ---- what a report opens with --------------------------------------------------------------------


@dataclass(frozen=True)
class OutcomeStretch:
    """Shots that follow one another along the axis with one outcome."""

    outcome: bool | None
    ends: tuple[float, float]


@dataclass(frozen=True)
class OutcomesOpening:
    """What is said of an outcome."""

    of: QuantityOutcomes
    speed: float | None  # m/s, that all shots share
    axis: str  # the one that varies, with numbers; empty where there is none
    unit: str
    stretches: tuple[OutcomeStretch, ...]  # along the axis; none where they are too many
    shots: int
    counts: tuple[tuple[bool | None, int], ...]  # of shots with each outcome
    found: tuple[Share | None, ...]  # beside those that hold


def headline(outcomes: QuantityOutcomes, units: dict[str, str | None], speed: float | None) -> str:
    """An outcome over the shots in words; ``units`` are those of the axes, ``speed`` the one that all shots share."""
    shots = outcomes.shots
    varied = [name for name in units if len({shot.at.get(name) for shot in shots}) > 1]
    axis = varied[0] if len(varied) == 1 and units[varied[0]] else ""
    counts = Counter(shot.outcome for shot in shots)
    held = [way.found for shot in shots if shot.outcome is False for way in shot.computed]
    opening = OutcomesOpening(
        of=outcomes,
        speed=speed,
        axis=axis,
        unit=units.get(axis) or "1",
        stretches=_stretches(shots, axis) if axis else (),
        shots=len(shots),
        counts=tuple((outcome, counts[outcome]) for outcome in (False, True, None) if counts[outcome]),
        found=tuple(dict.fromkeys(held)) if outcomes.is_wall else (),
    )
    return worded(text_template("studies.outcomes:headline.txt"), opening=opening)


def _stretches(shots: Sequence[ShotOutcome], axis: str) -> tuple[OutcomeStretch, ...]:
    ordered = sorted(((float(shot.at[axis]), shot.outcome) for shot in shots), key=itemgetter(0))
    groups = [(outcome, [at for at, _ in several]) for outcome, several in groupby(ordered, key=itemgetter(1))]
    if len(groups) > MOST_STRETCHES:
        return ()
    return tuple(OutcomeStretch(outcome, (along[0], along[-1])) for outcome, along in groups)
