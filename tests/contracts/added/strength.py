"""Power-law hardening: sigma_y = Y (1 + eps)^n until melting."""

from typing import Annotated, NamedTuple

from solver.matter.strength import StrengthEntry, solid
from solver.units import Described, Dimensionless, Pascal
from solver.vectors import power


class PowerHardening(NamedTuple):
    """Parameters of the hardening."""

    Y: Annotated[Pascal, Described("initial yield stress", 0.0, 1e12)]
    n: Annotated[Dimensionless, Described("hardening exponent", 0.0, 1.0)]

    def hardening(self, plastic_strain):
        stress = self.Y * power(1.0 + plastic_strain, self.n)
        return stress, self.n * stress / (1.0 + plastic_strain)

    def rate_and_heat(self, strain_rate, homologous, stiff):
        return solid(homologous)


STRENGTH = StrengthEntry("power-hardening", PowerHardening)
