"""Crater volume in proportion to the energy of the projectile, with a constant fitted to one copper shot."""

from numpy import asarray, pi
from numpy.typing import ArrayLike, NDArray

from studies.laws import Law, Range, crater_two_thirds
from studies.laws._range import stated

# A hemisphere of 14 mm for 0.5 g of copper at 6.0 km/s, Ma (2005), Table 3.3.
FITTED_CONSTANT = 0.639e-9  # m3/J


def volume_ratio(speed: ArrayLike, projectile_density: ArrayLike) -> NDArray:
    """Crater volume over the cube of the projectile's diameter; m/s, kg/m3; broadcasts.

    V = K E: Ma (2005), Eq. 1-1. The energy of a sphere is (pi/12) rho_p d^3 v^2. In cm3, a copper sphere of 4.746 mm at
    6 km/s, where a hemisphere of 14 mm has 5.75 cm3:

    >>> float((0.4746**3 * volume_ratio(6000.0, 8930.0)).round(2))
    5.75
    """
    energy = pi / 12.0 * asarray(projectile_density) * asarray(speed) ** 2  # over d^3
    return FITTED_CONSTANT * energy


LAW = Law(
    name="crater_volume_energy",
    title="Volume over energy (constant fitted to one copper shot)",
    quantity="crater_volume",
    equation="V = K E, K = 0.639 mm3/J fitted, E: kinetic energy of the projectile",
    latex=r"$V = K E$, $K = 0.639$ mm3/J fitted, $E$: kinetic energy of the projectile",
    source=f"Ma (2005), Eq. 1-1; K from the depth of a hemisphere: {crater_two_thirds.LAW.source}",
    confidence="computed",
    dimension=3,
    size_exponent=3.0,
    range=Range(*crater_two_thirds.LAW.range.limits, stated("hemispheres", "the constant of the fit")),
    ratio=lambda shot, _: volume_ratio(shot.speed, shot.projectile.density),
)
