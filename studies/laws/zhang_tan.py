"""Hole in a thin plate, Zhang and Tan (1989)."""

import numpy as np
from numpy.typing import ArrayLike, NDArray

from studies.laws import Law, Range, Shot
from studies.laws._range import NOT_FOUND, SPEED, Code, Limit, Reason, like_on_like, stated


def hole_ratio(speed: ArrayLike, thickness_ratio: ArrayLike) -> NDArray:
    """Hole diameter over projectile diameter; speed in m/s, thickness over diameter; broadcasts.

    D/d = 1.66 (v - 1)^0.5 (t/d)^0.5 with v in km/s: Ma (2005), Eq. 1-4; NaN below 1 km/s. At 6 km/s
    and t/d = 0.25:

    >>> float(hole_ratio(6000.0, 0.25).round(3))
    1.856
    """
    excess = np.asarray(speed) / 1e3 - 1.0
    return 1.66 * np.sqrt(np.where(excess < 0.0, np.nan, excess) * np.asarray(thickness_ratio))


def smallest_speed(thickness_ratio: float) -> float:
    """The speed, in m/s, at which the hole is as wide as the projectile: D/d = 1.

    1.66^2 (v - 1) t/d = 1 gives v = 1 + 1 / (1.66^2 t/d) km/s:

    >>> round(smallest_speed(0.25) / 1e3, 2)
    2.45
    """
    return 1e3 * (1.0 + 1.0 / (1.66**2 * thickness_ratio))


def _too_slow(shot: Shot, variant: str) -> Reason | None:
    smallest = smallest_speed(shot.thickness_ratio)
    if shot.speed >= smallest:
        return None
    return Reason(Code.WIDER_THAN_PROJECTILE, SPEED, shot.speed, low=smallest, unit="m s-1")


LAW = Law(
    name="zhang_tan",
    title="Zhang and Tan",
    quantity="hole_diameter",
    latex=r"$D/d = 1.66 (v - 1)^{0.5} (t/d)^{0.5}$, $v$ in km/s",
    source=(
        "Ma (2005), Eq. 1-4: Zhang Deliang and Tan Qingming (1989), after Zhang and Huang (2000), "
        "Introduction to hypervelocity impact dynamics"
    ),
    confidence="read",
    range=Range(
        like_on_like("Ma (2005), section 1.2.1"),
        Limit(
            Code.WIDER_THAN_PROJECTILE,
            "computed from the equation",
            names=("v >= 1 + 0.363 / (t/d) km/s",),
            is_derived=True,
            check=lambda limit, shot: _too_slow(shot, ""),
        ),
        stated("largest speed and thicknesses of the shots that it was fitted to", NOT_FOUND),
    ),
    ratio=lambda shot, _: hole_ratio(shot.speed, shot.thickness_ratio),
    meaningless=_too_slow,
)
