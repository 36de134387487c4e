"""Linear elasticity of the volume, matter without an equation of state: p = K (rho / rho0 - 1), whatever the heat.

Ma (2005), section 2.2.4, after Eq. 2-41, adds K times each volume change instead, K ln(rho / rho0): the same for small
strain, and lower by (rho / rho0 - 1) / 2 of it in compression.

What exceeds the energy of the isentrope, the integral of p drho / rho^2 = K / rho0 (ln x - 1 + 1 / x) with x = rho /
rho0, is heat; on the isentrope the temperature stays what it was.
"""

import math
from typing import Annotated, NamedTuple

from solver.matter.eos import EosEntry
from solver.units import Density, FromMaterial, HeatCapacity, Pascal, RoomTemperature
from solver.vectors import log


class LinearElastic(NamedTuple):
    """Parameters of the linear law."""

    density: Density  # rho0
    bulk_modulus: Annotated[Pascal, FromMaterial("elastic.bulk_modulus")]  # K
    temperature: RoomTemperature  # of the reference state
    heat_capacity: HeatCapacity = math.inf  # cv; inf: the temperature stays what it is

    def pressure_terms(self, density, energy):
        return self.bulk_modulus * (density / self.density - 1.0), 0.0

    def sound_speed_squared(self, density, energy, pressure):
        return self.bulk_modulus / self.density

    def temperature_at(self, density, energy):
        x = density / self.density
        cold = self.bulk_modulus / self.density * (log(x) - 1.0 + 1.0 / x)
        return self.temperature + (energy - cold) / self.heat_capacity

    def reference_sound_speed(self):
        return math.sqrt(self.bulk_modulus / self.density)


EOS = EosEntry("linear-elastic", LinearElastic, LinearElastic, form="elastic")
