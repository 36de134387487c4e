"""Crater depth in fused silica and fused quartz, Ryan and Christiansen (2011); in cm, g/cm3 and km/s."""

from collections.abc import Mapping

from numpy import asarray
from numpy.typing import ArrayLike, NDArray

from studies.laws import Law, Range
from studies.laws._handbook import CENTIMETRE, GRAM_PER_CUBIC_CENTIMETRE, KILOMETRE_PER_SECOND, RYAN
from studies.laws._range import NOT_FOUND, family, stated

SIZE_EXPONENT = 19.0 / 18.0
CONSTANTS: Mapping[str, float] = {"fused silica": 0.53, "fused quartz": 0.758}


def depth_ratio(speed: ArrayLike, diameter: ArrayLike, projectile_density: ArrayLike, constant: ArrayLike) -> NDArray:
    """Crater depth over projectile diameter; m/s, m, kg/m3, constant of the glass; broadcasts.

    p = c d^(19/18) rho_p^(1/2) v^(2/3) in cm, g/cm3 and km/s: c for 1 cm of 1 g/cm3 at 1 km/s.

    >>> [float(depth_ratio(1e3, 1e-2, 1e3, c)) for c in CONSTANTS.values()]
    [0.53, 0.758]
    """
    size = (asarray(diameter) / CENTIMETRE) ** (SIZE_EXPONENT - 1.0)
    density = asarray(projectile_density) / GRAM_PER_CUBIC_CENTIMETRE
    velocity = asarray(speed) / KILOMETRE_PER_SECOND
    return asarray(constant) * size * density**0.5 * velocity ** (2.0 / 3.0)


LAW = Law(
    name="glass",
    title="Ryan and Christiansen (glass)",
    quantity="crater_depth",
    latex=(
        r"$p = c d^{19/18} \rho_p^{1/2} (v \cos(\theta))^{2/3}$, $p$, $d$ in cm, $\rho_p$ in g/cm3, $v$ in km/s; "
        "$c = 0.53$ (fused silica), $0.758$ (fused quartz)"
    ),
    source=f"{RYAN}, 245, Eq. 19",
    confidence="verified",
    size_exponent=SIZE_EXPONENT,
    range=Range(family("glass", RYAN), stated("speeds of the shots of the fit", NOT_FOUND)),
    ratio=lambda shot, variant: depth_ratio(
        shot.speed, shot.projectile_diameter, shot.projectile.density, CONSTANTS[variant]
    ),
    variants=lambda shot: list(CONSTANTS),
)
