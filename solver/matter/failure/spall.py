"""Spall from cumulative damage: tension beyond a threshold for long enough.

The integral of (sigma / sigma0 - 1)^lambda over the time above sigma0 reaches K: Tuler and Butcher (1968), Int. J.
Fract. Mech. 4, 431, here with the stress in units of its threshold, so that K is a time, and with the hydrostatic
tension in the place of the largest principal stress. lambda = 2 is the square that LS-DYNA keeps for this criterion
(``*MAT_ADD_EROSION``). A time integral, because particles behind a shock scatter by 5 to 30 GPa for a step or two; K is
to be chosen with that in mind: copper of 1.9 GPa and K = 1 us is broken by 30 GPa in 5 ns.

The stress is the one that matter carries, as in OpenRadioss (``fail_tbutcher_s.F``, what the law of
the material returns). The integral limits tension, so the tensile floor does not: at the same spall
strength it would hold sigma at sigma0, and nothing would ever fail. Molten matter bears no tension where the rule of
tension says so.
"""

from typing import Annotated, NamedTuple

from solver.matter.failure import FailureEntry, without_floor
from solver.units import Described, Dimensionless, FromMaterial, Pascal, Second
from solver.vectors import maximum, minimum, power, where


class Spall(NamedTuple):
    """Parameters of the cumulative criterion."""

    threshold: Annotated[Pascal, FromMaterial("tension.spall_strength", above_zero=True)]  # sigma0, greater than zero
    # K
    time: Annotated[
        Second,
        Described(
            "time at twice the spall strength after which matter fails, without a tensile floor",
            1e-12,
            1.0,
            usual=(1e-9, 1e-3),
        ),
    ]
    exponent: Dimensionless = 2.0  # lambda

    def grown_damage(self, damage, loading):
        beyond = maximum(-loading.pressure / self.threshold - 1.0, 0.0)
        grown = power(beyond, self.exponent) * loading.dt / self.time
        return minimum(damage + where(beyond > 0.0, grown, 0.0), 1.0)

    def floor_until_failure(self, floor):
        return without_floor(floor)


FAILURE = FailureEntry("spall", Spall)
