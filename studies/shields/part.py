"""Computes the section of the ballistic limit, and what it opens a report with."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Literal

from studies.cubes.points import Place, axes_of, refinements_of
from studies.outcomes.shots import OF_MODEL
from studies.reports.records import Outcome
from studies.reports.section import Part, Source
from studies.reports.wording import text_template, worded
from studies.shields.curves import like_shields
from studies.shields.figure import shield_figure
from studies.shields.limit import shield_limits, shots_at, shots_of
from studies.shields.probability import shot_of, with_chances
from studies.shields.section import BallisticLimit, Beside, Equation, JustSafe, OrderedShots, ShieldLimit, WallRun
from studies.shields.shield import ShotAtShield
from studies.shields.shots import answers

NEAREST = 3  # published shots
NAMED = 2  # equations of a headline
RISK = 0.1  # of the sizes that a headline names
SAID: Mapping[bool | None, "Said"] = {True: "perforated", False: "held", None: "undecided"}
Said = Literal["held", "perforated", "undecided", "disagree"]


def part_of(source: Source) -> Part | None:
    """The section; None of a sweep without a wall, or where no equation is known."""
    dataset, points = source.dataset, source.points
    limits = shield_limits(points)
    if not limits:
        return None
    shots = shots_of(dataset)
    rows = with_chances(dataset, points, limits, shots)
    opening = _opening_run(rows) or _opening_limit(rows)
    beside = _beside(opening, shots)
    record = BallisticLimit(rows, beside, bool(refinements_of(dataset)))
    units = {name: points[name].attrs.get("units") for name in axes_of(points)}
    return Part(record, tuple(shield_figure(dataset, rows, shots)), headline(opening, beside, units))


# ---- published shots and the inverse -------------------------------------------------------------


def _beside(opening: "ShieldOpening", shots: Sequence[tuple[Place, ShotAtShield]]) -> Beside | None:
    """Shots beside that which opens the report; None where the sweep has no such shot."""
    limit, diameter = opening.limit, opening.diameter
    shot = shot_of(shots_at(shots, limit.at), limit.speed, diameter)
    if shot is None:
        return None
    answer, like = answers.answer(shot), like_shields(shot)
    is_like = not shot.shield.further_bumpers  # all published shots have one bumper
    ordered = (answer.easier, answer.harder) if is_like else ()
    easier, harder = [OrderedShots(each.shots, each.contrary) for each in ordered] or [OrderedShots(0, 0)] * 2
    failed = sum(each.is_perforated for each in like)
    return Beside(
        at=limit.at,
        speed=limit.speed,
        diameter=diameter,
        failed=failed,
        held=len(like) - failed,
        easier=easier,
        harder=harder,
        nearest=answer.nearest[:NEAREST] if is_like else (),
        safe=tuple(
            JustSafe(each.size.value, each.risk, each.law, each.value, each.reason and each.reason.value)
            for each in answer.safe
        ),
    )


# ---- what a report opens with --------------------------------------------------------------------


@dataclass(frozen=True)
class ShieldOpening:
    """What is said of the shield that opens a report."""

    limit: ShieldLimit
    told: tuple[str, ...]  # axes that tell its shield from others
    diameter: float  # m, about which shots and equations are asked
    run: WallRun | None = None  # of sweeps with one for each shield: the one most likely to fail
    of_several: bool = True  # such sweeps
    simulated: Said = "undecided"
    equations: tuple[Equation, ...] = ()  # of sweeps that bracket a limit


def _opening_run(rows: Sequence[ShieldLimit]) -> ShieldOpening | None:
    """The shot most likely to fail; None where a shield has several, or one has no probability."""
    ranked: list[tuple[float, ShieldLimit]] = []
    for limit in rows:
        chance = limit.runs[0].joined or limit.runs[0].before
        if len(limit.runs) != 1 or chance is None:
            return None
        ranked.append((chance.value, limit))
    _, limit = max(ranked, key=lambda each: each[0])
    [run] = limit.runs
    outcomes = {each.runs[0].perforated for each in rows if _shot(each) == _shot(limit)}
    said = SAID[outcomes.pop()] if len(outcomes) == 1 else "disagree"
    of_several = any(_shot(each) != _shot(limit) for each in rows)
    return ShieldOpening(limit, _told(rows), run.diameter, run, of_several, said)


def _shot(limit: ShieldLimit) -> tuple[float, Place]:
    """Speed and shield, however they are computed."""
    return limit.speed, {name: value for name, value in limit.at.items() if name not in OF_MODEL}


def _opening_limit(rows: Sequence[ShieldLimit]) -> ShieldOpening:
    """The limit with the equation that is unsafe by most, else too careful by most; else the fastest."""
    for outcome in (Outcome.HIGH, Outcome.LOW):
        limit, worst = max(((row, _worst(row, outcome)) for row in rows), key=lambda each: each[1])
        if worst > 0.0:
            break
    else:
        limit = max(rows, key=lambda row: ((row.lower is not None) + (row.upper is not None), row.speed))
    unsafe = [each for each in limit.equations if each.outcome is Outcome.HIGH]
    gravest = sorted(unsafe, key=lambda each: each.diameter)[-1:]
    named = (*gravest, *(each for each in limit.equations if each not in gravest))
    middle = limit.runs[len(limit.runs) // 2].diameter
    return ShieldOpening(limit, _told(rows), limit.lower or limit.upper or middle, equations=named)


def _worst(limit: ShieldLimit, outcome: Outcome) -> float:
    """By how much the farthest equation with an outcome lies beyond the interval; 0 without any."""
    return max((abs(each.difference or 0.0) for each in limit.equations if each.outcome is outcome), default=0.0)


def _told(rows: Sequence[ShieldLimit]) -> tuple[str, ...]:
    return tuple(name for name in rows[0].at if name not in OF_MODEL and len({row.at[name] for row in rows}) > 1)


def headline(opening: ShieldOpening, beside: Beside | None, units: Mapping[str, str | None]) -> str:
    """The opening in words; ``units`` are those of the axes."""
    by_risk = {each.size: each for each in beside.safe if each.risk == RISK} if beside else {}
    return worded(
        text_template("studies.shields:headline.txt"),
        opening=opening,
        beside=beside,
        sphere=by_risk.get("projectile_diameter"),
        wall=by_risk.get("wall_thickness"),
        units=units,
        named=NAMED,
    )
