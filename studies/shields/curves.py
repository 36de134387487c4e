"""Series of figures: the published shots on shields like one."""

from collections.abc import Iterator, Sequence

from studies.reports.figure import FAILED, HELD, Series
from studies.shields.shield import ShotAtShield
from studies.shields.shots.table import ShieldShot, distances_of_shields, published

# A shield is like another where the root of the summed squares of ln ratios (bumper, wall, space, yield stress of the
# wall, densities) and of the angle in rad is no more: each ratio within 1.5 if all else is equal.
LIKE = 0.4


def like_shields(shot: ShotAtShield) -> list[ShieldShot]:
    """The published shots on shields like that of a shot, at any speed and of any diameter; all have one bumper."""
    if shot.shield.further_bumpers:
        return []
    shots = published().shots
    return [like for like, apart in zip(shots, distances_of_shields(shot, shots), strict=True) if apart <= LIKE]


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
