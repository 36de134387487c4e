"""Critical diameter of a Whipple shield, Christiansen and Kerr (2001), who add the bumper's thickness to that of 1993.

Which branch of k_h, and which power of the stand-off: the paper prints "k_h = 1.35 unless t_b/(t_w^(2/3) S^(1/2)) <
0.126, then k_h = 7.451 t_b/(t_w^(2/3) S^(1/3)) + 0.411", with two exponents of S in one sentence. S^(1/2) is taken in
both places: 7.451 * 0.126 + 0.411 = 1.350, so that the branches meet with one exponent alone; the paper's equation 1
has S^(1/2) t_w^(2/3); and of the shots of the collection pyBLOSSUM this reading
catches 93 % of the failures, where the paper states more than 90 % of its own and S^(1/3) catches 87 %. pyBLOSSUM
(commit fe0a7df) has S^(1/3) in both places and the branches the other way round, 1.35 below 0.126: there k_h grows
without bound with the bumper and 67 % of the failures are caught. A bumper can be too thin and hardly too thick to
shatter the projectile, so that the text of the paper is followed.
"""

import math

from studies.shields.laws._shields import FAST, STEEPEST, HandbookShield, by_three_ranges, in_si, range_of, shield_law
from studies.shields.laws.whipple_nno import SLOW

SOURCE = "Christiansen and Kerr (2001), Int. J. Impact Eng. 26, 93"
THICK = 0.126  # t_b / (t_w^(2/3) S^(1/2)), cm^(-1/6), from which a thicker bumper changes nothing


@in_si
def critical_diameter(shield: HandbookShield, speed: float, obliquity: float = 0.0) -> float:
    """Smallest projectile, m, that perforates the wall or detaches spall; m/s, kg/m3, rad.

    The shield of Fig. 4 of the paper, 0.12 cm, 10 cm before 0.32 cm of 6061-T6 (40 ksi, 2.713 g/cm3), hit by
    2.796 g/cm3 at 1, 3, 5, 7, 10 and 14 km/s, in cm; computed apart from this code:

    >>> from studies.shields.shield import Shield
    >>> shield = Shield(0.12e-2, 0.32e-2, 10e-2, 40 / 0.145038 * 1e6)
    >>> (100.0 * critical_diameter([1e3, 3e3, 5e3, 7e3, 10e3, 14e3], 2713.0, 2796.0, shield)).round(4).tolist()
    [0.5005, 0.2406, 0.3308, 0.421, 0.3319, 0.2652]
    """
    lean = min(obliquity, math.radians(STEEPEST))
    cosine = math.cos(lean)
    return by_three_ranges(
        speed,
        (SLOW / cosine**1.5, FAST / cosine),
        lambda slow: _slow_diameter(shield, slow, cosine),
        lambda fast: _fast_diameter(shield, fast * cosine),
    )


def _slow_diameter(shield: HandbookShield, speed: float, cosine: float) -> float:
    """Equation 3 of the paper, cm; km/s."""
    stopping = shield.wall * (shield.strength / 40.0) ** 0.5 + 0.37 * shield.bumper * shield.bumper_density
    return float(1.9 * stopping * cosine ** (-11.0 / 6.0) * shield.projectile_density**-0.5 * speed ** (-2.0 / 3.0))


def _fast_diameter(shield: HandbookShield, normal_speed: float) -> float:
    """Equation 1 of the paper, cm; km/s."""
    thickness = shield.bumper / (shield.wall ** (2.0 / 3.0) * shield.stand_off**0.5)
    factor = 1.35 if thickness >= THICK else 7.451 * thickness + 0.411
    densities = shield.projectile_density ** (-1.0 / 3.0) * shield.bumper_density ** (-1.0 / 9.0)
    wall = (shield.wall * shield.wall_density) ** (2.0 / 3.0) * (shield.strength / 70.0) ** (1.0 / 3.0)
    return float(factor * densities * normal_speed ** (-2.0 / 3.0) * shield.stand_off**0.5 * wall)


LAW = shield_law(
    critical_diameter,
    name="whipple_nno_modified",
    title="Christiansen and Kerr, Whipple shield",
    equation=(
        "v <= 3/cos(theta)^1.5: d = 1.9 [t_w (s/40)^0.5 + 0.37 t_b rho_b] cos(theta)^(-11/6) rho_p^-0.5 v^(-2/3); "
        "v_n >= 7: d = k_h rho_p^(-1/3) v_n^(-2/3) rho_b^(-1/9) S^(1/2) (t_w rho_w)^(2/3) (s/70)^(1/3), "
        "k_h = 1.35 for x = t_b/(t_w^(2/3) S^(1/2)) >= 0.126, else 7.451 x + 0.411; linear in v between; "
        "cm, g/cm3, km/s, s: yield stress of the wall in ksi"
    ),
    latex=(
        r"$v \leq 3/\cos(\theta)^{1.5}$: $d = 1.9 [t_w (s/40)^{0.5} + 0.37 t_b \rho_b]$ "
        r"$\cos(\theta)^{-11/6} \rho_p^{-0.5} v^{-2/3}$; $v_n \geq 7$: "
        r"$d = k_h \rho_p^{-1/3} v_n^{-2/3} \rho_b^{-1/9} S^{1/2}$ $(t_w \rho_w)^{2/3} (s/70)^{1/3}$, $k_h = 1.35$ for "
        r"$x = t_b/(t_w^{2/3} S^{1/2}) \geq 0.126$, else $7.451 x + 0.411$; linear in $v$ between; cm, g/cm3, km/s, "
        "$s$: yield stress of the wall in ksi"
    ),
    source=f"{SOURCE}, Eqs. 1 to 3, with S^(1/2) where its text has S^(1/2) and S^(1/3)",
    confidence="read",
    range=range_of(SOURCE),
)
