"""Polynomial in the compression, linear in the energy: fluids without strength ("null materials") and gases.

With mu = rho / rho0 - 1 and E = rho0 e, energy per initial volume::

    p = C0 + C1 mu + C2 mu^2 + C3 mu^3 + (C4 + C5 mu + C6 mu^2) E

LS-DYNA Keyword User's Manual, ``*EOS_LINEAR_POLYNOMIAL``; the decks of MPM3D-F90 give the seven constants and E0. As in
that code, and not in LS-DYNA, C2 and C6 act in expansion too. C0 to C3 zero and C4 = C5 = gamma - 1 is an ideal gas.
Temperature: the room's with the energy E0, and the heat capacity from there on.
"""

from typing import Annotated, NamedTuple

from solver.jit import device
from solver.matter.eos import EosEntry
from solver.units import Density, Described, Dimensionless, HeatCapacity, Pascal, RoomTemperature

MOST = 1e13  # Pa


class Polynomial(NamedTuple):
    """Parameters of the polynomial."""

    density: Density  # rho0
    C0: Annotated[Pascal, Described("pressure of the reference density without energy", -MOST, MOST)]
    C1: Annotated[Pascal, Described("coefficient of the compression", -MOST, MOST, usual=(1e8, 6e11))]
    C2: Annotated[Pascal, Described("coefficient of the squared compression", -MOST, MOST)]
    C3: Annotated[Pascal, Described("coefficient of the cubed compression", -MOST, MOST)]
    C4: Annotated[Dimensionless, Described("coefficient of the energy", -100.0, 100.0)]
    C5: Annotated[Dimensionless, Described("coefficient of energy times compression", -100.0, 100.0)]
    C6: Annotated[Dimensionless, Described("coefficient of energy times squared compression", -100.0, 100.0)]
    heat_capacity: HeatCapacity  # cv
    temperature: RoomTemperature  # temperature of the reference state
    E0: Pascal = 0.0  # energy of the reference state per its volume, J/m3; with it the body begins

    def pressure_terms(self, density, energy):
        cold, heated, _, _ = _factors(self, density)
        return cold, heated * self.density

    def sound_speed_squared(self, density, energy, pressure):
        _, heated, cold_slope, heated_slope = _factors(self, density)
        along = cold_slope / self.density + heated_slope * energy
        return along + heated * self.density * pressure / (density * density)

    def temperature_at(self, density, energy):
        return self.temperature + (energy - self.E0 / self.density) / self.heat_capacity

    def reference_sound_speed(self):
        squared = self.C1 + self.C5 * self.E0 + self.C4 * (self.C0 + self.C4 * self.E0)
        return (max(squared, 0.0) / self.density) ** 0.5


EOS = EosEntry("polynomial", Polynomial, Polynomial)


@device
def _factors(eos, density):
    """The part without energy, the factor of E, and the slopes of both with mu."""
    mu = density / eos.density - 1.0
    cold = eos.C0 + mu * (eos.C1 + mu * (eos.C2 + mu * eos.C3))
    heated = eos.C4 + mu * (eos.C5 + mu * eos.C6)
    cold_slope = eos.C1 + mu * (2.0 * eos.C2 + 3.0 * mu * eos.C3)
    heated_slope = eos.C5 + 2.0 * mu * eos.C6
    return cold, heated, cold_slope, heated_slope
