"""Spall by voids that grow: matter that reaches its spall strength opens, and loses its tension as the voids grow.

Until the voids count matter is that of ``spall_rate``: it reaches the spall strength sigma_1 (rate / rate_1)^m. From
then on voids of the part f of the volume open at the rate::

    df/dt = rate_1 (sigma / (sigma_1 w(f)))^(1/m)

The spall strength is the tension at which voids open as fast as matter is stretched, and tension grows no more
(Wilkerson and Ramesh (2016), Phys. Rev. Lett. 117, 215503, of their Eq. 10): so here while w is 1. w is the tension
that porous matter bears over that of whole matter. A hollow sphere of plastic matter yields at (2/3) Y ln(1/f) (Carroll
and Holt (1972), J. Appl. Phys. 43, 1626), and a void alone at (2/3) Y (1 - ln(3 Y / 2 E)) (Bishop, Hill and Mott
(1945), Proc. Phys. Soc. 57, 147; Eq. 2 of Wilkerson and Ramesh), so that

    w = ln f / ln f_0,   f_0 = 3 Y / (2 e E),   and 1 as long as f is less than f_0.

At the void fraction of coalescence the voids link, and matter fails. Whole matter between the voids bears the pressure
of its own density, that of all over 1 - f (Herrmann (1969), J. Appl. Phys. 40, 2490), so that the work of opening is
heat. Voids close before matter bears pressure, and open again without tension.

Half of the damage is that of ``spall_rate``, the other half is f over that of coalescence. The rate limits tension, so
the tensile floor does not; molten matter bears none where the rule of tension says so.
"""

import math
from typing import Annotated, NamedTuple

from solver.jit import device
from solver.matter.failure import FailureEntry, grown_damage, void_fraction, without_floor
from solver.matter.failure.spall_rate import RateDependentSpall
from solver.units import Dimensionless, FromMaterial, Pascal, PerSecond
from solver.vectors import SMALLEST, anywhere, log, maximum, minimum, power, where

HALF = 0.5  # damage at which voids begin: below it counts the time until the spall strength is reached
# Steps of Newton's rule from above: to round-off for any tension and time step (tests/solver/test_models.py).
NEWTONS = 8


class VoidGrowth(NamedTuple):
    """Parameters of the growth."""

    strength: Annotated[Pascal, FromMaterial("spall.strength")]  # sigma_1
    strain_rate: Annotated[PerSecond, FromMaterial("spall.strain_rate")]  # rate_1
    exponent: Annotated[Dimensionless, FromMaterial("spall.exponent")]  # m
    dilute_voids: Annotated[Dimensionless, FromMaterial("spall.dilute_voids")]  # f_0
    coalescence: Annotated[Dimensionless, FromMaterial("spall.coalescence")]
    bulk_modulus: Annotated[Pascal, FromMaterial("stiffness")]  # K of the equation of state

    def opens(self):
        return True

    def void_fraction(self, damage):
        return self.coalescence * maximum(damage - HALF, 0.0) * (1.0 / (1.0 - HALF))

    def grown_damage(self, damage, loading):
        """Damage once the voids of a step have opened: implicit in the tension, of matter of constant stiffness.

        With x the tension over that which the voids leave: x + K rate_1 dt / (sigma_1 w) x^(1/m) = x before they open.
        """
        if not anywhere(loading.pressure < 0.0):  # as most points are most of the time
            return damage
        until = RateDependentSpall(self.strength, self.strain_rate, self.exponent, self.bulk_modulus)
        closed = HALF * grown_damage(until, minimum(damage, HALF) * (1.0 / HALF), loading)
        if not anywhere(damage >= HALF):
            return closed
        voids = void_fraction(self, damage)
        whole = self.strength * maximum(loading.coherent, SMALLEST)
        borne = whole * log(maximum(voids, self.dilute_voids)) * (1.0 / math.log(self.dilute_voids))
        before = maximum(-loading.pressure, 0.0) / borne
        opening = self.bulk_modulus * self.strain_rate * loading.dt / borne
        after = _root(opening, 1.0 / self.exponent, before)
        grown = (before - after) * borne * ((1.0 - HALF) / (self.bulk_modulus * self.coalescence))
        return where(damage < HALF, closed, minimum(damage + maximum(grown, 0.0), 1.0))

    def floor_until_failure(self, floor):
        return without_floor(floor)


FAILURE = FailureEntry("void-growth", VoidGrowth)


@device
def _root(factor, exponent, total):
    """x >= 0 of x + factor x^exponent = total, by Newton's rule: convex, so approached from above."""
    x = minimum(total, power(total / factor, 1.0 / exponent))
    for _ in range(NEWTONS):
        term = factor * power(x, exponent)
        slope = 1.0 + exponent * where(x > 0.0, term / where(x > 0.0, x, 1.0), 0.0)
        x = maximum(x - (x + term - total) / slope, 0.0)
    return x
