"""Crater depth in a thick block of metal, Summers and Charters (1959)."""

import math

from numpy import asarray
from numpy.typing import ArrayLike, NDArray

from studies.laws import Law, Range
from studies.laws._range import NOT_FOUND, between, density_ratio, speed, stated

COUR_PALAIS = "Cour-Palais (1987), Int. J. Impact Eng. 5, p. 225"


def depth_ratio(speed: ArrayLike, density_ratio: ArrayLike, sound_speed: ArrayLike) -> NDArray:
    """Crater depth over projectile diameter; both speeds in m/s, rho_p over rho_t; broadcasts.

    p/d = 2.28 (rho_p/rho_t)^(2/3) (v/C)^(2/3). A copper sphere of 4.746 mm on copper at 6 km/s,
    where the experiment has 14 mm (Ma (2005), Table 3.3):

    >>> float((4.746 * depth_ratio(6000.0, 1.0, 3940.0)).round(1))
    14.3
    """
    scaled = asarray(density_ratio) * asarray(speed) / asarray(sound_speed)
    return 2.28 * scaled ** (2.0 / 3.0)


LAW = Law(
    name="charters_summers",
    title="Charters and Summers",
    quantity="crater_depth",
    latex=r"$p/d = 2.28 (\rho_p/\rho_t)^{2/3} (v/C)^{2/3}$, $C$: bulk sound speed of the target",
    source="Summers and Charters (1959), Third Symposium on Hypervelocity Impact",
    confidence="cross-checked",
    range=Range(
        between("v/C", lambda shot: shot.speed / shot.target.sound_speed, (1.0, math.inf), NOT_FOUND),
        # Data up to 16 km/s do not tell the exponent 2/3 from 0.58; densities within a factor of 3.
        speed(0.0, 16.0, COUR_PALAIS),
        density_ratio(1.0 / 3.0, 3.0, COUR_PALAIS),
        stated("metals", NOT_FOUND),
    ),
    ratio=lambda shot, _: depth_ratio(shot.speed, shot.density_ratio, shot.target.sound_speed),
)
