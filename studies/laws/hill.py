"""Hole in a thin plate at normal impact, after Hill (2004)."""

from numpy import asarray
from numpy.typing import ArrayLike, NDArray

from studies.laws import Law, Range
from studies.laws._range import NOT_FOUND, plate, stated


def hole_ratio(
    speed: ArrayLike,
    thickness_ratio: ArrayLike,
    density_ratio: ArrayLike,
    sound_speed: ArrayLike,
    projectile_sound_speed: ArrayLike,
) -> NDArray:
    """Hole diameter over projectile diameter; speeds in m/s, t/d, rho_p over rho_t; broadcasts.

    D/d = 2.8 (rho_p/rho_t)^-0.035 (v/C_t)^0.335 (v/C_p)^0.113 (t/d)^0.516 + 0.6 at normal impact. Aluminium, 2.80 on
    2.70 g/cm3 and 5.35 km/s, at 7 km/s and t/d = 0.25, where the form of Maiden has 2.15:

    >>> float(hole_ratio(7000.0, 0.25, 2.80 / 2.70, 5350.0, 5350.0).round(2))
    2.14
    """
    velocity = asarray(speed)
    scaled = asarray(density_ratio) ** -0.035 * (velocity / asarray(sound_speed)) ** 0.335
    scaled = scaled * (velocity / asarray(projectile_sound_speed)) ** 0.113
    return 2.8 * scaled * asarray(thickness_ratio) ** 0.516 + 0.6


LAW = Law(
    name="hill",
    title="Hill",
    quantity="hole_diameter",
    latex=(
        r"$D/d = 2.8 (\rho_p/\rho_t)^{-0.035} (v/C_t)^{0.335}$ $(v/C_p)^{0.113} (t/d)^{0.516} + 0.6$, $C_t$, $C_p$: "
        "sound speeds of target and projectile"
    ),
    source=(
        "constants read in public codes that cite nothing; attributed to Hill (2004), Int. J. "
        "Impact Eng. 30, 303, by its variables"
    ),
    confidence="cross-checked",
    range=Range(plate(), stated("materials, speeds and thicknesses of the shots of the fit", NOT_FOUND)),
    ratio=lambda shot, _: hole_ratio(
        shot.speed, shot.thickness_ratio, shot.density_ratio, shot.target.sound_speed, shot.projectile.sound_speed
    ),
    wider_than_projectile=True,
)
