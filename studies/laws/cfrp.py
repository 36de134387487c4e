"""Crater depth in laminates of carbon fibres, Ryan and Christiansen (2011); in cm, g/cm3 and km/s."""

from numpy import asarray
from numpy.typing import ArrayLike, NDArray

from studies.laws import Law, Range
from studies.laws._handbook import KILOMETRE_PER_SECOND, RYAN
from studies.laws._range import family, speed, stated


def depth_ratio(speed: ArrayLike, density_ratio: ArrayLike) -> NDArray:
    """Crater depth over projectile diameter; m/s, rho_p over rho_t; broadcasts.

    p/d = 0.62 (rho_p/rho_t)^(1/2) v^(2/3) with v in km/s: at 1 km/s and equal densities the printed constant.

    >>> float(depth_ratio(1000.0, 1.0))
    0.62
    """
    velocity = asarray(speed) / KILOMETRE_PER_SECOND
    return 0.62 * asarray(density_ratio) ** 0.5 * velocity ** (2.0 / 3.0)


LAW = Law(
    name="cfrp",
    title="Ryan and Christiansen (CFRP)",
    quantity="crater_depth",
    equation="p/d = 0.62 (rho_p/rho_t)^(1/2) (v cos(theta))^(2/3), v in km/s",
    source=f"{RYAN}, 245, Eq. 15; an older form is Eq. 4-13 of NASA/TM-2009-214785",
    confidence="verified",
    range=Range(
        (
            family("cfrp", RYAN),
            speed(5.8, 6.6, RYAN),
            stated("quasi-isotropic laminate of 3.8 mm", RYAN),
        )
    ),
    ratio=lambda shot, variant: float(depth_ratio(shot.speed, shot.density_ratio)),
)
