"""Critical diameter of a Whipple shield with a bumper that may be thin, Ryan and Christiansen (2011)."""

import math

from studies.laws._handbook import RYAN
from studies.shields.laws._shields import FAST, STEEPEST, HandbookShield, ThinBumper, in_si, range_of, shield_law
from studies.shields.laws.whipple_nno import slow_diameter

# Onset of fragmentation, Piekutowski: 1.436 (t_b/d)^(-1/3) km/s, and 2.60 km/s from t_b/d = 0.16 on.
SHATTER, THICK_SHATTER, THICK = 1.436, 2.60, 0.16
SPACIOUS = 30.0  # S/d from which a thinner bumper shatters the projectile


@in_si
def critical_diameter(shield: HandbookShield, speed: float, obliquity: float = 0.0) -> float:
    """Smallest projectile, m, that perforates the wall or detaches spall; m/s, kg/m3, rad.

    Behind a bumper of at least a quarter of the diameter it is the equation of
    Christiansen (1993) from 7 km/s on, 0.3584 cm at 14 km/s in Fig. 4-4 of the handbook:

    >>> from studies.shields.shield import Shield
    >>> shield = Shield(0.12e-2, 0.32e-2, 10e-2, 40 / 0.145038 * 1e6)
    >>> float((100.0 * critical_diameter(14e3, 2713.0, 2796.0, shield)).round(4))
    0.3584
    """
    lean = min(obliquity, math.radians(STEEPEST))
    cosine = math.cos(lean)
    thin = ThinBumper(
        slow_diameter=lambda normal: slow_diameter(shield, normal / cosine, lean),
        shatter_speed=_shatter_speed,
        wall_ratio=lambda diameter: _wall_ratio(shield, diameter, cosine),
        critical_thickness=lambda stand_off: 0.20 if stand_off >= SPACIOUS else 0.25,
    )
    return shield.critical_diameter(speed * cosine, thin)


def _shatter_speed(thickness: float) -> float:
    return THICK_SHATTER if thickness >= THICK else SHATTER * thickness ** (-1.0 / 3.0)


def _wall_ratio(shield: HandbookShield, diameter: float, cosine: float) -> float:
    """Wall without a bumper over the wall behind a critical one, at a normal speed of 7 km/s.

    The bare wall is that of the slow limb: cos(theta)^(5/3) v^(2/3) = cos(theta) v_n^(2/3).
    """
    strength = shield.strength
    mass = shield.projectile_density * math.pi / 6.0 * diameter**3
    bare = 0.6 * cosine * diameter ** (19.0 / 18.0) * shield.projectile_density**0.5 * FAST ** (2.0 / 3.0)
    bare /= (strength / 40.0) ** 0.5
    densities = (shield.projectile_density * shield.bumper_density) ** (1.0 / 6.0)
    behind = 0.16 * diameter**0.5 * densities * mass ** (1.0 / 3.0) * FAST
    return bare / (behind * (70.0 / strength / shield.stand_off) ** 0.5)


LAW = shield_law(
    critical_diameter,
    name="whipple_jsc",
    title="Christiansen, thin bumpers",
    equation=(
        "that of Christiansen (1993) with shatter from v_n = 1.436 (t_b/d)^(-1/3) km/s on (2.60 km/s from "
        "t_b/d = 0.16) and F^(-2/3) from v_n = 7 km/s on, F = r - 2 x (r - 1) + x^2 (r - 1), "
        "x = (t_b/d)/(t_b/d)_crit < 1"
    ),
    latex=(
        "that of Christiansen (1993) with shatter from $v_n = 1.436 (t_b/d)^{-1/3}$ km/s on (2.60 km/s from "
        "$t_b/d = 0.16$) and $F^{-2/3}$ from $v_n = 7$ km/s on, $F = r - 2 x (r - 1) + x^2 (r - 1)$, "
        r"$x = (t_b/d)/(t_b/d)_{\text{crit}} < 1$"
    ),
    source=f"{RYAN}, 245, Eqs. 30 to 32, with the walls of r as coded in pyBLOSSUM, and the mass of a sphere",
    confidence="verified",
    range=range_of(RYAN),
)
