"""Critical diameters of shields of two and of three walls, Schaefer, Ryan and Lambert (2008)."""

import math

from studies.laws import Reason, Shot
from studies.laws._range import stated
from studies.shields.laws._shields import (
    FAST,
    SIZE,
    HandbookShield,
    ShieldCode,
    by_three_ranges,
    in_si,
    range_of,
    shield_law,
    without_yield_stress,
)
from studies.shields.laws.whipple_nno import SLOW
from studies.shields.shield import shield_of

SOURCE = "Schaefer, Ryan, Lambert and Putzar (2008), Int. J. Impact Eng. 35, 1784"
PROGRAM = (
    "NASA/TM-2009-214789"  # Ryan and Christiansen (2009), which prints the equations and what they are validated for
)
K3S, K3D, K_TW, K_S2 = 1.4, 0.4, 1.5, 0.1
BETA, GAMMA = 2.0 / 3.0, 1.0 / 3.0
# Exponents delta and epsilon of the cosine: of 0 to 45 deg and from 65 deg on, and between.
UPRIGHT, LEANING = (4.0 / 3.0, 8.0 / 3.0), (5.0 / 4.0, 10.0 / 4.0)


@in_si
def critical_diameter(shield: HandbookShield, speed: float, obliquity: float = 0.0) -> float:
    """Smallest projectile, m, that detaches spall or perforates the wall; m/s, kg/m3, rad.

    Two walls, 0.12 cm, 10 cm before 0.32 cm (40 ksi); then three, 0.13 cm, 3.8 cm before 0.2 cm, 3.8 cm before 0.32 cm
    (57 ksi); 2.713 g/cm3, hit by 2.796 g/cm3 at 1, 3, 5, 7, 10 and 14 km/s, in cm; computed apart from this code:

    >>> from studies.shields.shield import FurtherBumper, Shield
    >>> two = Shield(0.12e-2, 0.32e-2, 10e-2, 40 / 0.145038 * 1e6)
    >>> three = Shield(0.13e-2, 0.32e-2, 3.8e-2, 57 / 0.145038 * 1e6, further_bumpers=(FurtherBumper(0.2e-2, 3.8e-2),))
    >>> speeds = [1e3, 3e3, 5e3, 7e3, 10e3, 14e3]
    >>> (100.0 * critical_diameter(speeds, 2713.0, 2796.0, two)).round(4).tolist()
    [0.3673, 0.1835, 0.2462, 0.309, 0.2436, 0.1946]
    >>> (100.0 * critical_diameter(speeds, 2713.0, 2796.0, three)).round(4).tolist()
    [0.7906, 0.395, 0.4343, 0.4737, 0.3734, 0.2984]
    """
    exponents = LEANING if 45.0 < math.degrees(obliquity) < 65.0 else UPRIGHT
    cosine = math.cos(obliquity)
    return by_three_ranges(
        speed,
        (SLOW / cosine, FAST / cosine),
        lambda slow: _slow_diameter(shield, slow, cosine, exponents[0]),
        lambda fast: _fast_diameter(shield, fast, cosine, *exponents),
    )


def _slow_diameter(shield: HandbookShield, speed: float, cosine: float, delta: float) -> float:
    """Equations 58 and 65 of the program's report, cm; km/s. Three walls take the root of the wall's thickness."""
    walls = shield.wall**0.5 + shield.second_bumper if shield.second_bumper else shield.wall
    stopping = walls / K3S * (shield.strength / 40.0) ** 0.5 + shield.bumper
    matter = 0.6 * cosine**delta * shield.projectile_density**0.5
    return float((stopping / (matter * speed ** (2.0 / 3.0))) ** SIZE)


def _fast_diameter(shield: HandbookShield, speed: float, cosine: float, delta: float, epsilon: float) -> float:
    """Equations 59 and 66 of the program's report, cm; km/s."""
    walls = shield.stand_off ** (1.0 / 3.0) * shield.wall ** (2.0 / 3.0)
    if shield.second_bumper:
        walls = shield.stand_off ** (1.0 / 3.0) * (shield.second_bumper + K_TW * shield.wall) ** (2.0 / 3.0)
        walls += K_S2 * shield.second_stand_off**BETA * shield.wall**GAMMA * cosine**-epsilon
    matter = K3D ** (2.0 / 3.0) * shield.projectile_density ** (1.0 / 3.0) * shield.bumper_density ** (1.0 / 9.0)
    strength = (shield.strength / 70.0) ** (1.0 / 3.0)
    return float(1.155 * walls * strength / (matter * speed ** (2.0 / 3.0) * cosine**delta))


def _without_second_bumper(shot: Shot, variant: str = "") -> Reason | None:
    """Why a shot has no critical diameter of three walls; None where it meets a shield of three."""
    shield = shield_of(shot)
    if shield is None or len(shield.further_bumpers) != 1:
        return Reason(ShieldCode.THREE_WALLS)
    return without_yield_stress(shield)


VALIDATED = stated(
    "validated at 2 to 8 km/s, 0, 45 and 60 deg, with aluminium of 0.8 to 5 mm; applied to all",
    f"{PROGRAM}, Tables 12 and 14",
)
LAW = (
    shield_law(
        critical_diameter,
        name="whipple_srl",
        title="Schaefer, Ryan and Lambert, two walls",
        equation=(
            "v_n <= 3: d = {[t_w/1.4 (s/40)^0.5 + t_b] / [0.6 cos(theta)^delta rho_p^0.5 v^(2/3)]}^(18/19); "
            "v_n >= 7: d = 1.155 S^(1/3) t_w^(2/3) (s/70)^(1/3) / [0.4^(2/3) rho_p^(1/3) rho_b^(1/9) v^(2/3) "
            "cos(theta)^delta]; linear in v between; delta = 4/3, between 45 and 65 deg 5/4; cm, g/cm3, km/s, "
            "s: yield stress of the wall in ksi"
        ),
        latex=(
            r"$v_n \leq 3$: $d = \left(\frac{t_w/1.4 (s/40)^{0.5} + t_b}{0.6 \cos(\theta)^\delta \rho_p^{0.5} "
            r"v^{2/3}}\right)^{18/19}$; $v_n \geq 7$: $d = \frac{1.155 S^{1/3} t_w^{2/3} (s/70)^{1/3}}{0.4^{2/3} "
            r"\rho_p^{1/3} \rho_b^{1/9} v^{2/3} \cos(\theta)^\delta}$; linear in $v$ between; $\delta = 4/3$, between "
            "45 and 65 deg $5/4$; cm, g/cm3, km/s, $s$: yield stress of the wall in ksi"
        ),
        source=f"{SOURCE}; {PROGRAM}, Eqs. 58 to 60",
        confidence="read",
        range=range_of(SOURCE, VALIDATED),
    ),
    shield_law(
        critical_diameter,
        name="whipple_srl_three_walls",
        title="Schaefer, Ryan and Lambert, three walls",
        equation=(
            "v_n <= 3: d = {[(t_w^0.5 + t_i)/1.4 (s/40)^0.5 + t_b] / [0.6 cos(theta)^delta rho_p^0.5 v^(2/3)]}^(18/19)"
            "; v_n >= 7: d = 1.155 [S_1^(1/3) (t_i + 1.5 t_w)^(2/3) + 0.1 S_2^(2/3) t_w^(1/3) cos(theta)^-epsilon] "
            "(s/70)^(1/3) / [0.4^(2/3) rho_p^(1/3) rho_b^(1/9) v^(2/3) cos(theta)^delta]; linear in v between; delta = "
            "4/3, epsilon = 8/3, between 45 and 65 deg 5/4 and 10/4; t_i: second bumper, S_1 before and S_2 behind it; "
            "cm, g/cm3, km/s, s: yield stress of the wall in ksi"
        ),
        latex=(
            r"$v_n \leq 3$: $d = \left(\frac{(t_w^{0.5} + t_i)/1.4 (s/40)^{0.5} + t_b}{0.6 \cos(\theta)^\delta "
            r"\rho_p^{0.5} v^{2/3}}\right)^{18/19}$; $v_n \geq 7$: $d = \frac{1.155 [S_1^{1/3} (t_i + 1.5 t_w)^{2/3} + "
            r"0.1 S_2^{2/3} t_w^{1/3} \cos(\theta)^{-\varepsilon}] (s/70)^{1/3}}{0.4^{2/3} \rho_p^{1/3} \rho_b^{1/9} "
            r"v^{2/3} \cos(\theta)^\delta}$; linear in $v$ between; $\delta = 4/3$, $\varepsilon = 8/3$, between 45 "
            "and 65 deg $5/4$ and $10/4$; $t_i$: second bumper, $S_1$ before and $S_2$ behind it; cm, g/cm3, km/s, "
            "$s$: yield stress of the wall in ksi"
        ),
        source=f"{SOURCE}, Eqs. 1 to 4; {PROGRAM}, Eqs. 65 to 67",
        confidence="read",
        range=range_of(SOURCE, VALIDATED, walls=_without_second_bumper),
        meaningless=_without_second_bumper,
    ),
)
