"""Series of figures over the speed: laws, and the published shots on shields like one."""

from collections.abc import Iterator, Sequence
from dataclasses import replace

from studies import laws
from studies.laws import Shot
from studies.observations.shields.shots import ShieldShot, distances_of_shields, published
from studies.reports.figure import FAILED, HELD, Scale, Series, numbers

SPEED = Scale("speed", "speed", "m s-1")
SLOWEST, FASTEST = 1e3, 12e3  # m/s: of the curves, as far as the shots go
POINTS = 45  # of a curve: every 250 m/s
SPEEDS = tuple(SLOWEST + (FASTEST - SLOWEST) * place / (POINTS - 1) for place in range(POINTS))
# A shield is like another where the root of the summed squares of ln ratios (bumper, wall, space, yield stress of the
# wall, densities) and of the angle in rad is no more: each ratio within 1.5 if all else is equal.
LIKE = 0.4


def like_shields(shot: Shot) -> list[ShieldShot]:
    """The published shots on shields like that of a shot, at any speed and of any diameter; all have one bumper."""
    assert shot.shield is not None
    if shot.shield.further_bumpers:
        return []
    shots = published().shots
    return [each for each, apart in zip(shots, distances_of_shields(shot, shots), strict=True) if apart <= LIKE]


def outcomes_of(shots: Sequence[ShieldShot]) -> Iterator[Series]:
    """Published shots as marks: those whose wall failed, and those whose wall held."""
    for label, failed in ((FAILED, True), (HELD, False)):
        of = [each for each in shots if each.is_perforated is failed]
        if of:
            yield Series(
                "observation",
                label,
                tuple(each.speed for each in of),
                tuple(each.projectile_diameter for each in of),
                notes=tuple(f"{each.source} {each.shot}".strip() for each in of),
            )


def curves_of(quantity: str, shot: Shot, factor: float = 1.0) -> Iterator[Series]:
    """The laws of a quantity that may judge and cover the shot at some speed, over the speed."""
    for law in laws.answering(quantity):
        if law.use != "verdict":
            continue
        shots = [replace(shot, speed=speed) for speed in SPEEDS]
        inside = tuple(law.evaluate(each, law.variants(each)[0]).in_range for each in shots)
        if any(inside):
            values = numbers(0.5 * factor * sum(law.band(each)) for each in shots)
            yield Series("curve", law.title, SPEEDS, values, in_range=inside)
