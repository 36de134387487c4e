"""Hole in a thin plate, Nysmith and Denardo (1969)."""

from numpy import asarray
from numpy.typing import ArrayLike, NDArray

from studies.laws import Law, Range
from studies.laws._handbook import GRAM_PER_CUBIC_CENTIMETRE, KILOMETRE_PER_SECOND
from studies.laws._range import NOT_FOUND, family, like_on_like, plate, stated


def hole_ratio(speed: ArrayLike, thickness_ratio: ArrayLike, projectile_density: ArrayLike) -> NDArray:
    """Hole diameter over projectile diameter; m/s, t/d, kg/m3; broadcasts.

    D/d = 0.88 (rho_p v)^0.5 (t/d)^0.45 with rho_p in g/cm3 and v in km/s; without the root of the density it would
    give 1.25 where the other laws have 2.1 to 2.4. Aluminium of 2.80 g/cm3 at 7 km/s and t/d = 0.25, where the form of
    Maiden has 2.15:

    >>> float(hole_ratio(7000.0, 0.25, 2800.0).round(2))
    2.09
    """
    density = asarray(projectile_density) / GRAM_PER_CUBIC_CENTIMETRE
    flux = density * asarray(speed) / KILOMETRE_PER_SECOND
    return 0.88 * flux**0.5 * asarray(thickness_ratio) ** 0.45


LAW = Law(
    name="nysmith_denardo",
    title="Nysmith and Denardo",
    quantity="hole_diameter",
    latex=r"$D/d = 0.88 (\rho_p v)^{0.5} (t/d)^{0.45}$, $\rho_p$ in g/cm3, $v$ in km/s",
    source="Nysmith and Denardo (1969), NASA TN D-5492",
    confidence="cross-checked",
    range=Range(
        like_on_like(NOT_FOUND),
        family("aluminium", NOT_FOUND),
        plate(),
        stated("aluminium spheres on 2024-T3 sheet", NOT_FOUND),
    ),
    ratio=lambda shot, _: hole_ratio(shot.speed, shot.thickness_ratio, shot.projectile.density),
    wider_than_projectile=True,
)
