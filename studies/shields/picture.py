"""The picture of an answer about a shield: critical diameter against speed, with every equation and shot."""

import math
from collections.abc import Iterator, Sequence
from dataclasses import replace

from studies.answers.answer import shot_in_words
from studies.answers.picture import SPEED, SPEEDS, curves_of
from studies.reports.figure import CHANCES, EVEN_CHANCE, FAILED, HELD, THIS, Figure, Panel, Scale, Series
from studies.shields.shield import CRITICAL_DIAMETER, ShotAtShield
from studies.shields.shots.chance import diameters_at
from studies.shields.shots.table import ShieldShot, like_shields, published

DRAWN = (0.1, 0.5, 0.9)  # probabilities of failure


def picture(shot: ShotAtShield) -> Figure:
    """Equations, chances, shots on shields like it, and the shot itself."""
    like = like_shields(shot)
    mine = Series("limit", THIS, (shot.speed,), (shot.projectile_diameter,))
    return Figure(
        "critical_diameter_against_speed",
        "Diameter of the projectile above which the wall fails, against speed",
        f"{len(like)} of {len(published().shots)} published shots are on shields like this one. "
        "Lines: equations, dotted outside their range. The probability ends where the shots end.",
        SPEED,
        Scale(CRITICAL_DIAMETER, "diameter of the projectile", "m"),
        (
            Panel(
                shot_in_words(shot),
                {},
                (*_chances(shot), *curves_of(CRITICAL_DIAMETER, shot), *outcomes_of(like), mine),
            ),
        ),
    )


def _chances(shot: ShotAtShield) -> Iterator[Series]:
    """The diameters that fail with the drawn probabilities, as a band and its middle; none without an equation."""
    columns = [diameters_at(replace(shot, speed=speed), DRAWN) for speed in SPEEDS]
    low, even, high = ([None if math.isnan(d) else d for d in column] for column in zip(*columns, strict=True))
    inside = tuple(d is not None for d in even)
    if any(inside):
        yield Series("band", CHANCES, SPEEDS, low=tuple(low), high=tuple(high), in_range=inside)
        yield Series("trend", EVEN_CHANCE, SPEEDS, tuple(even))


def outcomes_of(shots: Sequence[ShieldShot]) -> Iterator[Series]:
    """Published shots as marks: those whose wall failed, and those whose wall held."""
    for label, failed in ((FAILED, True), (HELD, False)):
        of = [shot for shot in shots if shot.is_perforated is failed]
        if of:
            yield Series(
                "observation",
                label,
                tuple(shot.speed for shot in of),
                tuple(shot.projectile_diameter for shot in of),
                notes=tuple(f"{shot.source} {shot.shot}".strip() for shot in of),
            )
