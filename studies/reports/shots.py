"""The measured shots that a point of a sweep repeats: those that the sweep brought, and those that ship."""

import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
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
from studies.quantities.parameters import Value
from studies.reports.evidence import FIRST_HAND
from studies.reports.matched import MatchedObservation, interpolate
from studies.reports.records import Doubt, MeasuredShot
from studies.sweeps.reading import published_shots

NEAR = 0.10  # relative: a shot is like a point where no number that both state differs by more


@dataclass(frozen=True)
class _Shot:
    at: Place
    value: float | None
    uncertainty: float | None
    lower: float | None
    upper: float | None
    source: str
    confidence: str


def measured_shots(points: xr.Dataset, name: str, own: Iterable[MatchedObservation]) -> Iterator[MeasuredShot]:
    """The shots of a quantity that are like a point; each once. A shot that does not state an axis is like none."""
    shots = [
        *(
            _Shot(each.at, each.value, each.uncertainty, each.lower, each.upper, each.source, each.confidence)
            for each in own
            if each.quantity == name
        ),
        *(
            _Shot(
                _plain(each.parameters),
                each.value,
                each.uncertainty,
                *(each.bounds or (None, None)),
                each.source,
                each.confidence,
            )
            for each in _shipped(str(points.attrs["scenario"]), name)
        ),
    ]
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
        value, bar, *_ = interpolate(barred, name, {**places[number], **_numbers(shot.at, places[number])})
        yield MeasuredShot(
            quantity=name,
            unit=points[name].attrs["units"],
            at=shot.at,
            point=places[number],
            value=shot.value,
            uncertainty=shot.uncertainty,
            lower=shot.lower,
            upper=shot.upper,
            source=shot.source,
            doubts=doubts,
            simulation=finite(value),
            simulation_bar=finite(bar),
        )


def _rounded(at: Place) -> Iterator[tuple[str, float]]:
    """The numbers that a shot states, as exactly as a table prints them: the same shot may come from two tables."""
    return ((key, float(f"{value:.6g}")) for key, value in at.items() if isinstance(value, float))


def _numbers(at: Place, axes: Place) -> dict[str, float]:
    """What a shot states of the axes that are numbers."""
    return {key: value for key, value in at.items() if key in axes and isinstance(value, float)}


def _plain(parameters: Mapping[str, Value]) -> dict[str, float | str]:
    """Texts and numbers of a shot, by the names of the cube."""
    return {
        variable_name(key): value if isinstance(value, str) else float(value)
        for key, value in parameters.items()
        if isinstance(value, str | float)
    }


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
            kinds = [_likeness(wanted, str(each)) for each in column]
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
