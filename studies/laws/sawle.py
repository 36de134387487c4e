"""Hole in a thin plate, Sawle (1969)."""

from numpy import asarray
from numpy.typing import ArrayLike, NDArray

from studies.laws import Law, Range
from studies.laws._range import NOT_FOUND, family, like_on_like, plate, speed


def hole_ratio(
    speed: ArrayLike, thickness_ratio: ArrayLike, density_ratio: ArrayLike, sound_speed: ArrayLike
) -> NDArray:
    """Hole diameter over projectile diameter; both speeds in m/s, t/d, rho_p over rho_t; broadcasts.

    D/d = 3.2 [(rho_p/rho_t) (v/C)]^0.22 (t/d)^(2/3) + 1. Aluminium, 2.80 on 2.70 g/cm3 and 5.35 km/s, at 7 km/s and
    t/d = 0.25, where the form of Maiden has 2.15:

    >>> float(hole_ratio(7000.0, 0.25, 2.80 / 2.70, 5350.0).round(2))
    2.36
    """
    scaled = asarray(density_ratio) * asarray(speed) / asarray(sound_speed)
    return 3.2 * scaled**0.22 * asarray(thickness_ratio) ** (2.0 / 3.0) + 1.0


LAW = Law(
    name="sawle",
    title="Sawle",
    quantity="hole_diameter",
    latex=r"$D/d = 3.2 [(\rho_p/\rho_t) (v/C)]^{0.22} (t/d)^{2/3} + 1$, $C$: bulk sound speed of the target",
    source="Sawle (1969), AIAA paper 69-378",
    confidence="cross-checked",
    range=Range(like_on_like(NOT_FOUND), family("aluminium", NOT_FOUND), speed(2.0, 8.0, NOT_FOUND), plate()),
    ratio=lambda shot, _: hole_ratio(shot.speed, shot.thickness_ratio, shot.density_ratio, shot.target.sound_speed),
    wider_than_projectile=True,
)
