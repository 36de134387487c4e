"""Ideal gas, for verification: p = (gamma - 1) rho e.

Its reference state is not one without pressure, as a solid's is, but any state of the problem: density, sound speed
and temperature there say what a fast signal, a thin state and a hot one are.
"""

from typing import NamedTuple

from solver.jit import implements
from solver.matter.eos import EosEntry, pressure_terms, reference_sound_speed, sound_speed_squared, temperature
from solver.units import Density, Dimensionless, HeatCapacity, MetrePerSecond, RoomTemperature


class IdealGas(NamedTuple):
    """Parameters of the gas."""

    density: Density  # of the reference state
    sound_speed: MetrePerSecond  # of the reference state; 0 for a cold gas
    gamma: Dimensionless  # ratio of heat capacities
    heat_capacity: HeatCapacity  # cv
    temperature: RoomTemperature  # of the reference state


EOS = EosEntry("ideal-gas", IdealGas, IdealGas)


@implements(pressure_terms, IdealGas)
def pressure_terms_of_ideal_gas(eos, density, energy):
    return 0.0, (eos.gamma - 1.0) * density


@implements(sound_speed_squared, IdealGas)
def sound_speed_squared_of_ideal_gas(eos, density, energy, pressure):
    return (eos.gamma - 1.0) * (energy + pressure / density)


@implements(temperature, IdealGas)
def temperature_of_ideal_gas(eos, density, energy):
    # c^2 = gamma (gamma - 1) e
    reference = eos.sound_speed * eos.sound_speed / (eos.gamma * (eos.gamma - 1.0))
    return eos.temperature + (energy - reference) / eos.heat_capacity


@implements(reference_sound_speed, IdealGas)
def reference_sound_speed_of_ideal_gas(eos):
    return eos.sound_speed
