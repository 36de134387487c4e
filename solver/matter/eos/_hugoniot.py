"""The common part of the Mie-Grueneisen forms: the isentrope, temperature, and the sound speed in compression.

Temperature: T_s(rho) + (e - e_s(rho)) / cv. The energy e_s of the isentrope through the reference state, de_s = -p
dV, is integrated once and kept as a polynomial, so that a record holds plain numbers only. T_s = T0 exp(gamma0 mu /
(1 + mu)), since gamma / V is constant in compression. In expansion the reference is the zero-pressure state itself
(e_s = 0, T_s = T0): the elastic dilation stored before the tensile floor, p_cut^2 / (2 K rho), is 1.5 J/g at 1.9 GPa
in copper and amounts to 4 K.
"""

import numpy as np
from numpy.polynomial import Polynomial

from solver.jit import device, generic
from solver.matter.eos import pressure_terms
from solver.vectors import exp, maximum, minimum

# Steps of the isentrope's integration, and the degree of the polynomial in t = mu / (1 + mu) for the ratio of e_s to
# the Hugoniot energy p_H t / (2 rho0), a smooth number that starts at 1. The fit is good to 1e-3 of e_s as far as the
# tangent, and to 1 K at the densities of like-on-like shocks up to 10 km/s: the contract of the materials asks each.
INTEGRATION_STEPS = 4096
ISENTROPE_DEGREE = 9


@generic
def reference_curve(eos, mu):
    """p_H and dp_H/dmu of a form, Pa."""


def with_isentrope(eos):
    """The record of a form with the coefficients of its isentrope."""
    mu, energy = isentrope(eos)
    t, hugoniot = mu / (1.0 + mu), _hugoniot_energy(eos, mu)
    fit = Polynomial.fit(t[1:], energy[1:] / hugoniot[1:], ISENTROPE_DEGREE).convert()
    return eos._replace(isentrope=tuple(float(c) for c in fit.coef))


def isentrope(eos):
    """mu and e_s on it, by the trapezoidal rule on de/dmu = p / (rho0 (1 + mu)^2), implicit in e."""
    mu = np.linspace(0.0, eos.mu_tangent, INTEGRATION_STEPS)
    half = 0.5 * (mu[1] - mu[0])
    a, b = pressure_terms(eos, eos.density * (1.0 + mu), 0.0)
    energy, slope = [0.0], 0.0
    for at, cold, thermal in zip(mu[1:].tolist(), a[1:].tolist(), b[1:].tolist(), strict=True):
        scale = eos.density * (1.0 + at) ** 2
        before = energy[-1] + half * (slope + cold / scale)
        energy.append(before / (1.0 - half * thermal / scale))
        slope = (cold + thermal * energy[-1]) / scale
    return mu, np.array(energy)


@device
def _hugoniot_energy(eos, mu):
    """Energy on the Hugoniot at mu, p_H (V0 - V) / 2, J/kg."""
    pressure, _ = reference_curve(eos, mu)
    return 0.5 * pressure * mu / (1.0 + mu) / eos.density


@device
def isentropic_sound_speed_squared(eos, mu, thinning, pressure):
    """c^2 = dp/drho|e + (p / rho^2) dp/de|rho for p = p_H (1 - gamma0 mu / 2(1 + mu)) + gamma0 rho0 e.

    ``thinning`` is rho0 / rho = 1 / (1 + mu).
    """
    hugoniot, slope = reference_curve(eos, mu)
    half = 0.5 * eos.gamma0 * thinning
    derivative = slope * (1.0 - half * mu) - hugoniot * half * thinning
    return (derivative + eos.gamma0 * pressure * thinning * thinning) * (1.0 / eos.density)


@device
def horner(coefficients, t):
    """A polynomial of ``ISENTROPE_DEGREE``, coefficients by power."""
    value = coefficients[ISENTROPE_DEGREE] * t + coefficients[ISENTROPE_DEGREE - 1]
    for power in range(ISENTROPE_DEGREE - 2, -1, -1):
        value = value * t + coefficients[power]
    return value


@device
def temperature_of_form(eos, density, energy):
    """``temperature_at`` of both forms."""
    mu = maximum(density * (1.0 / eos.density) - 1.0, 0.0)
    lost = mu * (eos.density / density)  # of the volume: mu / (1 + mu)
    t = minimum(lost, eos.mu_tangent / (1.0 + eos.mu_tangent))
    hugoniot, _ = reference_curve(eos, minimum(mu, eos.mu_tangent))
    on_isentrope = 0.5 * hugoniot * t * (1.0 / eos.density) * horner(eos.isentrope, t)
    warmed = eos.temperature * exp(eos.gamma0 * lost)
    return warmed + (energy - on_isentrope) * (1.0 / eos.heat_capacity)
