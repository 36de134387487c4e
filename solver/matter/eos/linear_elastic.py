"""Linear elasticity of the volume, matter without an equation of state: p = K (rho / rho0 - 1), whatever the heat.

Ma (2005), section 2.2.4, after Eq. 2-41, adds K times each volume change instead, K ln(rho / rho0): the same for small
strain, and lower by (rho / rho0 - 1) / 2 of it in compression.

What exceeds the energy of the isentrope, the integral of p drho / rho^2 = K / rho0 (ln x - 1 + 1 / x) with x = rho /
rho0, is heat; on the isentrope the temperature stays what it was.
"""

import math
from typing import Annotated, NamedTuple

from solver.jit import implements
from solver.matter.eos import EosEntry, pressure_terms, reference_sound_speed, sound_speed_squared, temperature
from solver.units import Density, FromMaterial, HeatCapacity, Pascal, RoomTemperature
from solver.vectors import log


class LinearElastic(NamedTuple):
    """Parameters of the linear law."""

    density: Density  # rho0
    bulk_modulus: Annotated[Pascal, FromMaterial("elastic.bulk_modulus")]  # K
    temperature: RoomTemperature  # of the reference state
    heat_capacity: HeatCapacity = math.inf  # cv; inf: the temperature stays what it is


EOS = EosEntry("linear-elastic", LinearElastic, LinearElastic, form="elastic")


@implements(pressure_terms, LinearElastic)
def pressure_terms_of_linear_elastic(eos, density, energy):
    return eos.bulk_modulus * (density / eos.density - 1.0), 0.0


@implements(sound_speed_squared, LinearElastic)
def sound_speed_squared_of_linear_elastic(eos, density, energy, pressure):
    return eos.bulk_modulus / eos.density


@implements(temperature, LinearElastic)
def temperature_of_linear_elastic(eos, density, energy):
    x = density / eos.density
    cold = eos.bulk_modulus / eos.density * (log(x) - 1.0 + 1.0 / x)
    return eos.temperature + (energy - cold) / eos.heat_capacity


@implements(reference_sound_speed, LinearElastic)
def reference_sound_speed_of_linear_elastic(eos):
    return math.sqrt(eos.bulk_modulus / eos.density)
