"""Computes the section of the ballistic limit, and what it opens a report with."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from operator import itemgetter
from typing import Literal

from studies.cubes.points import Place, axes_of, refinements_of
from studies.outcomes.shots import OF_MODEL
from studies.reports.records import Outcome
from studies.reports.section import Part, Source
from studies.reports.wording import text_template, worded
from studies.shields.figure import shield_figure
from studies.shields.limit import has_limits, shield_limits, shot_of, shots_at, shots_of, wall_runs, with_chances
from studies.shields.section import BallisticLimit, Beside, Equation, OrderedShots, ShieldLimit, WallRun
from studies.shields.shield import ShotAtShield
from studies.shields.shots import answers
from studies.shields.shots.records import Size
from studies.shields.shots.table import like_shields

NEAREST = 3  # published shots
NAMED = 2  # equations of a headline
RISK = 0.1  # of the sizes that a headline names
SAID: Mapping[bool | None, "Said"] = {True: "perforated", False: "held", None: "undecided"}
Said = Literal["held", "perforated", "undecided", "disagree", "cannot tell"]


def part_of(source: Source) -> Part | None:
    """The section; None of a sweep without a wall, or where no equation is known."""
    dataset, points = source.dataset, source.points
    if not has_limits(points):
        return None
    shots = shots_of(dataset)
    rows = shield_limits(points, [*with_chances(points, wall_runs(points), shots)])
    if not rows:
        return None
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
    easier, harder = [OrderedShots(said.shots, said.contrary) for said in ordered] or [OrderedShots(0, 0)] * 2
    failed = sum(shot.is_perforated for shot in like)
    return Beside(
        at=limit.at,
        speed=limit.speed,
        diameter=diameter,
        failed=failed,
        held=len(like) - failed,
        easier=easier,
        harder=harder,
        nearest=answer.nearest[:NEAREST] if is_like else (),
        safe=answer.safe,
    )


# ---- what a report opens with --------------------------------------------------------------------


@dataclass(frozen=True)
class ShieldOpening:
    """What is said of the shield that opens a report."""

    limit: ShieldLimit
    told: tuple[str, ...]  # axes that tell its shield from others
    diameter: float  # m, about which shots and equations are asked
    run: WallRun | None = None  # of sweeps with one for each shield: the one most likely to fail
    least: tuple[ShieldLimit, WallRun] | None = None  # the one least likely to fail, of another shield or speed
    simulated: Said = "undecided"
    equations: tuple[Equation, ...] = ()  # of sweeps that bracket a limit


def _opening_run(rows: Sequence[ShieldLimit]) -> ShieldOpening | None:
    """The shot most likely to fail; None where a shield has several, or one has no probability."""
    ranked: list[tuple[float, ShieldLimit]] = []
    for limit in rows:
        chance = limit.runs[0].probability
        if len(limit.runs) != 1 or chance is None:
            return None
        ranked.append((chance.value, limit))
    (_, safest), (_, limit) = min(ranked, key=itemgetter(0)), max(ranked, key=itemgetter(0))
    [run] = limit.runs
    outcomes = {row.runs[0].perforated for row in rows if _shot(row) == _shot(limit)}
    said = "disagree" if len(outcomes) > 1 else "cannot tell" if run.cannot_tell else SAID[outcomes.pop()]
    least = (safest, safest.runs[0]) if _shot(safest) != _shot(limit) else None
    return ShieldOpening(limit, _told(rows), run.diameter, run, least, said)


def _shot(limit: ShieldLimit) -> tuple[float, Place]:
    """Speed and shield, however they are computed."""
    return limit.speed, {name: value for name, value in limit.at.items() if name not in OF_MODEL}


def _opening_limit(rows: Sequence[ShieldLimit]) -> ShieldOpening:
    """The limit with the equation that is unsafe by most, else too careful by most; else the fastest."""
    for outcome in (Outcome.HIGH, Outcome.LOW):
        limit, worst = max(((row, _worst(row, outcome)) for row in rows), key=lambda found: found[1])
        if worst > 0.0:
            break
    else:
        limit = max(rows, key=lambda row: ((row.lower is not None) + (row.upper is not None), row.speed))
    unsafe = [said for said in limit.equations if said.outcome is Outcome.HIGH]
    gravest = sorted(unsafe, key=lambda said: said.diameter)[-1:]
    named = (*gravest, *(said for said in limit.equations if said not in gravest))
    middle = limit.runs[len(limit.runs) // 2].diameter
    return ShieldOpening(limit, _told(rows), limit.lower or limit.upper or middle, equations=named)


def _worst(limit: ShieldLimit, outcome: Outcome) -> float:
    """By how much the farthest equation with an outcome lies beyond the interval; 0 without any."""
    return max((abs(said.difference or 0.0) for said in limit.equations if said.outcome is outcome), default=0.0)


def _told(rows: Sequence[ShieldLimit]) -> tuple[str, ...]:
    return tuple(name for name in rows[0].at if name not in OF_MODEL and len({row.at[name] for row in rows}) > 1)


def headline(opening: ShieldOpening, beside: Beside | None, units: Mapping[str, str | None]) -> str:
    """The opening in words; ``units`` are those of the axes."""
    by_risk = {safe.size: safe for safe in beside.safe if safe.risk == RISK} if beside else {}
    return worded(
        text_template("studies.shields:headline.txt"),
        opening=opening,
        beside=beside,
        sphere=by_risk.get(Size.SPHERE),
        wall=by_risk.get(Size.WALL),
        units=units,
        named=NAMED,
    )
