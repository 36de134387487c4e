"""Johnson and Cook's damage: the fracture strain follows triaxiality, rate and temperature, and damage weakens.

eps_f = (D1 + D2 exp(D3 sigma*)) (1 + rate*)^D4 (1 + D5 T*), in the form of Borvik et al. (1999), Int. J. Impact Eng.
22, 855, and (1 + D4 ln rate*) in place of the power in that of Johnson and Cook (1985), Eng. Fract. Mech. 21, 31, with
sigma* the mean over the equivalent stress, rate* = rate / reference_rate and T* the homologous temperature.
Above the threshold p_d the damage D grows by D_c d eps / (eps_f - p_d), and matter fails at D = D_c: the equations of
the seed of coupled SPH and finite elements (Zhang, Qiang and Gao). Here damage is D / D_c, 1 at failure.

The rule by which D weakens: sigma_y = (1 - D) [A + B r^n] ... with dr = (1 - D) d eps, D before the step; the pressure,
which the equation of state gives, and the elastic moduli are those of whole matter. The stress of the triaxiality is
the one that matter carries, so weakened too. Matter whose eps_f is not above p_d fails at its next slip: with D1 below
zero that is all matter above the triaxiality ln(-D1 / D2) / D3.
"""

from typing import Annotated, NamedTuple

from solver.jit import device, generic
from solver.matter.failure import FailureEntry
from solver.units import Dimensionless, FromMaterial, PerSecond
from solver.vectors import SMALLEST, exp, log, maximum, minimum, power, where

# Of e: a fracture strain that no matter comes to, and its product with the other factors is a number.
NEVER = 100.0


class JohnsonCookDamage(NamedTuple):
    """Parameters of the damage, with the logarithm of the rate."""

    D1: Annotated[Dimensionless, FromMaterial("fracture.D1")]
    D2: Annotated[Dimensionless, FromMaterial("fracture.D2")]
    D3: Annotated[Dimensionless, FromMaterial("fracture.D3")]
    D4: Annotated[Dimensionless, FromMaterial("fracture.D4")]
    D5: Annotated[Dimensionless, FromMaterial("fracture.D5")]
    reference_rate: Annotated[PerSecond, FromMaterial("fracture.reference_rate")]
    critical_damage: Annotated[Dimensionless, FromMaterial("fracture.critical_damage")]  # D_c
    threshold: Annotated[Dimensionless, FromMaterial("fracture.threshold")]  # p_d

    def weakens(self):
        return True

    def rate_factor(self, strain_rate):
        return 1.0 + self.D4 * log(maximum(strain_rate * (1.0 / self.reference_rate), 1.0))

    def grown_damage(self, damage, loading):
        limit = fracture_strain(self, loading.triaxiality, loading.strain_rate, loading.homologous)
        # The part of the slip that lies above the threshold.
        slip = minimum(loading.slip, maximum(loading.plastic_strain - self.threshold, 0.0))
        return minimum(damage + slip / maximum(limit - self.threshold, SMALLEST), 1.0)

    def integrity(self, damage):
        return where(damage < 1.0, 1.0 - self.critical_damage * damage, 0.0)


class ModifiedJohnsonCookDamage(JohnsonCookDamage):
    """The same parameters, with the power of the rate."""

    __slots__ = ()

    def rate_factor(self, strain_rate):
        return power(1.0 + strain_rate * (1.0 / self.reference_rate), self.D4)


FAILURE = (
    FailureEntry("johnson-cook", JohnsonCookDamage),
    FailureEntry("modified-johnson-cook", ModifiedJohnsonCookDamage),
)


@generic
def rate_factor(failure, strain_rate):
    """Factor of the fracture strain at a rate in 1/s."""


@device
def fracture_strain(failure, triaxiality, strain_rate, homologous):
    """Plastic strain at failure under a constant triaxiality, rate (1/s) and homologous temperature."""
    ductility = failure.D1 + failure.D2 * exp(minimum(failure.D3 * triaxiality, NEVER))
    return ductility * rate_factor(failure, strain_rate) * (1.0 + failure.D5 * homologous)
