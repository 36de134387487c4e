"""Mie-Grueneisen about the Hugoniot Us = c0 + s up, in closed form.

p = p_H (1 - gamma mu / 2) + gamma rho e with mu = rho / rho0 - 1 (Ma 2005, Eq. 2-25) and, in compression, gamma rho =
gamma0 rho0 (Eq. 2-22). p_H = rho0 c0^2 mu (1 + mu) / (1 - (s - 1) mu)^2 is exact for a linear Us-up line and has a pole
at mu = 1 / (s - 1). In expansion p = rho0 c0^2 mu + gamma0 rho e: keeping gamma rho there would make an effective gamma
of 40 at rho = 0.05 rho0 and leave the implicit solve without an answer.
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

# Where p_H is continued by its tangent, as a part of the pole. At 0.8 the Hugoniot pressure of copper is 15 TPa,
# beyond any impact speed served here; density noise can still reach it, and is counted.
TANGENT_FROM = 0.8
STIFF = 4.0  # the same compression for materials with s <= 1, which have no pole


class MieGrueneisen(NamedTuple):
    """Parameters of the closed form; made by ``mie_grueneisen``."""

    density: Density  # rho0
    c0: Annotated[MetrePerSecond, Described("bulk sound speed", 100.0, 3e4, usual=(500.0, 15e3))]
    s: Annotated[Dimensionless, Described("slope of the Hugoniot", 0.0, 10.0, usual=(0.5, 3.0))]
    gamma0: Annotated[Dimensionless, Described("Grueneisen parameter", 0.0, 10.0, usual=(0.2, 4.0))]
    heat_capacity: HeatCapacity  # cv
    temperature: RoomTemperature  # of the reference state
    mu_tangent: Dimensionless = 0.0  # compression from which p_H follows its tangent
    isentrope: tuple[float, ...] = ()  # e_s over the Hugoniot energy, by powers of mu / (1 + mu)

    def temperature_at(self, density, energy):
        return temperature_of_form(self, density, energy)

    def outside_range(self, density):
        return density > self.density * (1.0 + self.mu_tangent)

    def reference_sound_speed(self):
        return self.c0

    def reference_curve(self, mu):
        """p_H and dp_H/dmu of the closed form in compression, with its tangent beyond ``mu_tangent``."""
        stiffness = self.density * self.c0 * self.c0
        inside = minimum(mu, self.mu_tangent)
        pole = 1.0 / (1.0 - (self.s - 1.0) * inside)
        value = stiffness * inside * (1.0 + inside) * pole * pole
        slope = stiffness * (1.0 + (self.s + 1.0) * inside) * pole * pole * pole
        return value + slope * (mu - inside), slope

    def pressure_terms(self, density, energy):
        thinning = self.density / density
        mu = density * (1.0 / self.density) - 1.0
        pressed = maximum(mu, 0.0)
        hugoniot, _ = reference_curve(self, pressed)
        cold = hugoniot * (1.0 - 0.5 * self.gamma0 * pressed * thinning)
        return (
            where(mu < 0.0, self.density * self.c0 * self.c0 * mu, cold),
            self.gamma0 * minimum(density, self.density),
        )

    def sound_speed_squared(self, density, energy, pressure):
        thinning = self.density / density
        mu = density * (1.0 / self.density) - 1.0
        expanded = self.c0 * self.c0 + self.gamma0 * (energy + pressure * thinning * (1.0 / self.density))
        pressed = isentropic_sound_speed_squared(self, maximum(mu, 0.0), thinning, pressure)
        return where(mu < 0.0, expanded, pressed)


@cache
def mie_grueneisen(**constants):
    """The closed form with its isentrope."""
    eos = MieGrueneisen(**constants)
    mu_tangent = min(TANGENT_FROM / (eos.s - 1.0), STIFF) if eos.s > 1.0 else STIFF
    return with_isentrope(eos._replace(mu_tangent=mu_tangent))


EOS = EosEntry("mie-grueneisen", MieGrueneisen, mie_grueneisen, form="hugoniot")
