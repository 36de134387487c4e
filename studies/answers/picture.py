"""Pictures of an answer: critical diameter of a shield, or hole of a plate, against speed, with every law and shot."""

import math
from collections.abc import Iterator
from dataclasses import replace

from studies.answers.answer import nearest, shot_in_words
from studies.laws import Shot
from studies.observations.shields.probability import diameters_at
from studies.observations.shields.shots import published
from studies.reports.figure import CHANCES, EVEN_CHANCE, OBSERVED, THIS, Figure, Panel, Scale, Series
from studies.shields.curves import SPEED, SPEEDS, curves_of, like_shields, outcomes_of

DRAWN = (0.1, 0.5, 0.9)  # probabilities of failure


def picture(shot: Shot, target: str) -> Figure:
    """The picture of an answer; a block has crater depth over diameter against speed."""
    if target == "shield":
        return _of_shield(shot)
    name, symbol = ("hole_diameter", "D/d") if target == "plate" else ("crater_depth", "p/d")
    diameter = shot.projectile_diameter
    drawn = curves_of(name, shot, 1.0 / diameter)
    near = [each.shot for each in nearest(shot, target) if each.shot.quantity == name and each.shot.value is not None]
    seen = Series(
        "observation",
        OBSERVED,
        tuple(float(each.parameters["speed"] or 0.0) for each in near),
        tuple((each.value or 0.0) / float(each.parameters["projectile_diameter"] or 1.0) for each in near),
        notes=tuple(f"{each.source}; {each.confidence}" for each in near),
    )
    shots = (seen,) if near else ()
    title = f"{symbol} against speed, {shot.projectile.name} on {shot.target.name}"
    return Figure(
        f"{name}_against_speed",
        title,
        f"Laws that cover this {target} at some speed; dotted outside their range.",
        SPEED,
        Scale("ratio", symbol, "1"),
        (Panel(shot_in_words(shot), {}, (*drawn, *shots)),),
    )


def _of_shield(shot: Shot) -> Figure:
    like = like_shields(shot)
    mine = Series("limit", THIS, (shot.speed,), (shot.projectile_diameter,))
    return Figure(
        "critical_diameter_against_speed",
        "Diameter of the projectile above which the wall fails, against speed",
        f"{len(like)} of {len(published().shots)} published shots are on shields like this one. "
        "Lines: equations, dotted outside their range. The probability ends where the shots end.",
        SPEED,
        Scale("critical_diameter", "diameter of the projectile", "m"),
        (
            Panel(
                shot_in_words(shot),
                {},
                (*_chances(shot), *curves_of("critical_diameter", shot), *outcomes_of(like), mine),
            ),
        ),
    )


def _chances(shot: Shot) -> Iterator[Series]:
    """The diameters that fail with the drawn probabilities, as a band and its middle; none without an equation."""
    each = [diameters_at(replace(shot, speed=speed), DRAWN) for speed in SPEEDS]
    low, even, high = ([None if math.isnan(d) else d for d in column] for column in zip(*each, strict=True))
    inside = tuple(d is not None for d in even)
    if any(inside):
        yield Series("band", CHANCES, SPEEDS, low=tuple(low), high=tuple(high), in_range=inside)
        yield Series("trend", EVEN_CHANCE, SPEEDS, tuple(even))
