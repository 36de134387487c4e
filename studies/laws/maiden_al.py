"""Hole in a thin plate, Maiden et al. (1964), as printed with the constant of aluminium."""

from numpy import asarray
from numpy.typing import ArrayLike, NDArray

from studies.laws import Law, Range
from studies.laws._range import NOT_FOUND, family, like_on_like, speed, thickness_ratio


def hole_ratio(speed: ArrayLike, thickness_ratio: ArrayLike) -> NDArray:
    """Hole diameter over projectile diameter; speed in m/s, thickness over diameter; broadcasts.

    D/d = 0.45 v (t/d)^(2/3) + 0.90 with v in km/s: Ma (2005), Eq. 1-3. At 6 km/s and t/d = 0.25:

    >>> float(hole_ratio(6000.0, 0.25).round(3))
    1.971
    """
    return 0.45 * (asarray(speed) / 1e3) * asarray(thickness_ratio) ** (2.0 / 3.0) + 0.90


LAW = Law(
    name="maiden_al",
    title="Maiden (aluminium)",
    quantity="hole_diameter",
    latex=r"$D/d = 0.45 v (t/d)^{2/3} + 0.90$, $v$ in km/s",
    source=(
        "Ma (2005), Eq. 1-3, after Maiden, Gehring and McMillan (1963), GM-DRL TR-63-225, and "
        "Maiden and McMillan, AIAA Journal 2 (1964)"
    ),
    confidence="read",
    range=Range(
        like_on_like("Ma (2005), section 1.2.1"),
        # 0.45 is 2.40 / 5.35, the general form with the sound speed of aluminium.
        family("aluminium", "computed from the constant", is_derived=True),
        speed(0.0, 8.0, NOT_FOUND),
        thickness_ratio(0.0, 0.5, NOT_FOUND),
    ),
    ratio=lambda shot, _: hole_ratio(shot.speed, shot.thickness_ratio),
    wider_than_projectile=True,
)
