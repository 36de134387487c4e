"""Johnson and Cook's damage and rate-dependent spall at once: shear and tension use up the same matter.

Their increments of damage add up (Palmgren and Miner's rule), and the sum weakens as Johnson and Cook's damage does.
The integral of the tension limits it, so the tensile floor does not, as in ``spall_rate``.
"""

from typing import Annotated, NamedTuple

from solver.matter.failure import FailureEntry, grown_damage, without_floor
from solver.matter.failure.johnson_cook import JohnsonCookDamage
from solver.matter.failure.spall_rate import RateDependentSpall
from solver.units import Dimensionless, FromMaterial, Pascal, PerSecond
from solver.vectors import where


class JohnsonCookSpall(NamedTuple):
    """The parameters of both."""

    D1: Annotated[Dimensionless, FromMaterial("fracture.D1")]
    D2: Annotated[Dimensionless, FromMaterial("fracture.D2")]
    D3: Annotated[Dimensionless, FromMaterial("fracture.D3")]
    D4: Annotated[Dimensionless, FromMaterial("fracture.D4")]
    D5: Annotated[Dimensionless, FromMaterial("fracture.D5")]
    reference_rate: Annotated[PerSecond, FromMaterial("fracture.reference_rate")]
    critical_damage: Annotated[Dimensionless, FromMaterial("fracture.critical_damage")]
    threshold: Annotated[Dimensionless, FromMaterial("fracture.threshold")]
    strength: Annotated[Pascal, FromMaterial("spall.strength")]
    strain_rate: Annotated[PerSecond, FromMaterial("spall.strain_rate")]
    exponent: Annotated[Dimensionless, FromMaterial("spall.exponent")]
    bulk_modulus: Annotated[Pascal, FromMaterial("stiffness")]

    def weakens(self):
        return True

    def grown_damage(self, damage, loading):
        shear, tension = JohnsonCookDamage(*self[:8]), RateDependentSpall(*self[8:])
        return grown_damage(tension, grown_damage(shear, damage, loading), loading)

    def integrity(self, damage):
        return where(damage < 1.0, 1.0 - self.critical_damage * damage, 0.0)

    def floor_until_failure(self, floor):
        return without_floor(floor)


FAILURE = FailureEntry("johnson-cook-spall", JohnsonCookSpall)
