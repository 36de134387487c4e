"""Mie-Grueneisen about the Hugoniot Us = c0 + s up: the closed form, and the cubic form of the thesis.

p = p_H (1 - gamma mu / 2) + gamma rho e with mu = rho / rho0 - 1: Ma (2005), Eq. 2-25, gamma rho = gamma0 rho0 in
compression (Eq. 2-22).

Closed form: p_H = rho0 c0^2 mu (1 + mu) / (1 - (s - 1) mu)^2, exact for a linear Us-up line, with a pole at
mu = 1 / (s - 1). In expansion p = rho0 c0^2 mu + gamma0 rho e: keeping gamma rho there would make an effective gamma of
40 at rho = 0.05 rho0 and stop the implicit solve from having an answer.

Cubic form (``MieGrueneisenCubic``): p_H = c mu + d mu^2 + k mu^3, Ma (2005), Eq. 2-26, its mu not below -0.5 and
gamma rho constant on both sides. A truncation: 10 % low at the density of a 6 km/s copper shock.

Temperature: T_s(rho) + (e - e_s(rho)) / cv. The energy e_s of the isentrope through the reference state, de_s = -p dV, is
integrated once and kept as a polynomial: a table would be an array, whose reference counting cost 100 ns a particle and
step. T_s = T0 exp(gamma0 mu / (1 + mu)) since gamma / V is constant in compression. In expansion the
reference is the zero-pressure state itself (e_s = 0, T_s = T0): the elastic dilation stored before the tensile floor,
p_cut^2 / (2 K rho), is 1.5 J/g at 1.9 GPa in copper and amounts to 4 K.
"""

import math
from typing import NamedTuple

import numpy as np
from numpy.polynomial import Polynomial

from solver.eos import (
    EosEntry,
    outside_range,
    pressure_terms,
    reference_density,
    reference_sound_speed,
    sound_speed_squared,
    temperature,
)
from solver.jit import device, generic, implements

# Where the closed form is continued by its tangent, as a share of the pole mu = 1 / (s - 1). At 0.8 the Hugoniot
# pressure of copper is 9 TPa, beyond any impact speed served here; density noise can still reach it.
TANGENT_FROM = 0.8

# Steps of the isentrope's integration, and the degree of the polynomial in t = mu / (1 + mu) for the ratio of e_s to the
# Hugoniot energy p_H t / (2 rho0), a smooth number that starts at 1. The fit is good to 1e-5 of e_s (tests/solver).
INTEGRATION_STEPS = 4096
ISENTROPE_DEGREE = 9


class MieGrueneisen(NamedTuple):
    """Parameters of the closed form; made by ``mie_grueneisen``."""

    density: float  # rho0, kg/m3
    c0: float  # m/s
    s: float  # slope of Us over up
    gamma0: float
    heat_capacity: float  # cv, J/(kg K)
    temperature: float  # of the reference state, K
    mu_tangent: float  # compression from which p_H follows its tangent
    isentrope: tuple[
        float, ...
    ]  # e_s over the Hugoniot energy, as coefficients of t = mu / (1 + mu)


class MieGrueneisenCubic(NamedTuple):
    """Parameters of the cubic form; made by ``mie_grueneisen_cubic``. Fields as in ``MieGrueneisen``."""

    density: float
    c0: float
    s: float
    gamma0: float
    heat_capacity: float
    temperature: float
    mu_tangent: float
    isentrope: tuple[float, ...]


def mie_grueneisen(*, density, c0, s, gamma0, heat_capacity, temperature):
    """The closed form with its isentrope."""
    mu_tangent = TANGENT_FROM / (s - 1.0) if s > 1.0 else 4.0
    return _with_isentrope(
        MieGrueneisen, density, c0, s, gamma0, heat_capacity, temperature, mu_tangent
    )


def mie_grueneisen_cubic(*, density, c0, s, gamma0, heat_capacity, temperature):
    """The thesis' cubic form with its isentrope; its Hugoniot has no pole."""
    return _with_isentrope(
        MieGrueneisenCubic, density, c0, s, gamma0, heat_capacity, temperature, 4.0
    )


EOS = EosEntry("mie_grueneisen", MieGrueneisen)


def _with_isentrope(record, density, c0, s, gamma0, heat_capacity, temperature, mu_tangent):
    blank = (1.0,) + (0.0,) * ISENTROPE_DEGREE
    eos = record(density, c0, s, gamma0, heat_capacity, temperature, mu_tangent, blank)
    mu, energy = _isentrope(eos)
    t = mu / (1.0 + mu)
    hugoniot = np.array([_hugoniot_energy(eos, value) for value in mu])
    fit = Polynomial.fit(t[1:], energy[1:] / hugoniot[1:], ISENTROPE_DEGREE).convert()
    return eos._replace(isentrope=tuple(float(c) for c in fit.coef))


def _isentrope(eos):
    """mu and e_s on it, by the trapezoidal rule on de/dmu = p / (rho0 (1 + mu)^2), implicit in e."""
    mu = np.linspace(0.0, eos.mu_tangent, INTEGRATION_STEPS)
    half = 0.5 * (mu[1] - mu[0])
    energy = np.zeros(mu.size)
    slope = 0.0
    for index in range(1, mu.size):
        a, b = pressure_terms(eos, eos.density * (1.0 + mu[index]))
        scale = eos.density * (1.0 + mu[index]) ** 2
        energy[index] = (energy[index - 1] + half * (slope + a / scale)) / (1.0 - half * b / scale)
        slope = (a + b * energy[index]) / scale
    return mu, energy


@device
def _hugoniot(eos, mu):
    """p_H and dp_H/dmu of the closed form in compression, with its tangent beyond ``mu_tangent``."""
    stiffness = eos.density * eos.c0 * eos.c0
    k = eos.s - 1.0
    inside = min(mu, eos.mu_tangent)
    pole = 1.0 - k * inside
    value = stiffness * inside * (1.0 + inside) / (pole * pole)
    slope = stiffness * (1.0 + (eos.s + 1.0) * inside) / (pole * pole * pole)
    return value + slope * (mu - inside), slope


@device
def _cubic(eos, mu):
    """p_H and dp_H/dmu of the cubic form: Ma (2005), Eq. 2-26."""
    c = eos.density * eos.c0 * eos.c0
    if mu < 0.0:
        return c * mu, c
    d = c * (2.0 * eos.s - 1.0)
    k = c * (eos.s - 1.0) * (3.0 * eos.s - 1.0)
    return mu * (c + mu * (d + mu * k)), c + mu * (2.0 * d + 3.0 * k * mu)


@generic
def _reference_curve(eos, mu):
    """p_H and dp_H/dmu of a form, Pa."""


implements(_reference_curve, MieGrueneisen)(_hugoniot)
implements(_reference_curve, MieGrueneisenCubic)(_cubic)


@device
def _hugoniot_energy(eos, mu):
    """Energy on the Hugoniot at mu, p_H (V0 - V) / 2, J/kg."""
    pressure, _ = _reference_curve(eos, mu)
    return 0.5 * pressure * mu / (1.0 + mu) / eos.density


@implements(pressure_terms, MieGrueneisen)
def _(eos, density):
    mu = density / eos.density - 1.0
    if mu < 0.0:
        return eos.density * eos.c0 * eos.c0 * mu, eos.gamma0 * density
    hugoniot, _ = _hugoniot(eos, mu)
    return hugoniot * (1.0 - 0.5 * eos.gamma0 * mu / (1.0 + mu)), eos.gamma0 * eos.density


@implements(pressure_terms, MieGrueneisenCubic)
def _(eos, density):
    mu = max(density / eos.density - 1.0, -0.5)
    hugoniot, _ = _cubic(eos, mu)
    return hugoniot * (1.0 - 0.5 * eos.gamma0 * mu / (1.0 + mu)), eos.gamma0 * eos.density


@implements(sound_speed_squared, MieGrueneisen)
def _(eos, density, energy, pressure):
    mu = density / eos.density - 1.0
    if mu < 0.0:
        return eos.c0 * eos.c0 + eos.gamma0 * (energy + pressure / density)
    hugoniot, slope = _hugoniot(eos, mu)
    return _isentropic(eos, mu, hugoniot, slope, density, pressure)


@implements(sound_speed_squared, MieGrueneisenCubic)
def _(eos, density, energy, pressure):
    mu = max(density / eos.density - 1.0, -0.5)
    hugoniot, slope = _cubic(eos, mu)
    return _isentropic(eos, mu, hugoniot, slope, density, pressure)


@device
def _isentropic(eos, mu, hugoniot, slope, density, pressure):
    """c^2 = dp/drho|e + (p / rho^2) dp/de|rho for p = p_H (1 - gamma0 mu / 2(1 + mu)) + gamma0 rho0 e."""
    factor = 1.0 - 0.5 * eos.gamma0 * mu / (1.0 + mu)
    derivative = slope * factor - hugoniot * 0.5 * eos.gamma0 / ((1.0 + mu) * (1.0 + mu))
    return derivative / eos.density + eos.gamma0 * eos.density * pressure / (density * density)


@device
def _temperature(eos, density, energy):
    mu = density / eos.density - 1.0
    if mu <= 0.0:
        return eos.temperature + energy / eos.heat_capacity
    inside = min(mu, eos.mu_tangent)
    t = inside / (1.0 + inside)
    ratio = 0.0
    for power in range(ISENTROPE_DEGREE, -1, -1):
        ratio = ratio * t + eos.isentrope[power]
    on_isentrope = eos.temperature * math.exp(eos.gamma0 * mu / (1.0 + mu))
    return on_isentrope + (energy - ratio * _hugoniot_energy(eos, inside)) / eos.heat_capacity


@device
def _outside_range(eos, density):
    return density > eos.density * (1.0 + eos.mu_tangent)


@device
def _reference_density(eos):
    return eos.density


@device
def _reference_sound_speed(eos):
    return eos.c0


for _record in (MieGrueneisen, MieGrueneisenCubic):
    implements(temperature, _record)(_temperature)
    implements(outside_range, _record)(_outside_range)
    implements(reference_density, _record)(_reference_density)
    implements(reference_sound_speed, _record)(_reference_sound_speed)
