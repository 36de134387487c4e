"""Murnaghan (1944), Proc. Natl. Acad. Sci. 30, 244: p = K (x^n - 1) / n with x = rho / rho0, whatever the heat."""

import math
from typing import Annotated, NamedTuple

from solver.matter.eos import EosEntry
from solver.units import Density, Described, Dimensionless, HeatCapacity, Pascal, RoomTemperature
from solver.vectors import power


class Murnaghan(NamedTuple):
    """Parameters of the form."""

    density: Density  # rho0
    K: Annotated[Pascal, Described("bulk modulus", 1e5, 1e13)]
    n: Annotated[Dimensionless, Described("slope of the bulk modulus", 1.1, 10.0)]
    heat_capacity: HeatCapacity
    temperature: RoomTemperature

    def pressure_terms(self, density, energy):
        return self.K * (power(density / self.density, self.n) - 1.0) / self.n, 0.0

    def sound_speed_squared(self, density, energy, pressure):
        return self.K / self.density * power(density / self.density, self.n - 1.0)

    def temperature_at(self, density, energy):
        x, n = density / self.density, self.n
        cold = self.K / (n * self.density) * (power(x, n - 1.0) / (n - 1.0) + 1.0 / x - n / (n - 1.0))
        return self.temperature + (energy - cold) / self.heat_capacity

    def reference_sound_speed(self):
        return math.sqrt(self.K / self.density)


EOS = EosEntry("murnaghan", Murnaghan, Murnaghan)
