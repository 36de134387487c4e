"""Spall by voids that grow: tension is lost as they do, at the rate that the measured spall strengths have.

Voids of the part f of the volume open at the rate::

    df/dt = rate_1 (sigma / (sigma_1 w(f)))^(1/m)

with the spall strength sigma_1 (rate / rate_1)^m of ``spall_rate``: it is the tension at which voids open as fast as
matter is stretched, and tension grows no more (Wilkerson and Ramesh (2016), Phys. Rev. Lett. 117, 215503, of their Eq.
10). w is the tension that porous matter bears over that of whole matter. A hollow sphere of plastic matter yields at
(2/3) Y ln(1/f) (Carroll and Holt (1972), J. Appl. Phys. 43, 1626), and a void alone at (2/3) Y (1 - ln(3 Y / 2 E))
(Bishop, Hill and Mott (1945), Proc. Phys. Soc. 57, 147; Eq. 2 of Wilkerson and Ramesh), so that

    w = ln f / ln f_0,   f_0 = 3 Y / (2 e E),   and 1 as long as f is less than f_0.

At the void fraction of coalescence the voids link, and matter fails: damage is f over it. Whole matter between the
voids bears the pressure of its own density, that of all over 1 - f (Herrmann (1969), J. Appl. Phys. 40, 2490), so that
the work of opening is heat. Voids close before matter bears pressure, and open again without tension.

The strength is met by matter stretched at a constant rate; a softening that follows a rate keeps its width on any mesh.
The rate limits tension, so the tensile floor does not; molten matter bears none where the rule of tension says so.
"""

import math
from typing import Annotated, NamedTuple

from solver.jit import device, gives, implements
from solver.matter.failure import FailureEntry, floor_until_failure, grown_damage, opens, void_fraction
from solver.units import Dimensionless, FromMaterial, Pascal, PerSecond
from solver.vectors import log, maximum, minimum, power, where

# Steps of Newton's rule from above: to round-off for any tension and time step (tests/solver/test_void_growth.py).
NEWTONS = 8


class VoidGrowth(NamedTuple):
    """Parameters of the growth."""

    strength: Annotated[Pascal, FromMaterial("spall.strength")]  # sigma_1
    strain_rate: Annotated[PerSecond, FromMaterial("spall.strain_rate")]  # rate_1
    exponent: Annotated[Dimensionless, FromMaterial("spall.exponent")]  # m
    dilute_voids: Annotated[Dimensionless, FromMaterial("spall.dilute_voids")]  # f_0
    coalescence: Annotated[Dimensionless, FromMaterial("spall.coalescence")]
    bulk_modulus: Annotated[Pascal, FromMaterial("stiffness")]  # of the equation of state


FAILURE = FailureEntry("void-growth", VoidGrowth)

gives(opens, VoidGrowth, True)


@implements(void_fraction, VoidGrowth)
def void_fraction_of_void_growth(failure, damage):
    return failure.coalescence * damage


@implements(grown_damage, VoidGrowth)
def grown_damage_of_void_growth(failure, damage, loading):
    """Damage once the voids of a step have opened: implicit in the tension, of a matter of constant stiffness.

    With x the tension over that which the voids leave: x + K rate_1 dt / (sigma_1 w) x^(1/m) = x before they open.
    """
    voids = failure.coalescence * damage
    borne = failure.strength * log(maximum(voids, failure.dilute_voids)) * (1.0 / math.log(failure.dilute_voids))
    before = maximum(-loading.pressure, 0.0) / borne
    opening = failure.bulk_modulus * failure.strain_rate * loading.dt / borne
    after = _root(opening, 1.0 / failure.exponent, before)
    grown = damage + (before - after) * borne * (1.0 / (failure.bulk_modulus * failure.coalescence))
    return minimum(maximum(grown, damage), 1.0)


@device
def _root(factor, exponent, total):
    """x >= 0 of x + factor x^exponent = total, by Newton's rule: convex, so approached from above."""
    x = minimum(total, power(total / factor, 1.0 / exponent))
    for _ in range(NEWTONS):
        term = factor * power(x, exponent)
        slope = 1.0 + exponent * where(x > 0.0, term / where(x > 0.0, x, 1.0), 0.0)
        x = maximum(x - (x + term - total) / slope, 0.0)
    return x


@implements(floor_until_failure, VoidGrowth)
def floor_until_failure_of_void_growth(failure, floor):
    return where(floor < 0.0, -math.inf, floor)  # 0: molten
