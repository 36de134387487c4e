"""Crater depth in titanium, the form of Cour-Palais of Ryan and Christiansen (2011); in cm, g/cm3 and km/s."""

from numpy import asarray
from numpy.typing import ArrayLike, NDArray

from studies.laws import Law, Range, without_hardness
from studies.laws._handbook import HANDBOOK, RYAN
from studies.laws._range import family, speed, stated


def depth_ratio(
    speed: ArrayLike, density_ratio: ArrayLike, sound_speed: ArrayLike, brinell_hardness: ArrayLike
) -> NDArray:
    """Crater depth over projectile diameter; m/s, rho_p over rho_t, m/s, Brinell number; broadcasts.

    p/d = 5.24 H^(-1/4) (rho_p/rho_t)^(1/2) (v/C)^(2/3); at the sound speed, with equal densities and H = 1, it is the
    printed constant:

    >>> float(depth_ratio(5000.0, 1.0, 5000.0, 1.0))
    5.24
    """
    mach = asarray(speed) / asarray(sound_speed)
    hardness = asarray(brinell_hardness) ** -0.25
    return 5.24 * hardness * asarray(density_ratio) ** 0.5 * mach ** (2.0 / 3.0)


LAW = Law(
    name="cour_palais_ti",
    title="Cour-Palais (titanium)",
    quantity="crater_depth",
    latex=r"$p/d = 5.24 H^{-1/4} (\rho_p/\rho_t)^{1/2} (v/C)^{2/3}$, $H$: BHN",
    source=f"{RYAN}, 245, Eq. 11; {HANDBOOK}, Eq. 4-7",
    confidence="verified",
    range=Range(family("titanium", RYAN), speed(6.4, 7.0, RYAN), stated("Ti-15V-3Cr-3Sn-3Al", RYAN)),
    ratio=lambda shot, _: depth_ratio(shot.speed, shot.density_ratio, shot.target.sound_speed, shot.brinell_hardness),
    meaningless=without_hardness,
)
