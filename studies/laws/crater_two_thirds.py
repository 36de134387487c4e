"""Crater depth by the 2/3 law of energy scaling, with a constant fitted to one copper shot."""

from numpy import asarray
from numpy.typing import ArrayLike, NDArray

from studies.laws import FittedShot, Law, Range
from studies.laws._range import family, like_on_like, speed

# p = 14 mm for 0.5 g of copper (a sphere of 4.75 mm) on copper at 6.0 km/s, Ma (2005), Table 3.3.
FITTED_CONSTANT = 0.431  # for the density in g/cm3 and the speed in km/s


def depth_ratio(speed: ArrayLike, projectile_density: ArrayLike) -> NDArray:
    """Crater depth over projectile diameter; m/s, kg/m3; broadcasts.

    p/d = c rho_p^(1/3) v^(2/3): Ma (2005), Eq. 1-2; c fitted to a shot with 14 mm:

    >>> float((4.746 * depth_ratio(6000.0, 8930.0)).round(1))
    14.0
    """
    density, velocity = asarray(projectile_density) / 1e3, asarray(speed) / 1e3
    return FITTED_CONSTANT * density ** (1.0 / 3.0) * velocity ** (2.0 / 3.0)


LAW = Law(
    name="crater_two_thirds",
    title="2/3 law (constant fitted to one copper shot)",
    quantity="crater_depth",
    latex=r"$p/d = c \rho_p^{1/3} v^{2/3}$, $c = 0.431$ fitted, $\rho_p$ in g/cm3, $v$ in km/s",
    source=(
        "Ma (2005), Eq. 1-2; c fitted here to the experiment of its Table 3.3 (0.5 g copper sphere "
        "on copper at 6 km/s, depth 14 mm), from Wingate et al. (1993)"
    ),
    confidence="computed",
    range=Range(
        like_on_like("the shot of the fit"),
        family("copper", "the shot of the fit"),
        # With this c the law follows the depths of Ma (2005), Table 3.4, within 0.4 mm.
        speed(4.0, 7.0, "Ma (2005), Table 3.4"),
    ),
    fitted_to=(FittedShot(speed=6000.0, projectile_diameter=4.746e-3, value=14e-3),),
    ratio=lambda shot, _: depth_ratio(shot.speed, shot.projectile.density),
)
