"""Ideal gas, for verification: p = (gamma - 1) rho e.

Its reference state is not one without pressure, as a solid's is, but any state of the problem: density, sound speed
and temperature there say what a fast signal, a thin state and a hot one are.
"""

from typing import NamedTuple

from solver.matter.eos import EosEntry
from solver.units import Density, Dimensionless, HeatCapacity, MetrePerSecond, RoomTemperature


class IdealGas(NamedTuple):
    """Parameters of the gas."""

    density: Density  # of the reference state
    sound_speed: MetrePerSecond  # of the reference state; 0 for a cold gas
    gamma: Dimensionless  # ratio of heat capacities
    heat_capacity: HeatCapacity  # cv
    temperature: RoomTemperature  # of the reference state

    def pressure_terms(self, density, energy):
        return 0.0, (self.gamma - 1.0) * density

    def sound_speed_squared(self, density, energy, pressure):
        return (self.gamma - 1.0) * (energy + pressure / density)

    def temperature_at(self, density, energy):
        # c^2 = gamma (gamma - 1) e
        reference = self.sound_speed * self.sound_speed / (self.gamma * (self.gamma - 1.0))
        return self.temperature + (energy - reference) / self.heat_capacity

    def reference_sound_speed(self):
        return self.sound_speed


EOS = EosEntry("ideal-gas", IdealGas, IdealGas)
