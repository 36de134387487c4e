"""The measured shots that a point of a sweep repeats: those that the sweep brought, and those that ship."""

import math
from collections.abc import Iterable, Iterator, Sequence
from contextlib import suppress
from dataclasses import fields
from functools import cache

import numpy as np
import xarray as xr

from studies import materials, observations
from studies.cubes import variables as cubes
from studies.cubes.points import Place, axes_of, by_run, error_bars, places_of
from studies.cubes.reading import finite
from studies.cubes.variable import variable_name
from studies.observations import UNKNOWN_ALLOY, Observation
from studies.quantities.findings import InvalidInput
from studies.reports.evidence import FIRST_HAND
from studies.reports.matched import interpolate
from studies.reports.records import Doubt, MeasuredShot, StatedShot
from studies.sweeps.reading import published_shots

NEAR = 0.10  # relative: a shot is like a point where no number that both state differs by more


def measured_shots(points: xr.Dataset, name: str, own: Iterable[StatedShot]) -> Iterator[MeasuredShot]:
    """The shots of a quantity that are like a point; each once. A shot that does not state an axis is like none."""
    unit = str(points[name].attrs["units"])
    shots = [shot for shot in own if shot.quantity == name]
    shots += [_of_table(shot, unit) for shot in _shipped(str(points.attrs["scenario"]), name)]
    columns = {key: by_run(points, key) for shot in shots for key in shot.at if key in points}
    needed = {axis for axis in axes_of(points) if axis in columns}
    barred = points.assign({cubes.UNCERTAINTY.named(name): error_bars(points, name)})
    places, seen = places_of(points), set()
    for shot in shots:
        told = (shot.value, shot.lower, shot.upper, *sorted(_rounded(shot.at)))
        near = _nearest(shot.at, columns) if needed <= shot.at.keys() else None
        if near is None or told in seen:
            continue
        seen.add(told)
        number, doubts = near
        if shot.confidence not in FIRST_HAND:
            doubts = (*doubts, Doubt.SECOND_HAND)
        place = places[number]
        # At its own values of the axes that are numbers.
        own_place = {key: value for key, value in shot.at.items() if key in place and isinstance(value, float)}
        value, bar, *_ = interpolate(barred, name, {**place, **own_place})
        stated = {field.name: getattr(shot, field.name) for field in fields(StatedShot)}
        yield MeasuredShot(**stated, point=place, doubts=doubts, simulation=finite(value), simulation_bar=finite(bar))


def _of_table(shot: Observation, unit: str) -> StatedShot:
    """A shot that ships, with texts and numbers of its parameters by the names of the cube."""
    at = {
        variable_name(key): value if isinstance(value, str) else float(value)
        for key, value in shot.parameters.items()
        if isinstance(value, str | float)
    }
    bounds = shot.bounds or (None, None)
    return StatedShot(shot.quantity, unit, at, shot.value, shot.uncertainty, *bounds, shot.source, shot.confidence)


def _rounded(at: Place) -> Iterator[tuple[str, float]]:
    """The numbers that a shot states, as exactly as a table prints them: the same shot may come from two tables."""
    return ((key, float(f"{value:.6g}")) for key, value in at.items() if isinstance(value, float))


@cache
def _shipped(scenario: str, quantity: str) -> Sequence[Observation]:
    """The shots that ship and have a quantity of a scenario; none of a scenario of another version."""
    found: list[Observation] = []
    for table in observations.names():
        if quantity in observations.text(table):
            with suppress(InvalidInput):
                found += [shot for shot in published_shots(table, scenario) if shot.quantity == quantity]
    return found


def _nearest(at: Place, columns: dict[str, np.ndarray]) -> tuple[int, tuple[Doubt, ...]] | None:
    """The number of the point that is nearest to a shot, with the doubts about its metals; None where none is near."""
    stated = [key for key in at if key in columns]
    if not any(isinstance(at[key], float) for key in stated):
        return None
    distance = np.zeros(len(columns[stated[0]]))
    doubts = False
    for key in stated:
        wanted, column = at[key], columns[key]
        if isinstance(wanted, str):
            kinds = [_likeness(wanted, str(own)) for own in column]
            distance += [0.0 if kind else math.inf for kind in kinds]
            doubts |= "metal" in kinds
        else:
            off = np.abs(np.asarray(column, float) - wanted)
            scale = NEAR * abs(wanted)
            distance += np.where(np.isnan(off), 0.0, np.where(off <= scale, off, np.inf) / (scale or 1.0))
    number = int(np.argmin(distance))
    return (number, (Doubt.UNKNOWN_ALLOY,) * doubts) if math.isfinite(distance[number]) else None


def _likeness(wanted: str, own: str) -> str:
    """How far a word of a shot is that of a run: "same", "metal" of an alloy that its source does not name, or ""."""
    if wanted == own:
        return "same"
    with suppress(InvalidInput):
        mine = materials.load(own)
        if wanted.endswith(UNKNOWN_ALLOY):
            return "metal" * (mine.family == wanted.removesuffix(UNKNOWN_ALLOY))
        return "same" * (mine.alloy == materials.load(wanted).alloy)
    return ""
