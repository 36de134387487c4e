"""Hole in a thin plate, Lundeberg, Stern and Bristow (1965)."""

from numpy import asarray
from numpy.typing import ArrayLike, NDArray

from studies.laws import Law, Range
from studies.laws._range import NOT_FOUND, density_ratio, plate, stated

OF_DENSITY = 0.0308


def hole_ratio(
    speed: ArrayLike, thickness_ratio: ArrayLike, density_ratio: ArrayLike, sound_speed: ArrayLike
) -> NDArray:
    """Hole diameter over projectile diameter; both speeds in m/s, t/d, rho_p over rho_t; broadcasts.

    D/d = 3.4 (t/d)^(1/3) (v/C)^(1/3) (1 - 0.0308 rho_t/rho_p). Aluminium, 2.80 on 2.70 g/cm3 and 5.35 km/s, at 7 km/s
    and t/d = 0.25, where the form of Maiden has 2.15:

    >>> float(hole_ratio(7000.0, 0.25, 2.80 / 2.70, 5350.0).round(2))
    2.27
    """
    scaled = asarray(thickness_ratio) * asarray(speed) / asarray(sound_speed)
    return 3.4 * scaled ** (1.0 / 3.0) * (1.0 - OF_DENSITY / asarray(density_ratio))


LAW = Law(
    name="lundeberg",
    title="Lundeberg, Stern and Bristow",
    quantity="hole_diameter",
    latex=r"$D/d = 3.4 (t/d)^{1/3} (v/C)^{1/3}$ $(1 - 0.0308 \rho_t/\rho_p)$, $C$: bulk sound speed of the target",
    source="Lundeberg, Stern and Bristow (1965), NASA CR-54201",
    confidence="cross-checked",
    range=Range(
        density_ratio(OF_DENSITY, float("inf"), "computed from the equation", is_derived=True),
        plate(),
        stated("materials, speeds and thicknesses of the shots of the fit", NOT_FOUND),
    ),
    ratio=lambda shot, _: hole_ratio(shot.speed, shot.thickness_ratio, shot.density_ratio, shot.target.sound_speed),
    wider_than_projectile=True,
)
