"""Critical diameter of a plate without a bumper, Cour-Palais: the equation of the crater's depth solved for it."""

import numpy as np
from numpy.typing import ArrayLike, NDArray

from studies.laws import Code, Law, Reason, Shot, cour_palais, without_hardness
from studies.laws._handbook import CENTIMETRE, HANDBOOK
from studies.laws._range import Range, plate
from studies.laws.plates import ALUMINIUM as FACTORS


def plate_critical_diameter(
    speed: ArrayLike,
    thickness: ArrayLike,
    density_ratio: ArrayLike,
    sound_speed: ArrayLike,
    brinell_hardness: ArrayLike,
) -> NDArray:
    """Smallest sphere, m, that perforates a plate; m/s, m, rho_p over rho_t, m/s, Brinell number; broadcasts.

    t = 1.8 p with the depth p in a thick block. The plate of 0.44 cm of Fig. 4-4 of the handbook (BHN 95, 5.1 km/s,
    2.713 g/cm3), hit by 2.796 g/cm3 at 1, 3, 7 and 14 km/s, in cm:

    >>> speeds = [1e3, 3e3, 7e3, 14e3]
    >>> (100.0 * plate_critical_diameter(speeds, 0.44e-2, 2.796 / 2.713, 5100.0, 95.0)).round(4).tolist()
    [0.4446, 0.2222, 0.1301, 0.084]
    """
    depth_of_a_centimetre = cour_palais.depth_ratio(speed, CENTIMETRE, density_ratio, sound_speed, brinell_hardness)
    depth = np.asarray(thickness) / FACTORS["perforation"] / CENTIMETRE
    return CENTIMETRE * (depth / depth_of_a_centimetre) ** (1.0 / cour_palais.SIZE_EXPONENT)


def _ratio(shot: Shot, variant: str) -> float:
    assert shot.plate_thickness is not None
    target = shot.target.sound_speed, shot.brinell_hardness
    diameter = plate_critical_diameter(shot.normal_speed, shot.plate_thickness, shot.density_ratio, *target)
    return float(diameter / shot.projectile_diameter)


def _without_plate(shot: Shot, variant: str) -> Reason | None:
    return without_hardness(shot, variant) if shot.plate_thickness else Reason(Code.PLATE)


LAW = Law(
    name="cour_palais_wall",
    title="Cour-Palais, single wall (aluminium)",
    quantity="plate_critical_diameter",
    equation=(
        "d = {t H^(1/4) (rho_t/rho_p)^(1/2) / [1.8 5.24 (v cos(theta)/C)^(2/3)]}^(18/19), d, t in cm, H: BHN; "
        "exponent 2/3 of rho_t/rho_p from rho_p/rho_t = 1.5 on; 1.8 for no perforation (2.2 detached, 3.0 any spall)"
    ),
    latex=(
        r"$d = \left(\frac{t H^{1/4} (\rho_t/\rho_p)^{1/2}}{1.8 \cdot 5.24 (v \cos(\theta)/C)^{2/3}}\right)^{18/19}$, "
        r"$d$, $t$ in cm, $H$: BHN; exponent $2/3$ of $\rho_t/\rho_p$ from $\rho_p/\rho_t = 1.5$ on; 1.8 for no "
        "perforation (2.2 detached, 3.0 any spall)"
    ),
    source=f"{HANDBOOK}, Eqs. 4-1 to 4-5, with Eq. 4-5 for perforation",
    confidence="verified",
    size_exponent=1.0 / cour_palais.SIZE_EXPONENT,
    largest_obliquity=cour_palais.LAW.largest_obliquity,
    range=Range(*cour_palais.LAW.range.limits, plate()),
    ratio=_ratio,
    meaningless=_without_plate,
)
