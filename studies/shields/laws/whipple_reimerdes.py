"""Critical diameter of a Whipple shield, Reimerdes, Noelke and Schaefer (2006), with a bumper that may be thin."""

import math

from studies.laws.plates import ALUMINIUM as FACTORS
from studies.laws.reimerdes import OF_ALUMINIUM, OF_MASS
from studies.shields.laws._shields import FAST, SIZE, HandbookShield, ThinBumper, in_si, range_of, shield_law

SOURCE = "Reimerdes, Noelke and Schaefer (2006), Int. J. Impact Eng. 33, 645"
CRITICAL = 0.2  # t_b/d


@in_si
def critical_diameter(shield: HandbookShield, speed: float) -> float:
    """Smallest projectile, m, that perforates the wall at normal impact; m/s, kg/m3.

    Behind a bumper of at least a fifth of the diameter it is the equation of Christiansen (1993) from 7 km/s on, in cm
    0.569 at 7 km/s and 0.3584 at 14 km/s in Fig. 4-4 of the handbook:

    >>> from studies.shields.shield import Shield
    >>> shield = Shield(0.12e-2, 0.32e-2, 10e-2, 40 / 0.145038 * 1e6)
    >>> (100.0 * critical_diameter([7e3, 14e3], 2713.0, 2796.0, shield)).round(4).tolist()
    [0.569, 0.3584]
    """
    thin = ThinBumper(
        slow_diameter=lambda normal: _slow_diameter(shield, normal),
        # The text of the paper drops the minus sign: thinner bumpers shatter later.
        shatter_speed=lambda thickness: 1.853 + 0.397 * thickness**-0.565,
        wall_ratio=lambda diameter: _wall_ratio(shield, diameter),
        critical_thickness=lambda stand_off: CRITICAL,
    )
    return shield.critical_diameter(speed, thin)


def _slow_diameter(shield: HandbookShield, speed: float) -> float:
    stopping = shield.wall / FACTORS["perforation"] + shield.bumper
    matter = 0.796 * OF_ALUMINIUM * shield.projectile_density**0.518
    return float((stopping / (matter * speed ** (2.0 / 3.0))) ** SIZE)


def _wall_ratio(shield: HandbookShield, diameter: float) -> float:
    """Wall without a bumper over the wall behind a critical one, at 7 km/s."""
    density = shield.projectile_density
    mass = density * math.pi / 6.0 * diameter**3
    depth = OF_ALUMINIUM * mass**OF_MASS * density ** (1.0 / 6.0) * FAST ** (2.0 / 3.0)
    behind = 0.178 * mass**0.5 * shield.bumper_density ** (1.0 / 6.0) * FAST
    behind *= (70.0 / shield.strength / shield.stand_off) ** 0.5
    return FACTORS["perforation"] * depth / behind


LAW = shield_law(
    critical_diameter,
    name="whipple_reimerdes",
    title="Reimerdes, Whipple shield",
    equation=(
        "v <= v_s: d = {(t_w/1.8 + t_b) / [0.796 x 0.42 rho_p^0.518 v^(2/3)]}^(18/19), "
        "v_s = 1.853 + 0.397 (t_b/d)^-0.565; v >= 7: that of Christiansen (1993) times F^(-2/3), "
        "F = r - 10 (t_b/d) (r - 1) + 25 (t_b/d)^2 (r - 1) for t_b/d < 0.2; linear in v between; cm, g/cm3, km/s"
    ),
    latex=(
        r"$v \leq v_s$: $d = \left(\frac{t_w/1.8 + t_b}{0.796 \times 0.42 \rho_p^{0.518} v^{2/3}}\right)^{18/19}$, "
        r"$v_s = 1.853 + 0.397 (t_b/d)^{-0.565}$; $v \geq 7$: that of Christiansen (1993) times $F^{-2/3}$, "
        "$F = r - 10 (t_b/d) (r - 1)$ ${}+ 25 (t_b/d)^2 (r - 1)$ for $t_b/d < 0.2$; linear in $v$ between; cm, g/cm3, "
        "km/s"
    ),
    source=f"{SOURCE}, with 1.8 and r as coded in pyBLOSSUM, and the mass of a sphere",
    confidence="verified",
    # Table 1 of the paper: k is 1.8 for no perforation, and would be 2.2 for no detached spall.
    range=range_of(SOURCE, fails="perforated (k = 1.8; no detached spall would be 2.2)"),
    oblique=False,
)
