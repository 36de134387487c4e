"""Crater diameter as twice the depth: the limit of fast impacts, an indication at any other speed."""

from numpy.typing import ArrayLike, NDArray

from studies.laws import Law, Range, charters_summers
from studies.laws._range import stated


def diameter_ratio(speed: ArrayLike, density_ratio: ArrayLike, sound_speed: ArrayLike) -> NDArray:
    """Crater diameter over projectile diameter; both speeds in m/s, rho_p over rho_t; broadcasts.

    D = 2 p with p by Charters and Summers. A copper sphere of 4.746 mm on copper at 6 km/s, where the experiment has
    25.4 mm and p/D = 0.55:

    >>> float((4.746 * diameter_ratio(6000.0, 1.0, 3940.0)).round(1))
    28.6
    """
    return 2.0 * charters_summers.depth_ratio(speed, density_ratio, sound_speed)


LAW = Law(
    name="crater_hemisphere",
    title="Hemisphere, D = 2 p",
    quantity="crater_diameter",
    latex=r"$D = 2 p$, $p$ by Charters and Summers",
    source="Ma (2005), section 1.2.1: p/D tends to 0.5 with the speed",
    confidence="indicative",
    range=Range(
        *charters_summers.LAW.range.limits,
        stated("hemispheres; metals have p/D of 0.5 to 0.6", "Ma (2005), Tables 3.3 and 3.4"),
    ),
    ratio=lambda shot, _: diameter_ratio(shot.speed, shot.density_ratio, shot.target.sound_speed),
)
