"""Hole in a thin plate, the general form of Maiden et al. (1964) with the target's sound speed."""

from numpy import asarray
from numpy.typing import ArrayLike, NDArray

from studies.laws import Law, Range
from studies.laws._range import NOT_FOUND, like_on_like, speed, stated, thickness_ratio


def hole_ratio(speed: ArrayLike, thickness_ratio: ArrayLike, sound_speed: ArrayLike) -> NDArray:
    """Hole diameter over projectile diameter; speeds in m/s, thickness over diameter; broadcasts.

    D/d = 2.40 (v/C) (t/d)^(2/3) + 0.90. The form printed for aluminium at 7 km/s and t/d = 0.25 has
    2.150, as this form has for C = 2.40 / 0.45 km/s; copper, C = 3.94 km/s, at 6 km/s has 2.350:

    >>> [float(hole_ratio(v, 0.25, C).round(3)) for v, C in ((7e3, 2.40 / 0.45e-3), (6e3, 3940.0))]
    [2.15, 2.35]
    """
    return 2.40 * asarray(speed) / asarray(sound_speed) * asarray(thickness_ratio) ** (2 / 3) + 0.90


LAW = Law(
    name="maiden_c",
    title="Maiden (sound speed)",
    quantity="hole_diameter",
    latex=r"$D/d = 2.40 (v/C) (t/d)^{2/3} + 0.90$, $C$: bulk sound speed of the target",
    source=("Maiden, Gehring and McMillan (1963), GM-DRL TR-63-225: general form of Ma (2005), Eq. 1-3"),
    confidence="cross-checked",
    range=Range(
        like_on_like("Ma (2005), section 1.2.1"),
        speed(0.0, 8.0, NOT_FOUND),
        thickness_ratio(0.0, 0.5, NOT_FOUND),
        stated("fitted to aluminium; other metals through C alone", NOT_FOUND),
    ),
    ratio=lambda shot, _: hole_ratio(shot.speed, shot.thickness_ratio, shot.target.sound_speed),
    wider_than_projectile=True,
)
