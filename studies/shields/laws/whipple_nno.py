"""Critical diameter of a Whipple shield, Christiansen (1993), by three ranges of the normal speed."""

import math

from studies.laws._handbook import HANDBOOK
from studies.shields.laws._shields import (
    FAST,
    SIZE,
    STEEPEST,
    HandbookShield,
    by_three_ranges,
    in_si,
    range_of,
    shield_law,
)

SLOW = 3.0  # km/s of the normal speed, up to which the projectile stays whole


@in_si
def critical_diameter(shield: HandbookShield, speed: float, obliquity: float = 0.0) -> float:
    """Smallest projectile, m, that perforates the wall or detaches spall; m/s, kg/m3, rad.

    The shield of Fig. 4-4 of the handbook: bumper 0.12 cm of 2.713 g/cm3, 10 cm before 0.32 cm of 6061-T6 (40 ksi),
    hit by 2.796 g/cm3 at 1, 3, 5, 7 and 10 km/s, in cm:

    >>> from studies.shields.shield import Shield
    >>> shield = Shield(0.12e-2, 0.32e-2, 10e-2, 40 / 0.145038 * 1e6)
    >>> (100.0 * critical_diameter([1e3, 3e3, 5e3, 7e3, 10e3], 2713.0, 2796.0, shield)).round(4).tolist()
    [0.458, 0.2288, 0.3989, 0.569, 0.4486]
    """
    lean = min(obliquity, math.radians(STEEPEST))
    cosine = math.cos(lean)
    return by_three_ranges(
        speed * cosine, (SLOW, FAST), lambda normal: slow_diameter(shield, normal / cosine, lean), shield.fast_diameter
    )


def slow_diameter(shield: HandbookShield, speed: float, obliquity: float) -> float:
    """The limb of whole projectiles, cm; km/s, rad."""
    stopping = shield.wall * (shield.strength / 40.0) ** 0.5 + shield.bumper
    lean = math.cos(obliquity) ** (5.0 / 3.0)
    matter = 0.6 * lean * shield.projectile_density**0.5
    return float((stopping / (matter * speed ** (2.0 / 3.0))) ** SIZE)


LAW = shield_law(
    critical_diameter,
    name="whipple_nno",
    title="Christiansen, Whipple shield",
    equation=(
        "v_n <= 3: d = {[t_w (s/40)^0.5 + t_b] / [0.6 cos(theta)^(5/3) rho_p^0.5 v^(2/3)]}^(18/19); "
        "v_n >= 7: d = 3.918 t_w^(2/3) rho_p^(-1/3) rho_b^(-1/9) v_n^(-2/3) S^(1/3) (s/70)^(1/3); "
        "linear in v_n between; cm, g/cm3, km/s, s: yield stress of the wall in ksi"
    ),
    latex=(
        r"$v_n \leq 3$: "
        r"$d = \left(\frac{t_w (s/40)^{0.5} + t_b}{0.6 \cos(\theta)^{5/3} \rho_p^{0.5} v^{2/3}}\right)^{18/19}$; "
        r"$v_n \geq 7$: $d = 3.918 t_w^{2/3} \rho_p^{-1/3} \rho_b^{-1/9}$ $v_n^{-2/3} S^{1/3} (s/70)^{1/3}$; linear in "
        "$v_n$ between; cm, g/cm3, km/s, $s$: yield stress of the wall in ksi"
    ),
    source=f"Christiansen (1993), Int. J. Impact Eng. 14, 145; {HANDBOOK}, section 4",
    confidence="verified",
    range=range_of(HANDBOOK),
)
