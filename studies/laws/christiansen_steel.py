"""Crater depth in stainless steel 15-5PH, Christiansen et al. (2009); in cm, g/cm3 and km/s."""

from numpy import asarray
from numpy.typing import ArrayLike, NDArray

from studies.laws import Law, Range
from studies.laws._handbook import CENTIMETRE, HANDBOOK, KILOMETRE_PER_SECOND
from studies.laws._range import NOT_FOUND, family, stated

SIZE_EXPONENT = 19.0 / 18.0
# Eq. 4-10 prints 0.434, with which Eq. 4-12 would not have its 1.57; Ryan and Christiansen (2011) print 0.345.
CONSTANT = 0.345


def depth_ratio(speed: ArrayLike, diameter: ArrayLike, density_ratio: ArrayLike) -> NDArray:
    """Crater depth over projectile diameter; m/s, m, rho_p over rho_t; broadcasts.

    p = 0.345 d^(19/18) (rho_p/rho_t)^(1/2) v^(2/3) with p and d in cm and v in km/s. A plate is perforated up to 1.8 p
    thick, which is 1 cm for the constant of Eq. 4-12, d = 1.57 cm at 1 km/s:

    >>> round(float(1.8 * 1.57 * depth_ratio(1000.0, 1.57e-2, 1.0)), 2)
    1.0
    """
    size = (asarray(diameter) / CENTIMETRE) ** (SIZE_EXPONENT - 1.0)
    velocity = asarray(speed) / KILOMETRE_PER_SECOND
    return CONSTANT * size * asarray(density_ratio) ** 0.5 * velocity ** (2.0 / 3.0)


LAW = Law(
    name="christiansen_steel",
    title="Christiansen (steel 15-5PH)",
    quantity="crater_depth",
    latex=r"$p = 0.345 d^{19/18} (\rho_p/\rho_t)^{1/2} (v \cos(\theta))^{2/3}$, $p$, $d$ in cm, $v$ in km/s",
    source=f"Christiansen et al. (2009), {HANDBOOK}, Eq. 4-10, with the constant of Eq. 4-12",
    confidence="verified",
    size_exponent=SIZE_EXPONENT,
    range=Range(family("steel", HANDBOOK), stated("CRES 15-5PH; speeds of the shots of the fit", NOT_FOUND)),
    ratio=lambda shot, _: depth_ratio(shot.normal_speed, shot.projectile_diameter, shot.density_ratio),
)
