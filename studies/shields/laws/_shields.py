"""Shields in the units of handbooks, and what the equations of Whipple shields share: fast limb, thin bumpers."""

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import wraps
from typing import TypedDict, Unpack

import numpy as np
from numpy.typing import ArrayLike, NDArray

from studies.laws import Law, RangeCode, Reason, Shot
from studies.laws._handbook import CENTIMETRE, GRAM_PER_CUBIC_CENTIMETRE, KILOMETRE_PER_SECOND, KSI
from studies.laws._range import Limit, Range, family, stated
from studies.shields.roots import root_between
from studies.shields.shield import ALUMINIUM, CRITICAL_DIAMETER, FurtherBumper, Shield, shield_of

FAST = 7.0  # km/s of the normal speed, from which the debris is molten
SIZE = 18.0 / 19.0  # exponent of the limbs of strength
# The equations take 65 deg beyond it.
STEEPEST = 65.0  # deg
DENSEST = 2900.0  # kg/m3: no alloy of aluminium is denser
# Denser spheres melt at higher speeds, so that their fast limb begins later than 7 km/s. How it moves between the
# densities of aluminium and of steel is not published, and no equation here knows it.
HEAVY = "above 6 g/cm3 the fast limb begins at 9.1 km/s: NASA/TM-2014-218268, known second-hand"


class ShieldCode(RangeCode):
    """Kinds of limits of equations of shields, and of reasons."""

    SHIELD = "shield", "a Whipple shield", "the target is no Whipple shield"
    WALL_FAMILY = (
        "wall_family",
        "wall of {first}",
        "calibrated on {first}, {others}",
        True,
    )  # of what is behind a bumper
    PROJECTILE_DENSITY = (
        "projectile_density",
        "projectile no denser than aluminium ({high:g}{unit})",
        "{symbol} = {value:.3g}{unit} is above {high:g}{unit}, that of aluminium",
    )
    # Of reasons alone.
    TWO_WALLS = "two_walls", "", "the equation is for two walls, the shield has a second bumper"
    THREE_WALLS = "three_walls", "", "the target is no shield of two bumpers and a wall"
    NO_YIELD_STRESS = "no_yield_stress", "", "the material of the wall states no yield stress"


@dataclass(frozen=True)
class HandbookShield:
    """A shield in cm, g/cm3 and ksi, with the density of what hits it."""

    bumper: float
    wall: float
    stand_off: float
    strength: float  # of the wall
    wall_density: float
    bumper_density: float
    projectile_density: float
    second_bumper: float = 0.0  # thickness; 0: two walls
    second_stand_off: float = 0.0  # between the second bumper and the wall

    def fast_diameter(self, normal_speed: float) -> float:
        """Critical diameter, cm, behind a bumper that shatters the projectile; km/s, from 7 on."""
        scale = self.wall ** (2.0 / 3.0) * (self.stand_off * self.strength / 70.0) ** (1.0 / 3.0)
        densities = self.projectile_density ** (-1.0 / 3.0) * self.bumper_density ** (-1.0 / 9.0)
        return 3.918 * scale * densities * normal_speed ** (-2.0 / 3.0)

    def thin_bumper_diameter(self, speed: float, thin: "ThinBumper") -> float:
        """Critical diameter, cm, with a bumper that may be too thin to shatter the projectile; km/s, from 7 on.

        d F^(2/3) is what a thick bumper stops, where F falls from r without a bumper to 1 at the critical thickness:
        F = r - 2 x (r - 1) + x^2 (r - 1), x = (t_b/d) / (t_b/d)_crit.
        """
        thick = self.fast_diameter(speed)

        def excess(diameter: float) -> float:
            critical = thin.critical_thickness(self.stand_off / diameter)
            share = min(1.0, self.bumper / diameter / critical)
            more = thin.wall_ratio(diameter) - 1.0
            factor = 1.0 + more * (1.0 - share) ** 2
            return float(diameter * factor ** (2.0 / 3.0) - thick)

        if excess(thick) <= 0.0:
            return thick
        return root_between(excess, 1e-6 * thick, thick, within=1e-12)

    def critical_diameter(self, normal_speed: float, thin: "ThinBumper") -> float:
        """Critical diameter, cm, of a speed in km/s, with shatter at a speed that the bumper decides."""
        ends = self._shatter_speed(thin), FAST
        return by_three_ranges(
            normal_speed, ends, thin.slow_diameter, lambda fast: self.thin_bumper_diameter(fast, thin)
        )

    def _shatter_speed(self, thin: "ThinBumper") -> float:
        """The speed, km/s, at which the projectile on the limb of strength breaks at the bumper; at most 7 km/s."""

        def excess(speed: float) -> float:
            return speed - thin.shatter_speed(self.bumper / thin.slow_diameter(speed))

        return root_between(excess, 0.5, FAST, within=1e-12) if excess(FAST) > 0.0 else FAST


@dataclass(frozen=True)
class ThinBumper:
    """What an equation says of a bumper that may be too thin; cm and km/s."""

    slow_diameter: Callable[[float], float]  # of a normal speed: the limb of whole projectiles
    shatter_speed: Callable[[float], float]  # of the bumper's thickness over the diameter
    wall_ratio: Callable[[float], float]  # of a diameter: the wall without a bumper over that behind a critical one
    critical_thickness: Callable[[float], float]  # of the stand-off, both over the diameter


def in_handbook_units(shield: Shield, bumper_density: float, projectile_density: float) -> HandbookShield:
    """A shield and two densities (kg/m3) at the door of the equations."""
    second = shield.further_bumpers[0] if shield.further_bumpers else FurtherBumper(0.0, 0.0)
    return HandbookShield(
        bumper=shield.bumper_thickness / CENTIMETRE,
        wall=shield.wall_thickness / CENTIMETRE,
        stand_off=shield.stand_off / CENTIMETRE,
        second_bumper=second.bumper_thickness / CENTIMETRE,
        second_stand_off=second.stand_off / CENTIMETRE,
        strength=shield.wall_yield_stress / KSI,
        wall_density=(shield.wall_density or bumper_density) / GRAM_PER_CUBIC_CENTIMETRE,
        bumper_density=bumper_density / GRAM_PER_CUBIC_CENTIMETRE,
        projectile_density=projectile_density / GRAM_PER_CUBIC_CENTIMETRE,
    )


def in_si(formula: Callable[..., float]) -> Callable[..., NDArray]:
    """A critical diameter in SI by one in the units of handbooks.

    ``formula`` gives cm by a ``HandbookShield``, km/s and, of oblique impacts, rad. What it becomes gives m by m/s
    (which broadcast), the densities of bumper and projectile in kg/m3, a ``Shield`` and the same angle.
    """

    @wraps(formula)
    def critical_diameter(
        speed: ArrayLike, bumper_density: float, projectile_density: float, shield: Shield, *obliquity: float
    ) -> NDArray:
        matter = in_handbook_units(shield, bumper_density, projectile_density)
        speeds = np.asarray(speed) / KILOMETRE_PER_SECOND
        diameters = [CENTIMETRE * formula(matter, one, *obliquity) for one in np.ravel(speeds)]
        return np.reshape(diameters, speeds.shape)

    return critical_diameter


class LawFields(TypedDict):
    """What each equation states of itself."""

    name: str
    title: str
    equation: str
    latex: str
    source: str
    confidence: str
    range: Range


def shield_law(
    critical: Callable[..., NDArray],
    *,
    oblique: bool = True,
    meaningless: Callable[[Shot, str], Reason | None] | None = None,
    **fields: Unpack[LawFields],
) -> Law:
    """The law of a critical diameter by m/s, two densities in kg/m3, the shield and the obliquity.

    Without ``oblique`` the equation is about normal impact and takes no obliquity.
    """

    def ratio(shot: Shot, variant: str) -> float:
        lean = (shot.obliquity,) if oblique else ()
        diameter = critical(shot.speed, shot.target.density, shot.projectile.density, shield_of(shot), *lean)
        return float(diameter / shot.projectile_diameter)

    return Law(
        quantity=CRITICAL_DIAMETER,
        ratio=ratio,
        meaningless=meaningless or without_shield,
        size_exponent=None,
        largest_obliquity=math.radians(90.0) if oblique else 0.0,
        **fields,
    )


def by_three_ranges(
    speed: float, ends: tuple[float, float], slow: Callable[[float], float], fast: Callable[[float], float]
) -> float:
    """Critical diameter by the limbs below and above two speeds, and linear in the speed between their ends."""
    low, high = ends
    if speed <= low:
        return slow(speed)
    if speed >= high:
        return fast(speed)
    share = (speed - low) / (high - low)
    return slow(low) + share * (fast(high) - slow(low))


def without_shield(shot: Shot, variant: str = "") -> Reason | None:
    """Why a shot has no critical diameter of two walls; None where it meets a shield of two."""
    shield = shield_of(shot)
    if shield is None:
        return Reason(ShieldCode.SHIELD)
    return Reason(ShieldCode.TWO_WALLS) if shield.further_bumpers else without_yield_stress(shield)


def without_yield_stress(shield: Shield) -> Reason | None:
    """Why an equation that takes the strength of the wall has no answer; None where it is known."""
    return Reason(ShieldCode.NO_YIELD_STRESS) if math.isnan(shield.wall_yield_stress) else None


def range_of(
    source: str,
    *limits: Limit,
    fails: str = "perforated or with detached spall",
    walls: Callable[[Shot], Reason | None] = without_shield,
) -> Range:
    """Bumper and wall of aluminium; ``fails`` says which wall has failed."""
    return Range(
        family(ALUMINIUM, source),
        Limit(
            ShieldCode.SHIELD,
            "the equation is about bumper and wall",
            is_derived=True,
            check=lambda limit, shot: walls(shot),
        ),
        Limit(ShieldCode.WALL_FAMILY, source, names=(ALUMINIUM,), check=_other_metal),
        Limit(ShieldCode.PROJECTILE_DENSITY, HEAVY, "rho_p", high=DENSEST, unit="kg m-3", check=_heavy_projectile),
        stated(fails, source),
        *limits,
    )


def _heavy_projectile(limit: Limit, shot: Shot) -> Reason | None:
    """Why the debris of a projectile is not the one that an equation's fast limb is for."""
    density = shot.projectile.density
    return limit.broken(density) if density > limit.high else None


def _other_metal(limit: Limit, shot: Shot) -> Reason | None:
    """Why what stands behind the bumper is not what an equation is for."""
    shield = shield_of(shot)
    behind = shield.of_other_metal if shield else {}
    return limit.broken(found=behind) if behind else None
