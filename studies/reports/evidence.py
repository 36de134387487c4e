"""The evidence behind a judgement: each law and its reference point by point, read from a cube of points."""

import math
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np
import xarray as xr
from numpy.typing import ArrayLike

from studies.cubes import reading
from studies.cubes import variables as cubes
from studies.cubes.points import Place, axes_of, comparable, error_bars, main_quantities, places_of, simulated_values
from studies.laws import CAVEATS, DRAWN_ONLY, RangeStatus
from studies.quantities.measured import flags_in_words
from studies.reports.matched import MatchedObservation, Where, interpolate
from studies.reports.records import Outcome, Reference

JudgedState = Literal["judged", "outside", "unjudged"]


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
JUDGED = (RangeStatus.INSIDE, RangeStatus.FITTED)  # where what is against a judgement is not the range of the law
# Why a point without a value judges nothing, by the state of its run.
UNJUDGED_STATES = {
    "succeeded": "the run measured no value",
    "failed": "the run failed",
    "crashed": "the run crashed",
    "timed_out": "the run timed out",
    "out_of_memory": "the run ran out of memory",
    "cancelled": "the run was cancelled",
    "running": "the run has not ended",
    "pending": "the run has not begun",
    "missing": "the run left no result",
    "other": "the run did not succeed",
}


@dataclass(frozen=True)
class AxisOfSweep:
    """The name of an axis of a sweep, and its unit."""

    name: str
    unit: str | None  # SI; None for text


@dataclass(frozen=True)
class Moved:
    """What another failure than that of the run makes of a simulated value."""

    failure: str
    share: float  # signed, of the value


@dataclass(frozen=True)
class Hanging:
    """A failure that decides whether a law agrees: whether the difference is inside the joint uncertainty."""

    failure: str
    agrees: bool  # with it, and not without it; else the other way round


@dataclass(frozen=True)
class JudgedPoint:
    """A law and its reference at one place."""

    at: Place
    law: float  # NaN where the law has no answer
    reference: float  # NaN where there is nothing to compare with
    uncertainty: float = math.nan  # of both together, over the reference; NaN where no part is known
    numerical: float = math.nan  # the same without the model part; NaN where there is none
    # Whether the uncertainty includes what makes it a test: the mesh error, or the error of the observation.
    tests: bool = False
    status: RangeStatus = RangeStatus.INSIDE  # how the law's answer stands to its range
    outside: str = ""  # why it is outside the range of the law, or the law has no answer
    unjudged: str = ""  # why nothing is judged here: no value, or a flag
    doubtful: bool = False  # whether the reference is a shot that nobody here read in its source
    moved: tuple[Moved, ...] = ()  # the reference, farthest to each side, by failures that count; in no uncertainty

    @property
    def residual(self) -> float:
        """Law minus reference, over the reference."""
        return self.law / self.reference - 1.0

    @property
    def bar(self) -> float:
        """The joint uncertainty over the reference; 0 where no part of it is known."""
        return 0.0 if math.isnan(self.uncertainty) else self.uncertainty

    @property
    def state(self) -> JudgedState:
        if self.status not in JUDGED:
            return "outside"
        return "unjudged" if self.unjudged else "judged"

    @property
    def outcome(self) -> Outcome:
        """How the law does here; nothing is said without an error bar that is a test."""
        if self.state != "judged" or not self.tests:
            return Outcome.NOT_COMPARABLE
        if abs(self.residual) <= self.bar:
            return Outcome.WITHIN
        return Outcome.LOW if self.residual < 0.0 else Outcome.HIGH

    @property
    def hangs_on(self) -> tuple[Hanging, ...]:
        """The failures that alone bring the law into agreement, or separate it: what lies between is as possible."""
        if self.state != "judged" or not self.tests:
            return ()
        agrees = abs(self.residual) <= self.bar
        if agrees:
            deciding = [each for each in self.moved if abs(self.residual - each.share) > self.bar]
        else:
            deciding = [
                each
                for each in self.moved
                if min(0.0, each.share) - self.bar <= self.residual <= max(0.0, each.share) + self.bar
            ]
        return tuple(Hanging(each.failure, not agrees) for each in deciding)


@dataclass(frozen=True)
class Subject:
    """A law (or the simulation) against one reference."""

    name: str  # label of the law, or "simulation"
    title: str
    reference: Reference
    points: tuple[JudgedPoint, ...]
    confidence: str = ""  # in the equation of a law
    has_range: bool | None = None  # whether the source of a law states one; None: unknown

    @property
    def full_title(self) -> str:
        """The title with the variant."""
        return full_title(self.name, self.title)

    @property
    def caveat(self) -> str:
        """What was not checked of the law, by its confidence."""
        return CAVEATS.get(self.confidence, "")

    @property
    def drawn_only(self) -> str:
        """Why the law enters no verdict; empty where it does."""
        return DRAWN_ONLY.get(self.confidence, "")


def full_title(label: str, title: str) -> str:
    """The title of a law with its variant."""
    variant = label.partition("/")[2]
    return f"{title} ({variant})" if variant else title


@dataclass(frozen=True)
class Evidence:
    """Everything that the verdict on one quantity rests on."""

    quantity: str
    subjects: tuple[Subject, ...]  # against observations first
    parts: Mapping[str, int]  # of error bars, each with the number of points that have it; none without a subject
    points: int  # points with a value
    flagged: tuple[tuple[str, ...], ...]  # the flags of each point and of its run
    has_scatter: bool  # whether the published scatter of any law is known
    shots: Mapping[str, int]  # observed shots by how well their values are known
    # Points outside of the speeds and t/d at which their model part was measured, and the largest factor of it.
    distant: int = 0
    distance: float = 1.0
    alloys: tuple[str, ...] = ()  # for which the model part was computed, where they are not those of the sweep

    @property
    def has_model(self) -> bool:
        """Whether the model part is assessed for each point with a value."""
        return 0 < self.points == self.parts.get(MODEL, 0) and not self.distant and not self.alloys


def evidence_of(points: xr.Dataset, observations: Sequence[MatchedObservation]) -> Iterator[Evidence]:
    """The evidence on each main quantity of a cube of points."""
    for name in main_quantities(points):
        quantity = _Quantity(points, name)
        shots = [shot for shot in observations if shot.quantity == name]
        subjects = (*quantity.against_shots(shots), *quantity.against_simulation())
        yield Evidence(
            quantity=name,
            subjects=subjects,
            # Nobody reads the parts where there is nothing to judge: a fifth of the time of a report of clouds.
            parts=quantity.parts() if subjects else {},
            points=int(np.isfinite(quantity.values).sum()),
            flagged=tuple(quantity.flags),
            has_scatter=any(math.isfinite(law.scatter) for law in answers_of(points, name)),
            shots=Counter(shot.confidence for shot in shots),
            distant=int((quantity.distances() > 1.0).sum()),
            distance=float(quantity.distances().max(initial=1.0)),
            alloys=quantity.other_alloys(),
        )


def axes_in(points: xr.Dataset) -> list[AxisOfSweep]:
    """The axes of a cube of points."""
    return [AxisOfSweep(name, points[name].attrs.get("units")) for name in axes_of(points)]


def with_models(points: xr.Dataset, name: str) -> np.ndarray:
    """Error bars of a quantity with all parts that are assessed, models included, (points,); NaN without any."""
    return _Quantity(points, name).bars()


class _Quantity:
    """A quantity of a cube of points, flattened."""

    def __init__(self, points: xr.Dataset, name: str):
        self.points, self.name = points, name
        self.places = places_of(points)
        self.states = cubes.RUN_STATE.of(points).values.ravel()
        self.assessed = {
            DEFINITION: self._stored(f"{name}_definition_part"),
            MODEL: self._stored(cubes.MODEL_PART.named(name)),
        }
        self.numerical = simulated_values(points, cubes.UNCERTAINTY.named(name)).ravel()
        self.values = comparable(points, name).values.ravel()
        self.flags = reading.doubts_at(points, name)

    # ---- error bars: standard uncertainties in the quantity's unit ----

    def bars(self, *spread: np.ndarray, without: str = "") -> np.ndarray:
        """The joint uncertainty, (points,), of the parts there are, whether they are a test or not; NaN without any.

        Parts: numerical, definition, model and, beside a law, the scatter that its source publishes; but the one that
        is to be left out.
        """
        parts = [self.numerical, *(sizes for part, sizes in self.assessed.items() if part != without), *spread]
        total = np.sqrt(sum(np.nan_to_num(part) ** 2 for part in parts))
        return np.where(np.isnan(parts).all(axis=0), np.nan, total)

    def tests(self) -> np.ndarray:
        """Whether error bars include the mesh error, bool (points,): no other bar is a test."""
        return np.isfinite(error_bars(self.points, self.name).values.ravel())

    def _stored(self, name: str) -> np.ndarray:
        """A part that the cube holds, where the run succeeded; NaN where it does not hold it."""
        if name not in self.points:
            return np.full(len(self.places), np.nan)
        return simulated_values(self.points, name).ravel()

    def parts(self) -> dict[str, int]:
        """The number of points with a value that have each part."""
        has = {MESH: self.tests(), **{part: np.isfinite(sizes) for part, sizes in self.assessed.items()}}
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

    def moved(self) -> list[tuple[Moved, ...]]:
        """What failures that count make of each point, farthest to each side."""
        moved: list[tuple[Moved, ...]] = [()] * len(self.places)
        for sign, (size, failure) in zip((-1.0, 1.0), cubes.MODEL_SIDES, strict=True):
            if size.is_in(self.points, self.name):
                shares = sign * self._stored(size.named(self.name)) / self.values
                names = failure.of(self.points, self.name).values.ravel()
                moved = [
                    (*known, Moved(str(name), float(share))) if name and math.isfinite(share) else known
                    for known, name, share in zip(moved, names, shares, strict=True)
                ]
        return moved

    # ---- subjects ----

    def against_simulation(self) -> Iterator[Subject]:
        """Each law against the simulation."""
        tests, moved = self.tests(), self.moved()
        unjudged = [self._why_unjudged(number) for number in range(len(self.places))]
        for law in answers_of(self.points, self.name):
            spread = np.abs(law.answers) * law.scatter
            bars, numerical = self.bars(spread), self.bars(spread, without=MODEL)
            numerical = np.where(np.isnan(self.assessed[MODEL]), np.nan, numerical)
            points = [
                JudgedPoint(
                    place,
                    float(law.answers[number]),
                    float(self.values[number]),
                    _over(bars[number], self.values[number]),
                    _over(numerical[number], self.values[number]),
                    bool(tests[number]),
                    law.status[number],
                    law.outside[number],
                    unjudged[number],
                    moved=moved[number],
                )
                for number, place in enumerate(self.places)
            ]
            yield Subject(law.label, law.title, "simulation", tuple(points), law.confidence, law.has_range)

    def _why_unjudged(self, number: int) -> str:
        """Why the value of a point judges no law; empty where it does."""
        if self.flags[number]:
            return f"flagged as {', '.join(flags_in_words(self.flags[number]))}"
        value = self.values[number]
        if math.isfinite(value):
            return "" if value else NO_SIZE
        return UNJUDGED_STATES[cubes.STATES[self.states[number]]]

    def against_shots(self, shots: Sequence[MatchedObservation]) -> Iterator[Subject]:
        """The simulation and each law against the observed shots."""
        if not shots:
            return
        yield Subject("simulation", "simulation", "observation", tuple(map(self._simulated_shot, shots)))
        for law in answers_of(self.points, self.name, [shot.observation for shot in shots]):
            points = [
                JudgedPoint(
                    shot.at,
                    float(law.answers[number]),
                    shot.observed,
                    _over(math.hypot(shot.uncertainty or 0.0, _zero(law.scatter * law.answers[number])), shot.observed),
                    tests=shot.uncertainty is not None,
                    status=law.status[number],
                    outside="" if law.status[number] is RangeStatus.FITTED else law.outside[number],
                    unjudged=law.outside[number]
                    if law.status[number] is RangeStatus.FITTED
                    else ("" if shot.value else NO_SIZE),
                    doubtful=shot.confidence not in FIRST_HAND,
                )
                for number, shot in enumerate(shots)
            ]
            yield Subject(law.label, law.title, "observation", tuple(points), law.confidence, law.has_range)

    def _simulated_shot(self, shot: MatchedObservation) -> JudgedPoint:
        """The simulation at the parameters of a shot, by unflagged points alone."""
        name, bars = self.name, cubes.UNCERTAINTY.named(self.name)
        unflagged = self._shaped([not flags for flags in self.flags])
        usable = self.points.assign({name: self.points[name].where(unflagged), bars: self._shaped(self.bars())})
        value, bar, how, where = interpolate(usable, name, shot.at)
        meshed = usable.assign({bars: usable[bars].where(self._shaped(self.tests()))})
        known = math.isfinite(interpolate(meshed, name, shot.at).uncertainty)
        is_outside = where in (Where.ELSEWHERE, Where.BEYOND_AXES)
        away = how if math.isnan(value) else ""
        return JudgedPoint(
            shot.at,
            value,
            shot.observed,
            _over(math.hypot(_zero(bar), shot.uncertainty or 0.0), shot.observed),
            tests=known and shot.uncertainty is not None,
            status=RangeStatus.OUTSIDE_RANGE if is_outside else RangeStatus.INSIDE,
            outside=away if is_outside else "",
            unjudged=away or ("" if shot.value else NO_SIZE),
            doubtful=shot.confidence not in FIRST_HAND,
        )

    def _shaped(self, values: ArrayLike) -> xr.DataArray:
        """Values of each point with the dimensions of the points."""
        shape = self.points.run_state
        return xr.DataArray(np.reshape(values, shape.shape), dims=shape.dims)


@dataclass(frozen=True)
class LawAnswers:
    """The answers of one law with one of its variants, at points or for observed shots."""

    label: str
    title: str
    unit: str  # SI
    answers: np.ndarray  # (n,) NaN where it has none
    inside: np.ndarray  # (n,) bool, of its range
    status: Sequence[RangeStatus]  # how each answer stands to the range
    outside: Sequence[str]  # why an answer is outside the range, or there is none; empty inside
    scatter: float  # published, relative; NaN where none is
    confidence: str  # in the equation
    has_range: bool | None  # whether its source states one; None of a cube that does not know it


def answers_of(points: xr.Dataset, quantity: str, shots: Sequence[int] | None = None) -> Iterator[LawAnswers]:
    """Each law of a quantity with its answers at the points, or for some of the observed shots."""
    answers, inside, status, reasons, titles, confidences = BESIDE_RUNS if shots is None else BESIDE_SHOTS
    if not answers.is_in(points, quantity):
        return
    some = {} if shots is None else {"observation": list(shots)}
    found, ranged, why = (each.of(points, quantity).isel(some) for each in (answers, inside, reasons))
    codes = status.of(points, quantity).isel(some) if status.is_in(points, quantity) else None
    labels = [str(label) for label in cubes.LAW_LABEL.of(points, quantity).values]
    scatters = dict(zip(labels, map(float, cubes.LAW_SCATTER.of(points, quantity).values), strict=True))
    ranges: Mapping[str, bool] = {}
    if cubes.LAW_HAS_RANGE.is_in(points, quantity):
        ranges = dict(zip(labels, map(bool, cubes.LAW_HAS_RANGE.of(points, quantity).values), strict=True))
    known_titles, known = titles.of(points, quantity).values, reading.confidences_of(points, quantity, confidences)
    for number, label in enumerate(map(str, found[str(found.dims[-1])].values)):
        values, is_inside = found.values[..., number].ravel(), ranged.values[..., number].ravel() == 1
        texts, met = why.values[..., number].ravel(), is_inside & np.isfinite(values)
        outside = [str(text) or ("" if is_met else UNSTATED) for text, is_met in zip(texts, met, strict=True)]
        yield LawAnswers(
            label,
            str(known_titles[number]),
            found.attrs["units"],
            values,
            is_inside,
            [STATUSES[code] for code in codes.values[..., number].ravel()]
            if codes is not None
            else [_status_without_code(*each) for each in zip(values, outside, strict=True)],
            outside,
            scatters.get(label, math.nan),
            known[number],
            ranges.get(label),
        )


def _status_without_code(value: float, outside: str) -> RangeStatus:
    """The status in a cube that does not have it: another material and a fitted shot are not told apart."""
    if math.isnan(value):
        return RangeStatus.NO_ANSWER
    return RangeStatus.OUTSIDE_RANGE if outside else RangeStatus.INSIDE


def _zero(number: float) -> float:
    return 0.0 if math.isnan(number) else float(number)


def _over(size: float, value: float) -> float:
    return abs(float(size / value)) if value and math.isfinite(value) else math.nan
