"""Thickness below which an aluminium plate is perforated, Fish and Summers, after Cour-Palais (1987)."""

from collections.abc import Mapping

from numpy import asarray, pi
from numpy.typing import ArrayLike, NDArray

from studies.laws import Law, Range
from studies.laws._handbook import CENTIMETRE, COUR_PALAIS, GRAM_PER_CUBIC_CENTIMETRE, KILOMETRE_PER_SECOND
from studies.laws._range import family, speed, stated

CONSTANTS: Mapping[str, float] = {"2024-T3": 0.54, "1100-O": 0.52}
OF_MASS = 0.352


def thickness_ratio(
    speed: ArrayLike, diameter: ArrayLike, projectile_density: ArrayLike, constant: ArrayLike
) -> NDArray:
    """Threshold thickness over the diameter of a sphere; m/s, m, kg/m3, constant of the alloy; broadcasts.

    t = K rho_p^0.148 m^0.352 v^0.875 in cm, g, g/cm3 and km/s: for 1 g of 1 g/cm3, 1.2407 cm, at 1 km/s K.

    >>> [float((1.2407 * thickness_ratio(1e3, 1.2407e-2, 1e3, K)).round(4)) for K in CONSTANTS.values()]
    [0.54, 0.52]
    """
    size = asarray(diameter) / CENTIMETRE
    density = asarray(projectile_density) / GRAM_PER_CUBIC_CENTIMETRE
    mass = density * pi / 6.0 * size**3
    velocity = asarray(speed) / KILOMETRE_PER_SECOND
    return asarray(constant) * density**0.148 * mass**OF_MASS * velocity**0.875 / size


LAW = Law(
    name="fish_summers",
    title="Perforation, Fish and Summers",
    quantity="perforation_thickness",
    latex=(
        r"$t = K \rho_p^{0.148} m^{0.352} v^{0.875}$, $t$ in cm, $m$ in g, $\rho_p$ in g/cm3, $v$ in km/s; $K = 0.54$ "
        "(2024-T3), $0.52$ (1100-O)"
    ),
    source=f"{COUR_PALAIS}, Eq. 3",
    confidence="verified",
    size_exponent=3.0 * OF_MASS,
    range=Range(
        family("aluminium", f"{COUR_PALAIS}, Eq. 3"),
        speed(0.0, 8.5, f"{COUR_PALAIS}, Eq. 3"),
        stated("aluminium spheres of 0.16 cm; plates, not foils", f"{COUR_PALAIS}, Eq. 3"),
    ),
    ratio=lambda shot, variant: thickness_ratio(
        shot.speed, shot.projectile_diameter, shot.projectile.density, CONSTANTS[variant]
    ),
    variants=lambda shot: list(CONSTANTS),
)
