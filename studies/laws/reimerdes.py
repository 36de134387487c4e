"""Crater depth in aluminium with the mass of the projectile, Reimerdes, Noelke and Schaefer (2006)."""

from numpy import asarray, pi
from numpy.typing import ArrayLike, NDArray

from studies.laws import Law, Range
from studies.laws._handbook import CENTIMETRE, GRAM_PER_CUBIC_CENTIMETRE, KILOMETRE_PER_SECOND
from studies.laws._range import NOT_FOUND, family, stated

SOURCE = "Reimerdes, Noelke and Schaefer (2006), Int. J. Impact Eng. 33, 645, Eq. 9"
OF_ALUMINIUM = 0.42
OF_MASS = 0.352


def depth_ratio(speed: ArrayLike, diameter: ArrayLike, projectile_density: ArrayLike) -> NDArray:
    """Crater depth over the diameter of a sphere; m/s, m, kg/m3; broadcasts.

    p = 0.42 m^0.352 rho_p^(1/6) v^(2/3) in cm, g, g/cm3 and km/s: for 1 g of 1 g/cm3, 1.2407 cm, at 1 km/s the printed
    constant.

    >>> float((1.2407 * depth_ratio(1e3, 1.2407e-2, 1e3)).round(4))
    0.42
    """
    size = asarray(diameter) / CENTIMETRE
    density = asarray(projectile_density) / GRAM_PER_CUBIC_CENTIMETRE
    mass = density * pi / 6.0 * size**3
    velocity = asarray(speed) / KILOMETRE_PER_SECOND
    depth = OF_ALUMINIUM * mass**OF_MASS * density ** (1.0 / 6.0) * velocity ** (2.0 / 3.0)
    return depth / size


LAW = Law(
    name="reimerdes",
    title="Reimerdes (aluminium)",
    quantity="crater_depth",
    latex=r"$p = 0.42 m^{0.352} \rho_p^{1/6} v^{2/3}$, $p$ in cm, $m$ in g, $\rho_p$ in g/cm3, $v$ in km/s",
    source=SOURCE,
    confidence="verified",
    size_exponent=3.0 * OF_MASS,
    range=Range(family("aluminium", SOURCE), stated("speeds of the shots of the fit", NOT_FOUND)),
    ratio=lambda shot, _: depth_ratio(shot.speed, shot.projectile_diameter, shot.projectile.density),
)
