"""Mie-Grueneisen with the cubic p_H of the thesis, for comparison.

p_H = c mu + d mu^2 + k mu^3 in compression and c mu in expansion, mu not below -0.5: Ma (2005), Eq. 2-26. A truncation
of the closed form: 10 % low at the density of a 6 km/s copper shock. gamma = gamma0 rho0 / rho in compression (2-22)
and gamma0 in expansion: with Eq. 2-22 on both sides, expanded matter had a gamma of 40 and single particles of the
thesis' own 6 km/s problem reached 68 km/s.
"""

from functools import cache
from typing import Annotated, NamedTuple

from solver.matter.eos import EosEntry
from solver.matter.eos._hugoniot import (
    isentropic_sound_speed_squared,
    reference_curve,
    temperature_of_form,
    with_isentrope,
)
from solver.units import Density, Described, Dimensionless, HeatCapacity, MetrePerSecond, RoomTemperature
from solver.vectors import maximum, minimum, where

THINNEST = -0.5  # Ma (2005), at Eq. 2-25 (printed 0.5)
RANGE = 4.0  # compression up to which the isentrope is tabulated


class MieGrueneisenCubic(NamedTuple):
    """Parameters of the cubic form; made by ``mie_grueneisen_cubic``."""

    density: Density  # rho0
    c0: Annotated[MetrePerSecond, Described("bulk sound speed", 100.0, 3e4, usual=(500.0, 15e3))]
    # The last term of the cubic is negative for 1/3 < s < 1, and its curve turns down in compression.
    s: Annotated[Dimensionless, Described("slope of the Hugoniot", 1.0, 10.0, usual=(1.0, 3.0))]
    gamma0: Annotated[Dimensionless, Described("Grueneisen parameter", 0.0, 10.0, usual=(0.2, 4.0))]
    heat_capacity: HeatCapacity  # cv
    temperature: RoomTemperature  # of the reference state
    mu_tangent: Dimensionless = RANGE  # largest compression of the isentrope
    isentrope: tuple[float, ...] = ()  # e_s over the Hugoniot energy, by powers of mu / (1 + mu)

    def temperature_at(self, density, energy):
        return temperature_of_form(self, density, energy)

    def outside_range(self, density):
        return density > self.density * (1.0 + self.mu_tangent)

    def reference_sound_speed(self):
        return self.c0

    def reference_curve(self, mu):
        """p_H and dp_H/dmu in Pa."""
        c = self.density * self.c0 * self.c0
        d = c * (2.0 * self.s - 1.0)
        k = c * (self.s - 1.0) * (3.0 * self.s - 1.0)
        pressed = maximum(mu, 0.0)
        return mu * (c + pressed * (d + pressed * k)), c + pressed * (2.0 * d + 3.0 * k * pressed)

    def pressure_terms(self, density, energy):
        mu = maximum(density / self.density - 1.0, THINNEST)
        hugoniot, _ = reference_curve(self, mu)
        return (
            hugoniot * (1.0 - 0.5 * self.gamma0 * mu / (1.0 + maximum(mu, 0.0))),
            self.gamma0 * minimum(density, self.density),
        )

    def sound_speed_squared(self, density, energy, pressure):
        mu = density / self.density - 1.0
        cold = where(mu < THINNEST, 0.0, self.c0 * self.c0 * (1.0 - self.gamma0 * mu))
        return where(
            mu < 0.0,
            cold + self.gamma0 * (energy + pressure / density),
            isentropic_sound_speed_squared(self, maximum(mu, 0.0), self.density / density, pressure),
        )

    def below_range(self, density):
        return density / self.density - 1.0 < THINNEST


@cache
def mie_grueneisen_cubic(**constants):
    """The thesis' cubic form with its isentrope."""
    return with_isentrope(MieGrueneisenCubic(**constants))


EOS = EosEntry("mie-grueneisen-cubic", MieGrueneisenCubic, mie_grueneisen_cubic, kind="mie-grueneisen", form="cubic")
