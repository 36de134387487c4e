"""What judgements rest on: the values of a quantity with their bars, and the answers of laws, read from a cube."""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
import xarray as xr
from numpy.typing import ArrayLike

from studies.cubes import reading
from studies.cubes import variables as cubes
from studies.cubes.points import comparable, error_bars, places_of, simulated_or_nan, simulated_values
from studies.laws import RangeStatus
from studies.quantities.measured import flags_in_words
from studies.reports.records import StatedRange

# Parts of an error bar of which a report says whether they are known; a run states neither of the last two.
MESH, DEFINITION, MODEL = "mesh error", "definition", "model"
# Confidences of shots that judge by themselves; others are doubtful.
FIRST_HAND = ("", "read", "verified", "user")
NO_SIZE = "has the value zero, to which nothing is relative"
UNSTATED = "a limit of its source is not met"
# Variables of the answers of laws beside runs and beside observed shots.
BESIDE_RUNS = (*cubes.OF_ANSWERS, cubes.LAW_TITLE, cubes.LAW_CONFIDENCE)
BESIDE_SHOTS = (*cubes.OF_ANSWERS_AT_OBSERVATIONS, cubes.OBSERVED_LAW_TITLE, cubes.OBSERVED_LAW_CONFIDENCE)
STATUSES = tuple(RangeStatus)


class Evidence:
    """A quantity of a cube of points, flattened."""

    def __init__(self, points: xr.Dataset, name: str):
        self.points, self.name = points, name
        self.places = places_of(points)
        self.values = comparable(points, name).values.ravel()
        self.flags = reading.doubts_at(points, name)
        self._states = cubes.RUN_STATE.of(points).values.ravel()
        self._assessed = {
            DEFINITION: simulated_or_nan(points, f"{name}_definition_part"),
            MODEL: simulated_or_nan(points, cubes.MODEL_PART.named(name)),
        }
        self._numerical = simulated_values(points, cubes.UNCERTAINTY.named(name)).ravel()

    def bars(self, *spread: np.ndarray) -> np.ndarray:
        """The joint uncertainty, (points,), of the parts there are, whether they are a test or not; NaN without any.

        Parts: numerical, definition, model and, beside a law, the scatter that its source publishes; in the unit of
        the quantity.
        """
        parts = [self._numerical, *self._assessed.values(), *spread]
        total = np.sqrt(sum(np.nan_to_num(part) ** 2 for part in parts))
        return np.where(np.isnan(parts).all(axis=0), np.nan, total)

    def tests(self) -> np.ndarray:
        """Whether error bars include the mesh error, bool (points,): no other bar is a test."""
        return np.isfinite(error_bars(self.points, self.name).values.ravel())

    def parts(self) -> dict[str, int]:
        """The number of points with a value that have each part."""
        has = {MESH: self.tests(), **{part: np.isfinite(sizes) for part, sizes in self._assessed.items()}}
        return {part: int((known & np.isfinite(self.values)).sum()) for part, known in has.items()}

    def distances(self) -> np.ndarray:
        """Factors (points,) by which points with a value are outside of where their model part was measured, or 1."""
        if not cubes.MODEL_DISTANCE.is_in(self.points, self.name):
            return np.ones(len(self.places))
        factors = cubes.MODEL_DISTANCE.of(self.points, self.name).values.ravel()
        return np.where(np.isfinite(self.values) & np.isfinite(factors), factors, 1.0)

    def other_alloys(self) -> tuple[str, ...]:
        """Alloys for which the model part of a point was computed in place of its own."""
        if not cubes.MODEL_ALLOY.is_in(self.points, self.name):
            return ()
        return tuple(dict.fromkeys(filter(None, map(str, cubes.MODEL_ALLOY.of(self.points, self.name).values.ravel()))))

    def moved(self) -> list[list[tuple[str, float]]]:
        """For each point failures that count but its own, with the signed share by which they move its value."""
        moved: list[list[tuple[str, float]]] = [[] for _ in self.places]
        for sign, (size, failure) in zip((-1.0, 1.0), cubes.MODEL_SIDES, strict=True):
            if size.is_in(self.points, self.name):
                shares = sign * simulated_or_nan(self.points, size.named(self.name)) / self.values
                names = failure.of(self.points, self.name).values.ravel()
                for known, name, share in zip(moved, names, shares, strict=True):
                    if name and math.isfinite(share):
                        known.append((str(name), float(share)))
        return moved

    def why_unjudged(self, number: int) -> str:
        """Why the value of a point judges no law; empty where it does."""
        if self.flags[number]:
            return f"flagged as {', '.join(flags_in_words(self.flags[number]))}"
        value = self.values[number]
        if math.isfinite(value):
            return "" if value else NO_SIZE
        state = cubes.STATES[self._states[number]]
        return "the run measured no value" if state == "succeeded" else f"state of its run: {state.replace('_', ' ')}"

    def unflagged(self) -> tuple[xr.Dataset, xr.Dataset]:
        """The points with the joint uncertainty as bars and without flagged values; the same with bars that test."""
        bars = cubes.UNCERTAINTY.named(self.name)
        values = self.points[self.name].where(self._shaped([not flags for flags in self.flags]))
        usable = self.points.assign({self.name: values, bars: self._shaped(self.bars())})
        return usable, usable.assign({bars: usable[bars].where(self._shaped(self.tests()))})

    def _shaped(self, values: ArrayLike) -> xr.DataArray:
        """Values of each point with the dimensions of the points."""
        shape = self.points.run_state
        return xr.DataArray(np.reshape(values, shape.shape), dims=shape.dims)


@dataclass(frozen=True)
class LawAnswers:
    """The answers of one law with one of its variants, at points or for observed shots."""

    label: str
    title: str
    answers: np.ndarray  # (n,) SI; NaN where it has none
    status: Sequence[RangeStatus]  # how each answer stands to the range
    outside: Sequence[str]  # why an answer is outside the range, or there is none; empty inside
    scatter: float  # published, relative; NaN where none is
    confidence: str  # in the equation
    range: StatedRange


def answers_of(points: xr.Dataset, quantity: str, shots: Sequence[int] | None = None) -> Iterator[LawAnswers]:
    """Each law of a quantity with its answers at the points, or for some of the observed shots."""
    answers, inside, status, reasons, titles, confidences = BESIDE_RUNS if shots is None else BESIDE_SHOTS
    if not answers.is_in(points, quantity):
        return
    some = {} if shots is None else {"observation": list(shots)}
    found, ranged, why = (variable.of(points, quantity).isel(some) for variable in (answers, inside, reasons))
    codes = status.of(points, quantity).isel(some)
    labels = [str(label) for label in cubes.LAW_LABEL.of(points, quantity).values]
    scatters = dict(zip(labels, map(float, cubes.LAW_SCATTER.of(points, quantity).values), strict=True))
    ranges = dict(zip(labels, _ranges(points, quantity), strict=True))
    known_titles = titles.of(points, quantity).values
    known = [str(text).removeprefix(cubes.EQUATION) for text in confidences.of(points, quantity).values]
    for number, label in enumerate(map(str, found[str(found.dims[-1])].values)):
        values, is_inside = found.values[..., number].ravel(), ranged.values[..., number].ravel() == 1
        texts, met = why.values[..., number].ravel(), is_inside & np.isfinite(values)
        outside = [str(text) or ("" if is_met else UNSTATED) for text, is_met in zip(texts, met, strict=True)]
        yield LawAnswers(
            label,
            str(known_titles[number]),
            values,
            [STATUSES[code] for code in codes.values[..., number].ravel()],
            outside,
            scatters.get(label, math.nan),
            known[number],
            ranges[label],
        )


def _ranges(points: xr.Dataset, quantity: str) -> Iterator[StatedRange]:
    """The range that each law of a quantity states."""
    bounds = [bound.of(points, quantity).values for bound in (*cubes.LAW_SPEEDS, *cubes.LAW_THICKNESS_RATIOS)]
    for is_stated, *ends in zip(cubes.LAW_HAS_RANGE.of(points, quantity).values, *bounds, strict=True):
        slowest, fastest, thinnest, thickest = (reading.finite(float(end)) for end in ends)
        yield StatedRange(bool(is_stated), (slowest, fastest), (thinnest, thickest))
