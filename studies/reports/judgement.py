"""How a law does beside what it is compared with: a record with numbers for each law of each quantity.

Made in one place, from the evidence of a cube; templates put it into words.
"""

import math
from collections import Counter
from collections.abc import Iterable, Iterator, Sequence

import numpy as np
import xarray as xr

from studies.cubes.points import Place
from studies.cubes.reading import finite
from studies.laws import CAVEATS, DRAWN_ONLY, RangeStatus
from studies.reports.evidence import DEFINITION, FIRST_HAND, MESH, MODEL, NO_SIZE, Evidence, LawAnswers, answers_of
from studies.reports.matched import interpolate
from studies.reports.records import (
    IN_RANGE,
    Code,
    Judgement,
    MatchedObservation,
    Outcome,
    PointJudgement,
    Reason,
    Reference,
    Unchecked,
    Where,
)

SIMULATION = "simulation"  # the subject that is no law


def judgements_of(
    points: xr.Dataset, name: str, shots: Sequence[MatchedObservation] = ()
) -> tuple[tuple[Judgement, ...], tuple[Unchecked, ...]]:
    """Each law of a quantity, and the simulation, beside shots first, then by distance; and what was not checked."""
    evidence, laws = Evidence(points, name), list(answers_of(points, name))
    names = short_names({law.label: full_title(law.label, law.title) for law in laws})
    found = []
    if shots:
        found.append(_judged(name, SIMULATION, "observation", [_simulated_shot(evidence, shot) for shot in shots]))
        for law in answers_of(points, name, [shot.observation for shot in shots]):
            found.append(_judged(name, names[law.label], "observation", _beside_shots(law, shots), law))
    found += [_judged(name, names[law.label], "simulation", _beside_points(evidence, law), law) for law in laws]
    if not found:
        return (), ()
    compared = {law.law for law in found if law.compared}
    recalled = [law.title for law in laws if CAVEATS.get(law.confidence) and law.label in compared]
    has_scatter = any(math.isfinite(law.scatter) for law in laws)
    unchecked = tuple(_unchecked(evidence, shots, has_scatter, dict.fromkeys(recalled)))
    return tuple(sorted(found, key=_rank)), unchecked


def _rank(law: Judgement) -> tuple[bool, bool, bool, float]:
    """Nearest first; behind those that are compared those that are not, and those that are drawn alone."""
    return law.reference != "observation", bool(law.drawn_only), not law.compared, law.worst


def nearest(judgements: Sequence[Judgement], reference: Reference) -> list[Judgement]:
    """The laws that may stand in a headline, nearest first: first those that are compared at half of the points.

    Where flags keep every value from being compared these are the laws beside the flagged values.
    """
    mine = [law for law in judgements if law.reference == reference and law.law != SIMULATION]
    mine = [law for law in mine if not law.drawn_only and law.low is not None]
    some = [law for law in mine if law.compared]
    mine = some or [law for law in mine if law.reason is Reason.FLAGGED]
    most = max((law.compared for law in mine), default=0)
    return sorted(mine, key=lambda law: (2 * law.compared < most, law.worst))


# ---- point by point ------------------------------------------------------------------------------


def _beside_points(evidence: Evidence, law: LawAnswers) -> Iterator[PointJudgement]:
    """A law beside each point of the simulation."""
    tests, moved, bars = evidence.tests(), evidence.moved(), evidence.bars(np.abs(law.answers) * law.scatter)
    for number, place in enumerate(evidence.places):
        yield _point(
            place,
            law.answers[number],
            evidence.values[number],
            bars[number],
            tests=bool(tests[number]),
            status=law.status[number],
            outside=law.outside[number],
            unjudged=evidence.why_unjudged(number),
            moved=moved[number],
        )


def _beside_shots(law: LawAnswers, shots: Sequence[MatchedObservation]) -> Iterator[PointJudgement]:
    """A law beside each observed shot."""
    for number, shot in enumerate(shots):
        status, outside = law.status[number], law.outside[number]
        is_fitted = status is RangeStatus.FITTED
        yield _point(
            shot.at,
            law.answers[number],
            shot.value,
            math.hypot(shot.uncertainty or 0.0, _zero(law.scatter * law.answers[number])),
            tests=shot.uncertainty is not None,
            status=status,
            outside="" if is_fitted else outside,
            unjudged=outside if is_fitted else "" if shot.value else NO_SIZE,
        )


def _simulated_shot(evidence: Evidence, shot: MatchedObservation) -> PointJudgement:
    """The simulation at the parameters of a shot, by unflagged points alone."""
    usable, meshed = evidence.unflagged()
    value, bar, how, where = interpolate(usable, evidence.name, shot.at)
    known = math.isfinite(interpolate(meshed, evidence.name, shot.at).uncertainty)
    is_outside = where in (Where.ELSEWHERE, Where.BEYOND_AXES)
    away = how if math.isnan(value) else ""
    return _point(
        shot.at,
        value,
        shot.value,
        math.hypot(_zero(bar), shot.uncertainty or 0.0),
        tests=known and shot.uncertainty is not None,
        status=RangeStatus.OUTSIDE_RANGE if is_outside else RangeStatus.INSIDE,
        outside=away if is_outside else "",
        unjudged=away or ("" if shot.value else NO_SIZE),
    )


def _point(
    at: Place,
    law: float,
    reference: float | None,
    uncertainty: float,
    *,
    tests: bool,
    status: RangeStatus,
    outside: str,
    unjudged: str,
    moved: Sequence[tuple[str, float]] = (),
) -> PointJudgement:
    """A law beside its reference at one place; numbers in SI, NaN or None where there is none.

    ``moved`` are the failures, in no uncertainty, by which the reference moves, each with its share of it.
    """
    difference = finite(float(law / reference - 1.0)) if reference else None
    bar = _zero(abs(uncertainty / reference)) if reference else 0.0
    outcome, deciding = Outcome.NOT_COMPARABLE, set[str]()
    if status in IN_RANGE and not unjudged and tests and difference is not None:
        # What lies between the value and what another failure makes of it is as possible as both.
        reached = {name for name, share in moved if min(0.0, share) - bar <= difference <= max(0.0, share) + bar}
        missed = {name for name, share in moved if abs(difference - share) > bar}
        outcome, deciding = (Outcome.LOW if difference < 0.0 else Outcome.HIGH), reached
        if abs(difference) <= bar:
            outcome, deciding = Outcome.WITHIN, missed
    return PointJudgement(
        at=at,
        law=finite(float(law)),
        reference=None if reference is None else finite(float(reference)),
        difference=difference,
        bar=bar if tests else None,
        outcome=outcome,
        status=status,
        outside=outside,
        unjudged=unjudged,
        hangs_on=tuple(name for name, _ in moved if name in deciding),
    )


# ---- over all points -----------------------------------------------------------------------------


def _judged(
    quantity: str, name: str, reference: Reference, points: Iterable[PointJudgement], law: LawAnswers | None = None
) -> Judgement:
    """A law over its points, or the simulation."""
    points = tuple(points)
    compared = [point for point in points if point.state == "judged"]
    tested = [point for point in compared if point.bar is not None]
    numbers = [point for point in points if point.difference is not None]
    told = compared or [point for point in numbers if point.state != "outside"] or numbers
    residuals = [point.difference for point in told if point.difference is not None]
    values = [point.law for point in told if point.law is not None]
    outcome = _outcome(tested)
    return Judgement(
        quantity=quantity,
        law=law.label if law else SIMULATION,
        title=full_title(law.label, law.title) if law else SIMULATION,
        name=name,
        reference=reference,
        range=law.range if law else None,
        drawn_only=DRAWN_ONLY.get(law.confidence, "") if law else "",
        points=points,
        of=len(points),
        in_range=sum(point.state != "outside" for point in points),
        compared=len(compared),
        tested=len(tested),
        within=sum(point.outcome is Outcome.WITHIN for point in tested),
        smallest=min(values, default=None),
        largest=max(values, default=None),
        low=min(residuals, default=None),
        high=max(residuals, default=None),
        bar=max((point.bar for point in tested if point.bar is not None), default=None),
        outcome=outcome,
        reason=_reason(points, bool(compared), law is None) if outcome is Outcome.NOT_COMPARABLE else None,
    )


def _outcome(tested: Sequence[PointJudgement]) -> Outcome:
    """Within where it is at each point that tests; else the side on which the law is farthest beyond its bar."""
    if not tested:
        return Outcome.NOT_COMPARABLE
    return max(tested, key=lambda point: abs(point.difference or 0.0) - (point.bar or 0.0)).outcome


def _reason(points: Sequence[PointJudgement], is_compared: bool, is_simulation: bool) -> Reason:
    if is_compared:
        return Reason.NO_BAR
    if all(point.status is RangeStatus.OTHER_MATERIAL for point in points):
        return Reason.OTHER_MATERIAL
    if all(point.law is None for point in points) and not is_simulation:
        return Reason.NO_ANSWER
    if any(point.status is RangeStatus.FITTED for point in points):
        return Reason.FITTED
    return Reason.OUTSIDE if all(point.state == "outside" for point in points) else Reason.FLAGGED


def _unchecked(
    evidence: Evidence, shots: Sequence[MatchedObservation], has_scatter: bool, recalled: Iterable[str]
) -> Iterator[Unchecked]:
    """What was not checked about a quantity."""
    name = (evidence.name,)
    doubtful = sum(shot.confidence not in FIRST_HAND for shot in shots)
    if doubtful:
        yield Unchecked(Code.DOUBTFUL_SHOTS, name, doubtful, len(shots))
    if points := int(np.isfinite(evidence.values).sum()):
        parts, distances, alloys = evidence.parts(), evidence.distances(), evidence.other_alloys()
        for code, part in ((Code.MESH, MESH), (Code.DEFINITION, DEFINITION), (Code.MODELS, MODEL)):
            if parts[part] < points:
                yield Unchecked(code, name, points - parts[part], points)
        distant = int((distances > 1.0).sum())
        if parts[MODEL] == points and alloys:
            yield Unchecked(Code.OTHER_ALLOY, name, points, points, alloys)
        elif parts[MODEL] == points and distant:
            yield Unchecked(Code.DISTANT_MODELS, name, distant, points, factor=round(float(distances.max()), 3))
        if not has_scatter:
            yield Unchecked(Code.SCATTER, name)
    if flagged := sum(map(bool, evidence.flags)):
        counts = Counter(flag for flags in evidence.flags for flag in flags)
        yield Unchecked(
            Code.FLAGGED, name, flagged, len(evidence.flags), tuple(flag for flag, _ in counts.most_common())
        )
    if named := tuple(recalled):
        yield Unchecked(Code.RECALLED, name, names=named)


# ---- titles --------------------------------------------------------------------------------------


def full_title(label: str, title: str) -> str:
    """The title of a law with its variant."""
    variant = label.partition("/")[2]
    return f"{title} ({variant})" if variant else title


def short_names(titles: dict[str, str]) -> dict[str, str]:
    """Each title up to its first comma, bracket or "and", where no other title begins so.

    >>> short_names({"l": "Lundeberg, Stern and Bristow", "m": "Maiden (aluminium)", "c": "Maiden (sound speed)"})
    {'l': 'Lundeberg', 'm': 'Maiden (aluminium)', 'c': 'Maiden (sound speed)'}
    """
    begins = Counter(map(beginning, titles.values()))
    return {label: short if begins[short := beginning(title)] == 1 else title for label, title in titles.items()}


def beginning(title: str) -> str:
    """A title up to its first comma, bracket or "and"."""
    for mark in (" (", ",", " and "):
        title = title.partition(mark)[0]
    return title


def _zero(number: float) -> float:
    return 0.0 if math.isnan(number) else float(number)
