"""Smallest diameter of a hole in a thin plate, Schonberg and Taylor (1989), at normal impact."""

from numpy import asarray
from numpy.typing import ArrayLike, NDArray

from studies.laws import Law, Range
from studies.laws._range import NOT_FOUND, family, like_on_like, plate, stated


def hole_ratio(speed: ArrayLike, thickness_ratio: ArrayLike, sound_speed: ArrayLike) -> NDArray:
    """Hole diameter over projectile diameter; both speeds in m/s, t/d; broadcasts.

    D/d = 2.698 (v/C)^0.689 (t/d)^0.708 + 0.93 at normal impact; the factor of oblique impact is not known with its
    sign. Aluminium, 5.35 km/s, at 7 km/s and t/d = 0.25, where the form of Maiden has 2.15:

    >>> float(hole_ratio(7000.0, 0.25, 5350.0).round(2))
    2.15
    """
    mach = asarray(speed) / asarray(sound_speed)
    return 2.698 * mach**0.689 * asarray(thickness_ratio) ** 0.708 + 0.93


LAW = Law(
    name="schonberg_taylor",
    title="Schonberg and Taylor",
    quantity="hole_diameter",
    latex=r"$D_{\text{min}}/d = 2.698 (v/C)^{0.689} (t/d)^{0.708} + 0.93$, $C$: bulk sound speed of the target",
    source="Schonberg and Taylor (1989), NASA CR-4343 and AIAA Journal 27",
    confidence="cross-checked",
    range=Range(
        like_on_like(NOT_FOUND),
        family("aluminium", NOT_FOUND),
        plate(),
        stated("smallest diameter; at normal impact the diameter", "the definition of D_min", is_derived=True),
    ),
    ratio=lambda shot, _: hole_ratio(shot.speed, shot.thickness_ratio, shot.target.sound_speed),
    wider_than_projectile=True,
)
