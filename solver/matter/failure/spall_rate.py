"""Spall at the strength that plate impacts show at their strain rate; the time until it breaks follows.

Measured spall strengths grow with the rate of expansion, sigma = sigma_1 (rate / rate_1)^m: Kanel (2010), Int. J.
Fract. 163, 173; Grady (1988), J. Mech. Phys. Solids 36, 353, has m = 1/3 and sigma_1^3 = 3 rho c0 K_c^2 rate_1 where
the fracture toughness K_c decides. Matter that expands at a constant rate bears K rate t, with its bulk modulus K, so
that it breaks after t = sigma / (K rate). One integral over the time under tension gives this at every rate (Tuler and
Butcher (1968), Int. J. Fract. Mech. 4, 431, without a threshold)::

    damage = integral of (sigma / sigma_1)^(1/m - 1) dt / t_1,   t_1 = m sigma_1 / (K rate_1)

At a constant tension sigma matter breaks after t_1 (sigma_1 / sigma)^(1/m - 1). With Grady's law the integral is that
of sigma^2 dt up to K_c^2 / c0, whatever the rate. sigma is the hydrostatic tension that matter carries. The integral
limits tension, so the tensile floor does not; molten matter bears none where the rule of tension says so. Pressures of
particles that scatter behind a shock count with the power 1/m - 1. What is partly molten has the part of sigma_1 that
its solid leaves (``melting.coherence``).
"""

from typing import Annotated, NamedTuple

from solver.matter.failure import FailureEntry, without_floor
from solver.units import Dimensionless, FromMaterial, Pascal, PerSecond
from solver.vectors import SMALLEST, maximum, minimum, power, where


class RateDependentSpall(NamedTuple):
    """Parameters of the strength, with the stiffness that makes a stress of a rate and a time."""

    strength: Annotated[Pascal, FromMaterial("spall.strength")]  # sigma_1
    strain_rate: Annotated[PerSecond, FromMaterial("spall.strain_rate")]  # rate_1
    exponent: Annotated[Dimensionless, FromMaterial("spall.exponent")]  # m
    bulk_modulus: Annotated[Pascal, FromMaterial("stiffness")]  # K, of the equation of state

    def grown_damage(self, damage, loading):
        tension = maximum(-loading.pressure / (self.strength * maximum(loading.coherent, SMALLEST)), 0.0)
        per_time = self.bulk_modulus * self.strain_rate / (self.exponent * self.strength)
        grown = power(tension, 1.0 / self.exponent - 1.0) * per_time * loading.dt
        return minimum(damage + where(tension > 0.0, grown, 0.0), 1.0)

    def floor_until_failure(self, floor):
        return without_floor(floor)


FAILURE = FailureEntry("spall-rate", RateDependentSpall)
