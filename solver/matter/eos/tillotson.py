"""Tillotson: solid, liquid and vapour of a metal in one closed form.

Tillotson (1962), General Atomic GA-3216; Melosh (1989), Impact Cratering, appendix II. With eta = rho / rho0,
mu = eta - 1 and omega = 1 + e / (e0 eta^2)::

    compressed or cold   p_c = (a + b / omega) rho e + A mu + B mu^2
    expanded and hot     p_h = a rho e + (b rho e / omega + A mu exp(-beta (1 / eta - 1))) exp(-alpha (1 / eta - 1)^2)

Hot is what has more energy than ``e_cv``, at which the last of it boils away; between ``e_iv``, where it begins to
boil, and ``e_cv`` the two are blended in proportion to the energy. In the blend p_c counts from zero up: what boils
bears no tension, least of all the -30 GPa that p_c has at a hundredth of the density. Energies below zero, which
tension can leave, would bring a zero of omega: 1 / omega = 1 - x / (1 + |x|) with x = e / (e0 eta^2) is the same where
x is positive, and stays below 2 where it is not.

The pressure is not linear in the energy; where it is asked for its tangent, this is that of the branch.

Temperature: T_s + (e - e_s) / cv as in ``_hugoniot.py``, with the isentrope e_s, T_s of this form, on which dT / T =
(dp/de) / rho dln rho. In expansion T = T0 + e / cv: heat of boiling counts as temperature; that of melting is taken
off where the material states it (``matter/melting.py``), and is part of ``e_iv`` and ``e_cv`` in any case.
"""

import math
from functools import cache
from typing import Annotated, NamedTuple

import numpy as np
from numpy.polynomial import Polynomial

from solver.jit import device
from solver.matter.eos import EosEntry
from solver.matter.eos._hugoniot import ISENTROPE_DEGREE, horner
from solver.units import (
    Below,
    Density,
    Described,
    Dimensionless,
    HeatCapacity,
    JoulePerKilogram,
    Pascal,
    RoomTemperature,
)
from solver.vectors import absolute, exp, log, maximum, minimum, where

RANGE = 2.0  # compression mu up to which the isentrope is tabulated
INTEGRATION_STEPS = 2048
TANGENTS = 6  # steps of Newton's rule; each leaves a tenth or less of the error


class Tillotson(NamedTuple):
    """Parameters of the form; made by ``tillotson``."""

    density: Density  # rho0
    a: Annotated[Dimensionless, Described("Grueneisen parameter of the vapour", 0.01, 10.0, usual=(0.1, 1.5))]
    b: Annotated[
        Dimensionless, Described("additional Grueneisen parameter of the cold solid", 0.0, 10.0, usual=(0.1, 4.0))
    ]
    A: Annotated[Pascal, Described("bulk modulus", 1e5, 1e13, usual=(1e9, 6e11))]
    B: Annotated[Pascal, Described("stiffening with compression", 0.0, 1e13, usual=(1e8, 1e12))]
    e0: Annotated[JoulePerKilogram, Described("energy that halves b", 1e3, 1e9, usual=(1e5, 1e9))]
    e_iv: Annotated[JoulePerKilogram, Described("incipient vaporisation", 1e3, 1e9, usual=(1e5, 5e7)), Below("e_cv")]
    e_cv: Annotated[JoulePerKilogram, Described("complete vaporisation", 1e3, 1e9, usual=(1e6, 1e8))]
    alpha: Annotated[Dimensionless, Described("decay of the solid's part", 0.0, 100.0, usual=(1.0, 20.0))]
    beta: Annotated[Dimensionless, Described("decay of the cold part", 0.0, 100.0, usual=(1.0, 20.0))]
    heat_capacity: HeatCapacity  # cv
    temperature: RoomTemperature  # of the reference state
    mu_tangent: Dimensionless = RANGE  # largest compression of the isentrope
    # e_s over A t^2 / (2 rho0), and ln(T_s / T0) over ln(1 + mu), by powers of t = mu / (1 + mu)
    isentrope: tuple[float, ...] = ()
    heating: tuple[float, ...] = ()

    def pressure_terms(self, density, energy):
        pressure, _, heating = _state(self, density, energy)
        return pressure - heating * energy, heating

    def linearisations(self):
        return TANGENTS

    def sound_speed_squared(self, density, energy, pressure):
        _, slope, heating = _state(self, density, energy)
        return slope + pressure / (density * density) * heating

    def temperature_at(self, density, energy):
        inside = minimum(maximum(density / self.density - 1.0, 0.0), self.mu_tangent)
        t = inside / (1.0 + inside)
        cold = 0.5 * self.A * t * t / self.density * horner(self.isentrope, t)
        heated = exp(log(1.0 + inside) * horner(self.heating, t))
        return self.temperature * heated + (energy - cold) / self.heat_capacity

    def outside_range(self, density):
        return density > self.density * (1.0 + self.mu_tangent)

    def reference_sound_speed(self):
        return math.sqrt(self.A / self.density)


@cache
def tillotson(**constants):
    """The form with its isentrope."""
    eos = Tillotson(**constants)
    mu, energy, heated = _isentrope(eos)
    t = mu / (1.0 + mu)
    ratios = energy / (0.5 * eos.A * t * t / eos.density), heated / np.log1p(mu)
    fits = (Polynomial.fit(t, ratio, ISENTROPE_DEGREE).convert() for ratio in ratios)
    isentrope, heating = (tuple(float(c) for c in fit.coef) for fit in fits)
    return eos._replace(isentrope=isentrope, heating=heating)


EOS = EosEntry("tillotson", Tillotson, tillotson, boils=True)


def _isentrope(eos):
    """mu, e_s and ln(T_s / T0) on it behind the reference state, by the classical Runge-Kutta rule."""
    mu = np.linspace(0.0, eos.mu_tangent, INTEGRATION_STEPS)
    step = mu[1]

    def slope(at, energy):
        eta = 1.0 + at
        pressure, _, heating = _state(eos, eos.density * eta, energy)
        return np.array([pressure / (eos.density * eta * eta), heating / (eos.density * eta * eta)])

    states = np.zeros((mu.size, 2))
    for index in range(1, mu.size):
        before, state = mu[index - 1], states[index - 1]
        k1 = slope(before, state[0])
        k2 = slope(before + 0.5 * step, state[0] + 0.5 * step * k1[0])
        k3 = slope(before + 0.5 * step, state[0] + 0.5 * step * k2[0])
        k4 = slope(before + step, state[0] + step * k3[0])
        states[index] = state + step / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + k4)
    return mu[1:], states[1:, 0], states[1:, 1]


@device
def _state(eos, density, energy):
    """Pressure, dp/drho at constant energy and dp/de at constant density."""
    eta = density / eos.density
    mu = eta - 1.0
    x = energy / (eos.e0 * eta * eta)
    beyond = 1.0 + absolute(x)
    inverse = 1.0 - x / beyond  # of omega
    bend = -1.0 / (beyond * beyond)  # of the inverse with x; dx/drho = -2 x / rho
    ideal, ideal_slope = eos.a * density * energy, eos.a * energy
    thermal = eos.b * density * energy * inverse
    thermal_slope = eos.b * energy * (inverse - 2.0 * x * bend)
    thermal_heating = eos.b * density * (inverse + x * bend)
    cold = ideal + thermal + (eos.A + eos.B * mu) * mu
    cold_slope = ideal_slope + thermal_slope + (eos.A + 2.0 * eos.B * mu) / eos.density
    cold_heating = eos.a * density + thermal_heating

    stretch = maximum(1.0 / eta - 1.0, 0.0)
    fading = exp(-eos.alpha * stretch * stretch)
    bonds = eos.A * exp(-eos.beta * stretch)
    steepness = 1.0 / (eta * eta * eos.density)  # -d stretch / drho
    inner = thermal + bonds * mu
    inner_slope = thermal_slope + bonds * (1.0 / eos.density + mu * eos.beta * steepness)
    hot = ideal + inner * fading
    hot_slope = ideal_slope + fading * (inner_slope + inner * 2.0 * eos.alpha * stretch * steepness)
    hot_heating = eos.a * density + thermal_heating * fading

    whole = (mu >= 0.0) | (energy <= eos.e_iv)
    vapour = energy >= eos.e_cv
    boiled = where(vapour, 1.0, (energy - eos.e_iv) / (eos.e_cv - eos.e_iv))
    boiled = where(whole, 0.0, boiled)
    pulls = (cold < 0.0) & ~whole  # what boils bears no tension
    cold, cold_slope = where(pulls, 0.0, cold), where(pulls, 0.0, cold_slope)
    cold_heating = where(pulls, 0.0, cold_heating)
    blending = where(whole | vapour, 0.0, (hot - cold) / (eos.e_cv - eos.e_iv))
    return (
        boiled * hot + (1.0 - boiled) * cold,
        boiled * hot_slope + (1.0 - boiled) * cold_slope,
        boiled * hot_heating + (1.0 - boiled) * cold_heating + blending,
    )
