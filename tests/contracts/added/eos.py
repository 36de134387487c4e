"""Murnaghan (1944), Proc. Natl. Acad. Sci. 30, 244: p = K (x^n - 1) / n with x = rho / rho0, whatever the heat."""

import math
from typing import Annotated, NamedTuple

from solver.jit import implements
from solver.matter.eos import EosEntry, pressure_terms, reference_sound_speed, sound_speed_squared, temperature
from solver.units import Density, Described, Dimensionless, HeatCapacity, Pascal, RoomTemperature
from solver.vectors import power


class Murnaghan(NamedTuple):
    """Parameters of the form."""

    density: Density  # rho0
    K: Annotated[Pascal, Described("bulk modulus", 1e5, 1e13)]
    n: Annotated[Dimensionless, Described("slope of the bulk modulus", 1.1, 10.0)]
    heat_capacity: HeatCapacity
    temperature: RoomTemperature


EOS = EosEntry("murnaghan", Murnaghan, Murnaghan)


@implements(pressure_terms, Murnaghan)
def pressure_terms_of_murnaghan(eos, density, energy):
    return eos.K * (power(density / eos.density, eos.n) - 1.0) / eos.n, 0.0


@implements(sound_speed_squared, Murnaghan)
def sound_speed_squared_of_murnaghan(eos, density, energy, pressure):
    return eos.K / eos.density * power(density / eos.density, eos.n - 1.0)


@implements(temperature, Murnaghan)
def temperature_of_murnaghan(eos, density, energy):
    x, n = density / eos.density, eos.n
    cold = eos.K / (n * eos.density) * (power(x, n - 1.0) / (n - 1.0) + 1.0 / x - n / (n - 1.0))
    return eos.temperature + (energy - cold) / eos.heat_capacity


@implements(reference_sound_speed, Murnaghan)
def reference_sound_speed_of_murnaghan(eos):
    return math.sqrt(eos.K / eos.density)
