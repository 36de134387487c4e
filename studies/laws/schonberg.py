"""Hole in a thin plate at normal impact, Schonberg (1988)."""

from numpy import asarray
from numpy.typing import ArrayLike, NDArray

from studies.laws import Law, Range
from studies.laws._range import NOT_FOUND, family, like_on_like, plate, stated


def hole_ratio(speed: ArrayLike, thickness_ratio: ArrayLike, sound_speed: ArrayLike) -> NDArray:
    """Hole diameter over projectile diameter; both speeds in m/s, t/d; broadcasts.

    D/d = 2.794 (v/C)^0.962 (t/d)^0.895 + 1.120. Aluminium, 5.35 km/s, at 7 km/s and t/d = 0.25, where the form of
    Maiden has 2.15:

    >>> float(hole_ratio(7000.0, 0.25, 5350.0).round(2))
    2.17
    """
    mach = asarray(speed) / asarray(sound_speed)
    return 2.794 * mach**0.962 * asarray(thickness_ratio) ** 0.895 + 1.120


LAW = Law(
    name="schonberg",
    title="Schonberg",
    quantity="hole_diameter",
    latex=r"$D/d = 2.794 (v/C)^{0.962} (t/d)^{0.895} + 1.120$, $C$: bulk sound speed of the target",
    source="Schonberg (1988), fit to tests of the Marshall Space Flight Center at normal impact",
    confidence="cross-checked",
    range=Range(
        like_on_like(NOT_FOUND),
        family("aluminium", NOT_FOUND),
        plate(),
        stated("1100 spheres on 6061-T6 plates", NOT_FOUND),
    ),
    ratio=lambda shot, _: hole_ratio(shot.speed, shot.thickness_ratio, shot.target.sound_speed),
    wider_than_projectile=True,
)
