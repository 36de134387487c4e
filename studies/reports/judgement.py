"""How a law does beside what it is compared with: a record with numbers for each law of each quantity.

Made in one place, from the evidence of a cube; templates put it into words.
"""

from collections import Counter
from collections.abc import Sequence
from typing import Any

from studies.cubes.reading import finite
from studies.laws import DRAWN_ONLY, RangeStatus
from studies.reports.evidence import Evidence, JudgedPoint, Subject
from studies.reports.records import Judgement, Outcome, PointJudgement, Reason, Reference

SIMULATION = "simulation"  # the subject that is no law


def judgements_of(evidence: Evidence) -> tuple[Judgement, ...]:
    """Every law and the simulation beside each reference of a quantity: observed shots first, then by distance."""
    names = short_names({each.name: each.full_title for each in evidence.subjects})
    found = [_judged(evidence.quantity, subject, names[subject.name]) for subject in evidence.subjects]
    return tuple(sorted(found, key=_rank))


def _rank(each: Judgement) -> tuple[Any, ...]:
    """Nearest first; behind those that are compared those that are not, and those that are drawn alone."""
    far = float("inf") if each.low is None else each.worst
    return each.reference != "observation", bool(each.drawn_only), not each.compared, far


def nearest(judgements: Sequence[Judgement], reference: Reference) -> list[Judgement]:
    """The laws that may stand in a headline, nearest first: first those that are compared at half of the points.

    Where flags keep every value from being compared these are the laws beside the flagged values.
    """
    mine = [each for each in judgements if each.reference == reference and each.law != SIMULATION]
    mine = [each for each in mine if not each.drawn_only and each.low is not None]
    some = [each for each in mine if each.compared]
    mine = some or [each for each in mine if each.reason is Reason.FLAGGED]
    most = max((each.compared for each in mine), default=0)
    return sorted(mine, key=lambda each: (2 * each.compared < most, each.worst))


def _judged(quantity: str, subject: Subject, name: str) -> Judgement:
    compared = [point for point in subject.points if point.state == "judged"]
    tested = [point for point in compared if point.tests]
    numbers = [point for point in subject.points if point.reference and point.residual == point.residual]
    told = compared or [point for point in numbers if point.state != "outside"] or numbers
    outcome = _outcome(tested)
    return Judgement(
        quantity=quantity,
        law=subject.name,
        title=subject.full_title,
        name=name,
        reference=subject.reference,
        has_range=subject.has_range is not False,
        drawn_only=DRAWN_ONLY.get(subject.confidence, ""),
        points=tuple(map(_point, subject.points)),
        of=len(subject.points),
        in_range=sum(point.state != "outside" for point in subject.points),
        compared=len(compared),
        tested=len(tested),
        within=sum(point.outcome is Outcome.WITHIN for point in tested),
        smallest=min((point.law for point in told), default=None),
        largest=max((point.law for point in told), default=None),
        low=min((point.residual for point in told), default=None),
        high=max((point.residual for point in told), default=None),
        bar=max((point.bar for point in tested), default=None),
        outcome=outcome,
        reason=_reason(subject, compared) if outcome is Outcome.NOT_COMPARABLE else None,
    )


def _outcome(tested: Sequence[JudgedPoint]) -> Outcome:
    """Within where it is at each point that tests; else the side on which the law is farthest beyond its bar."""
    if not tested:
        return Outcome.NOT_COMPARABLE
    return max(tested, key=lambda point: abs(point.residual) - point.bar).outcome


def _reason(subject: Subject, compared: Sequence[JudgedPoint]) -> Reason:
    if compared:
        return Reason.NO_BAR
    if all(point.status is RangeStatus.OTHER_MATERIAL for point in subject.points):
        return Reason.OTHER_MATERIAL
    if all(point.law != point.law for point in subject.points):
        return Reason.NO_ANSWER
    if any(point.status is RangeStatus.FITTED for point in subject.points):
        return Reason.FITTED
    return Reason.OUTSIDE if all(point.state == "outside" for point in subject.points) else Reason.FLAGGED


def _point(point: JudgedPoint) -> PointJudgement:
    return PointJudgement(
        at=point.at,
        law=finite(point.law),
        reference=finite(point.reference),
        difference=finite(point.residual) if point.reference else None,
        bar=point.bar if point.tests else None,
        outcome=point.outcome,
        outside=point.outside,
        unjudged=point.unjudged,
        hangs_on=tuple(each.failure for each in point.hangs_on),
    )


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
