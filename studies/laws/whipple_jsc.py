"""Critical diameter of a Whipple shield with a bumper that may be thin, Ryan and Christiansen (2011)."""

import math

import numpy as np
from numpy.typing import ArrayLike, NDArray

from studies.laws import Law, Shield, Shot
from studies.laws._handbook import CENTIMETRE, KILOMETRE_PER_SECOND, RYAN
from studies.laws._shields import (
    FAST,
    HandbookShield,
    between_limbs,
    in_handbook_units,
    range_of,
    without_shield,
)
from studies.laws.whipple_nno import slow_diameter

# Onset of fragmentation, Piekutowski: 1.436 (t_b/d)^(-1/3) km/s, and 2.60 km/s from t_b/d = 0.16 on.
SHATTER, THICK_SHATTER, THICK = 1.436, 2.60, 0.16


def critical_diameter(
    speed: ArrayLike, bumper_density: float, projectile_density: float, shield: Shield
) -> NDArray:
    """Smallest projectile, m, that perforates the wall or detaches spall at normal impact; broadcasts over the speed.

    Speed in m/s, densities in kg/m3. Behind a bumper of at least a quarter of the diameter it is the equation of
    Christiansen (1993) from 7 km/s on, 0.3584 cm at 14 km/s in Fig. 4-4 of the handbook:

    >>> shield = Shield(0.12e-2, 0.32e-2, 10e-2, 40 / 0.145038 * 1e6)
    >>> float((100.0 * critical_diameter(14e3, 2713.0, 2796.0, shield)).round(4))
    0.3584
    """
    matter = in_handbook_units(shield, bumper_density, projectile_density)
    found = [
        _critical(matter, each) * CENTIMETRE
        for each in np.ravel(np.asarray(speed) / KILOMETRE_PER_SECOND)
    ]
    return np.reshape(np.array(found), np.shape(speed))


def _critical(shield: HandbookShield, speed: float) -> float:
    slow = _shatter_speed(shield)
    if speed <= slow:
        return slow_diameter(shield, speed, 0.0)
    if speed >= FAST:
        return shield.thin_bumper_diameter(speed, lambda diameter: _wall_ratio(shield, diameter))
    ends = (slow_diameter(shield, slow, 0.0), _critical(shield, FAST))
    return between_limbs(speed, slow, *ends)


def _shatter_speed(shield: HandbookShield) -> float:
    """The speed, km/s, at which the projectile on the limb of strength breaks at the bumper; at most 7 km/s."""
    from scipy.optimize import brentq

    def excess(speed: float) -> float:
        thickness = shield.bumper / slow_diameter(shield, speed, 0.0)
        onset = THICK_SHATTER if thickness >= THICK else SHATTER * thickness ** (-1.0 / 3.0)
        return float(speed - onset)

    return float(brentq(excess, 0.5, FAST)) if excess(FAST) > 0.0 else FAST


def _wall_ratio(shield: HandbookShield, diameter: float) -> float:
    """Wall without a bumper over the wall behind a critical one, at 7 km/s."""
    strength = shield.strength
    mass = shield.projectile_density * math.pi / 6.0 * diameter**3
    bare = 0.6 * diameter ** (19.0 / 18.0) * shield.projectile_density**0.5 * FAST ** (2.0 / 3.0)
    bare /= (strength / 40.0) ** 0.5
    densities = (shield.projectile_density * shield.bumper_density) ** (1.0 / 6.0)
    behind = 0.16 * diameter**0.5 * densities * mass ** (1.0 / 3.0) * FAST
    return bare / (behind * (70.0 / strength / shield.stand_off) ** 0.5)


def _ratio(shot: Shot, variant: str) -> float:
    assert shot.shield is not None
    diameter = critical_diameter(
        shot.speed, shot.target.density, shot.projectile.density, shot.shield
    )
    return float(diameter / shot.projectile_diameter)


LAW = Law(
    name="whipple_jsc",
    title="Christiansen, thin bumpers",
    quantity="critical_diameter",
    equation=(
        "that of Christiansen (1993) with shatter from 1.436 (t_b/d)^(-1/3) km/s on (2.60 km/s from "
        "t_b/d = 0.16) and F^(-2/3) from 7 km/s on, F = r - 2 x (r - 1) + x^2 (r - 1), "
        "x = (t_b/d)/(t_b/d)_crit < 1"
    ),
    source=f"{RYAN}, 245, as coded in pyBLOSSUM, with the mass of a sphere",
    confidence="verified",
    size_exponent=None,
    range=range_of(RYAN),
    ratio=_ratio,
    meaningless=without_shield,
)
