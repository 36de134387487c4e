"""Equations judged by shots: how often each was right, unsafe or too careful, and how many failures it caught.

An equation says that the wall fails where the sphere is larger than its critical diameter. It is asked about the shots
that its range covers: one for normal impact about normal impact alone. Unsafe is a wall said to hold that was
perforated; too careful, one said to fail that held. The collection counts walls with detached spall as held, where most
equations call them failed, so that "too careful" has these walls too.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass

from studies import laws
from studies.laws import Law, Shot
from studies.outcomes.found import Share
from studies.shields.shield import CRITICAL_DIAMETER
from studies.shields.shots.table import ShieldShot

# Ranges of the normal speed, m/s: whole projectiles, fragments, molten debris.
RANGES: tuple[tuple[str, float, float], ...] = (
    ("below 3 km/s", 0.0, 3e3),
    ("3 to 7 km/s", 3e3, 7e3),
    ("from 7 km/s", 7e3, math.inf),
)
ALL = "all"


@dataclass(frozen=True)
class Judged:
    """What shots say about an equation."""

    law: str
    where: str  # ALL, a range of the normal speed, or what the caller says
    right: Share
    unsafe: Share  # said to hold, and perforated
    careful: Share  # said to fail, and held
    caught: Share  # of the failures: said to fail


def equations() -> list[Law]:
    """The equations for two walls, which the shots can judge."""
    return [law for law in laws.answering(CRITICAL_DIAMETER) if not law.name.endswith("three_walls")]


def margin(law: Law, shot: Shot) -> float:
    """ln(d/d_c): above zero the equation says that the wall fails; NaN where its range does not cover the shot."""
    answer = law.evaluate(shot)
    return math.log(shot.projectile_diameter / answer.value) if answer.in_range else math.nan


def margins(law: Law, shots: Sequence[ShieldShot]) -> list[float]:
    """The margin of each shot."""
    return [margin(law, shot.as_shot()) for shot in shots]


def range_of(normal_speed: float) -> int:
    """The place of a normal speed, m/s, among the ranges."""
    return next(place for place, (_, low, high) in enumerate(RANGES) if low <= normal_speed < high)


def judge(law: Law, shots: Sequence[ShieldShot], where: str = ALL) -> Judged:
    """How often an equation was right about shots."""
    pairs = zip(margins(law, shots), shots, strict=True)
    return counted(law.name, where, [(m > 0.0, shot.is_perforated) for m, shot in pairs if not math.isnan(m)])


def judge_by_range(law: Law, shots: Sequence[ShieldShot]) -> tuple[Judged, ...]:
    """The same over all, and by range of the normal speed."""
    by_range = [[shot for shot in shots if range_of(shot.normal_speed) == place] for place in range(len(RANGES))]
    parts = (judge(law, mine, where) for (where, *_), mine in zip(RANGES, by_range, strict=True))
    return (judge(law, shots), *parts)


def counted(law: str, where: str, asked: Sequence[tuple[bool, bool]]) -> Judged:
    """How often it was right whether walls failed, by pairs of what was said and of what happened."""
    failures = sum(failed for _, failed in asked)
    return Judged(
        law,
        where,
        right=Share(sum(said == failed for said, failed in asked), len(asked)),
        unsafe=Share(asked.count((False, True)), len(asked)),
        careful=Share(asked.count((True, False)), len(asked)),
        caught=Share(asked.count((True, True)), failures),
    )
