"""Crater depth in laminates of carbon fibres, Ryan and Christiansen (2011); in cm, g/cm3 and km/s."""

from collections.abc import Mapping

from numpy import asarray
from numpy.typing import ArrayLike, NDArray

from studies.laws import Law, Range, Shot
from studies.laws._handbook import GRAM_PER_CUBIC_CENTIMETRE, HANDBOOK, KILOMETRE_PER_SECOND, RYAN
from studies.laws._range import family, speed, stated

# Constants with the root of the density ratio (2011), and with that of the projectile's density in g/cm3 (2009).
NEW, OLD = "Eq. 15 of 2011", "Eq. 4-13 of 2009"
CONSTANTS: Mapping[str, float] = {NEW: 0.62, OLD: 0.52}


def depth_ratio(speed: ArrayLike, density: ArrayLike, constant: ArrayLike) -> NDArray:
    """Crater depth over projectile diameter; m/s, rho_p over rho_t or rho_p in g/cm3, constant; broadcasts.

    p/d = c rho^(1/2) v^(2/3) with v in km/s: at 1 km/s and a density of 1 the printed constant.

    >>> [float(depth_ratio(1000.0, 1.0, c)) for c in CONSTANTS.values()]
    [0.62, 0.52]
    """
    velocity = asarray(speed) / KILOMETRE_PER_SECOND
    return asarray(constant) * asarray(density) ** 0.5 * velocity ** (2.0 / 3.0)


def _ratio(shot: Shot, variant: str) -> float:
    density = shot.projectile.density / GRAM_PER_CUBIC_CENTIMETRE
    scale = shot.density_ratio if variant == NEW else density
    return float(depth_ratio(shot.speed, scale, CONSTANTS[variant]))


LAW = Law(
    name="cfrp",
    title="Ryan and Christiansen (CFRP)",
    quantity="crater_depth",
    latex=(
        r"$p/d = 0.62 (\rho_p/\rho_t)^{1/2} (v \cos(\theta))^{2/3}$ (2011), $0.52 \rho_p^{1/2} (v \cos(\theta))^{2/3}$ "
        r"(2009), $\rho_p$ in g/cm3, $v$ in km/s"
    ),
    source=f"{RYAN}, 245, Eq. 15; {HANDBOOK}, Eq. 4-13 without insulation",
    confidence="verified",
    range=Range(family("cfrp", RYAN), speed(5.8, 6.6, RYAN), stated("quasi-isotropic laminate of 3.8 mm", RYAN)),
    ratio=_ratio,
    variants=lambda shot: list(CONSTANTS),
)
