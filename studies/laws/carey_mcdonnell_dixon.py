"""Hole in a foil, Carey, McDonnell and Dixon (1985), as recalled."""

import numpy as np
from numpy.typing import ArrayLike, NDArray

from studies.laws import Law, Range
from studies.laws._handbook import KILOMETRE_PER_SECOND
from studies.laws._range import NOT_FOUND, plate, speed, stated


def hole_ratio(speed: ArrayLike, thickness_ratio: ArrayLike) -> NDArray:
    """Hole diameter over projectile diameter; m/s, t/d; broadcasts.

    D/d = 1 + 1.5 (t/d) v^0.3 / [1 + (t/d)^2 v^-n], n = 1.02 - 4 exp(-0.9 v^0.9) - 0.003 (20 - v) with v in km/s. At
    7 km/s and t/d = 0.25 less than the laws of plates, which have 2.1 to 2.4:

    >>> float(hole_ratio(7000.0, 0.25).round(2))
    1.67
    """
    velocity, thickness = np.asarray(speed) / KILOMETRE_PER_SECOND, np.asarray(thickness_ratio)
    n = 1.02 - 4.0 * np.exp(-0.9 * velocity**0.9) - 0.003 * (20.0 - velocity)
    return 1.0 + 1.5 * thickness * velocity**0.3 / (1.0 + thickness**2 * velocity**-n)


LAW = Law(
    name="carey_mcdonnell_dixon",
    title="Carey, McDonnell and Dixon",
    quantity="hole_diameter",
    equation=(
        "D/d = 1 + 1.5 (t/d) v^0.3 / [1 + (t/d)^2 v^-n], n = 1.02 - 4 exp(-0.9 v^0.9) - 0.003 (20 - v), v in km/s"
    ),
    latex=(
        r"$D/d = 1 + \frac{1.5 (t/d) v^{0.3}}{1 + (t/d)^2 v^{-n}}$, $n = 1.02 - 4 \exp({-0.9} v^{0.9})$ "
        "${}- 0.003 (20 - v)$, $v$ in km/s"
    ),
    source="Carey, McDonnell and Dixon (1985), as recalled",
    confidence="memory",
    range=Range(speed(2.0, 20.0, NOT_FOUND), plate(), stated("foils", NOT_FOUND)),
    ratio=lambda shot, _: hole_ratio(shot.speed, shot.thickness_ratio),
    wider_than_projectile=True,
)
