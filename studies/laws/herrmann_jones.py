"""Crater depth in a thick block of metal, Herrmann and Jones (1961), with the hardness of the target."""

import numpy as np
from numpy.typing import ArrayLike, NDArray

from studies.laws import Law, Range, without_hardness
from studies.laws._handbook import BRINELL
from studies.laws._range import NOT_FOUND, speed, stated


def depth_ratio(
    speed: ArrayLike, density_ratio: ArrayLike, target_density: ArrayLike, brinell_hardness: ArrayLike
) -> NDArray:
    """Crater depth over projectile diameter; m/s, rho_p over rho_t, kg/m3, Brinell number; broadcasts.

    p/d = 0.6 R ln[1 + R rho_t v^2 / (4 H)] with R = (rho_p/rho_t)^(2/3) and H the Brinell number as a pressure. A
    copper sphere of 4.746 mm on copper of BHN 50 at 6 km/s, where the experiment has 14 mm (Ma (2005), Table 3.3):

    >>> float((4.746 * depth_ratio(6000.0, 1.0, 8930.0, 50.0)).round(1))
    14.5
    """
    scale = np.asarray(density_ratio) ** (2.0 / 3.0)
    hardness = np.asarray(brinell_hardness) * BRINELL
    best = np.asarray(target_density) * np.asarray(speed) ** 2 / hardness
    return 0.6 * scale * np.log1p(0.25 * scale * best)


LAW = Law(
    name="herrmann_jones",
    title="Herrmann and Jones",
    quantity="crater_depth",
    latex=(
        r"$p/d = 0.6 (\rho_p/\rho_t)^{2/3}$ $\ln[1 + (\rho_p/\rho_t)^{2/3} \rho_t v^2 / (4 H)]$, $H$: Brinell hardness "
        "of the target as a pressure"
    ),
    source="Herrmann and Jones (1961)",
    confidence="cross-checked",
    range=Range(speed(1.0, 8.0, NOT_FOUND), stated("metals", NOT_FOUND)),
    ratio=lambda shot, _: depth_ratio(shot.speed, shot.density_ratio, shot.target.density, shot.brinell_hardness),
    meaningless=without_hardness,
)
