"""Hole in a plate with the strength of the target, Zhang and Huang (2000)."""

import numpy as np
from numpy.typing import ArrayLike, NDArray

from studies.laws import Law, Range, Shot
from studies.laws._range import stated, thickness_ratio


def hole_ratio(speed: ArrayLike, yield_stress: ArrayLike, density: ArrayLike) -> NDArray:
    """Hole diameter over projectile diameter; m/s, Pa, kg/m3; broadcasts.

    D/d = 1.68 ln(v / sqrt(Y/rho)) - 1.91: Ma (2005), Eq. 1-5. Aluminium 2024-T3, Y = 345 MPa and
    2780 kg/m3, at 6 km/s, where Eq. 1-3 has 2.821 for t/d = 0.6:

    >>> float(hole_ratio(6000.0, 345e6, 2780.0).round(3))
    2.853
    """
    strength_speed = np.sqrt(np.asarray(yield_stress) / np.asarray(density))
    return 1.68 * np.log(np.asarray(speed) / strength_speed) - 1.91


def _yields(shot: Shot) -> dict[str, float]:
    """The yield stresses that the target states, Pa, by their labels."""
    return {stated.label: stated.value for stated in shot.target.yield_stresses}


LAW = Law(
    name="strength_ln",
    title="Zhang and Huang (strength)",
    quantity="hole_diameter",
    equation="D/d = 1.68 ln(v / sqrt(Y/rho)) - 1.91, v and sqrt(Y/rho) in the same unit",
    latex=r"$D/d = 1.68 \ln(v / \sqrt{Y/\rho}) - 1.91$, $v$ and $\sqrt{Y/\rho}$ in the same unit",
    source=("Ma (2005), Eq. 1-5, after Zhang and Huang (2000), Introduction to hypervelocity impact dynamics"),
    confidence="read",
    range=Range(
        # Fitted to shots with t/d = 0.6 and free of t/d itself: what rounds to 0.6 is inside.
        thickness_ratio(0.55, 0.65, "Ma (2005), section 3.1.1"),
        # With 2024-T3 it meets Eqs. 1-3 and 1-4 at t/d = 0.6 within 3 % from 4 to 7 km/s.
        stated("probably fitted to aluminium", "computed from Eqs. 1-3 and 1-4", is_derived=True),
    ),
    ratio=lambda shot, variant: hole_ratio(shot.speed, _yields(shot)[variant], shot.target.density),
    variants=lambda shot: list(_yields(shot)),
    wider_than_projectile=True,
)
