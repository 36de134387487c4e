"""Crater depth in aluminium, Cour-Palais, as the handbook of NASA prints it; in cm, g/cm3 and km/s."""

import math

import numpy as np
from numpy.typing import ArrayLike, NDArray

from studies.laws import Law, Range, without_hardness
from studies.laws._handbook import CENTIMETRE, HANDBOOK
from studies.laws._range import family, speed

SIZE_EXPONENT = 19.0 / 18.0
DENSE = 1.5  # rho_p/rho_t from which the density ratio has another exponent


def depth_ratio(
    speed: ArrayLike, diameter: ArrayLike, density_ratio: ArrayLike, sound_speed: ArrayLike, brinell_hardness: ArrayLike
) -> NDArray:
    """Crater depth over projectile diameter; m/s, m, rho_p over rho_t, m/s, Brinell number; broadcasts.

    p = 5.24 d^(19/18) H^(-1/4) (rho_p/rho_t)^(1/2) (v/C)^(2/3) with p and d in cm and v normal to the target; exponent
    2/3 of the density ratio from 1.5 on. A copper sphere of 4.746 mm on copper of BHN 37 and 50 at 6 km/s, where the
    experiment has 14 mm:

    >>> [float((4.746 * depth_ratio(6e3, 4.746e-3, 1.0, 3940.0, H)).round(1)) for H in (37.0, 50.0)]
    [12.8, 11.9]
    """
    ratio = np.asarray(density_ratio)
    size = (np.asarray(diameter) / CENTIMETRE) ** (SIZE_EXPONENT - 1.0)
    density = ratio ** np.where(ratio < DENSE, 0.5, 2.0 / 3.0)
    mach = np.asarray(speed) / np.asarray(sound_speed)
    return 5.24 * size * np.asarray(brinell_hardness) ** -0.25 * density * mach ** (2.0 / 3.0)


LAW = Law(
    name="cour_palais",
    title="Cour-Palais (aluminium)",
    quantity="crater_depth",
    latex=(
        r"$p = 5.24 d^{19/18} H^{-1/4} (\rho_p/\rho_t)^{1/2} (v \cos(\theta)/C)^{2/3}$, $p$, $d$ in cm, $H$: BHN; "
        r"exponent $2/3$ of $\rho_p/\rho_t$ from 1.5 on"
    ),
    source=(
        "Christiansen et al. (2009), NASA/TM-2009-214785, Eqs. 4-1 and 4-2; Christiansen (1993), "
        "Int. J. Impact Eng. 14, 145, Eq. 1"
    ),
    confidence="verified",
    size_exponent=SIZE_EXPONENT,
    # It over-predicts slightly above 45 deg.
    largest_obliquity=math.radians(85.0),
    range=Range(family("aluminium", HANDBOOK), speed(0.0, 8.0, HANDBOOK)),
    ratio=lambda shot, _: depth_ratio(
        shot.normal_speed, shot.projectile_diameter, shot.density_ratio, shot.target.sound_speed, shot.brinell_hardness
    ),
    meaningless=without_hardness,
)
