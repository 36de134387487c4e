"""Melting: the melting point over density, the heat of fusion in the temperature, and what is molten on release.

Lindemann's rule as Steinberg, Cochran and Guinan write it, from a density ratio eta_m = rho / rho0 on, at which the
melting point T_m is known::

    T(eta) = T_m exp(2 a (1 / eta_m - 1 / eta)) (eta / eta_m)^(2 (gamma0 - a - 1/3))

Steinberg, Cochran and Guinan (1980), J. Appl. Phys. 51, 1498, with a in Steinberg (1996), UCRL-MA-106439; gamma0 is
that of the equation of state at rest. A melting point at 1 bar belongs to matter that its heat has stretched: eta_m is
where the equation of state has no pressure with the energy of matter at T_m, about 0.97 in aluminium alloys and 0.95
in copper, and the rule gives T_m there exactly. Steinberg's own melting points belong to eta_m = 1 instead. Thinner
than ``thinnest`` the melting point stays as it is: gaps are not the metal's. Without ``a`` it is the same everywhere.

Matter that has reached its melting point keeps it until it has taken up the latent heat L; then its temperature rises
again: T = T_e below it, T_m while T_e - T_m < L / cv, and T_e - L / cv beyond, where T_e is what the equation of state
gives for all of its energy. Pressure follows density and energy, and so does not know of it.
"""

from typing import NamedTuple

import numpy as np

from solver.jit import device
from solver.matter.eos import (
    pressure_terms,
    reference_density,
    reference_sound_speed,
    sound_speed_squared,
    temperature_at,
)
from solver.units import Dimensionless, JoulePerKilogram, Kelvin
from solver.vectors import alike, anywhere, exp, log, maximum, minimum

BISECTIONS = 60  # halvings that bring a density ratio within 0.5 .. 1 to round-off
# A melting point that falls as matter expands is met where both agree; each leaves a third of the error.
ITERATIONS = 30

# rho / rho0 of the thinnest solid: heat stretches metals by some 7 % up to melting (Grueneisen's rule), and what is
# thinner has gaps that are not the metal's.
THINNEST_SOLID = 0.93

# Steps of the classical Runge-Kutta rule in each half of a release.
RELEASE_STEPS = 24
# Solid share below which melting matter bears no tension. Mizukami, Shirai and Yamanaka (2006), ISIJ Int. 46, 1040:
# strength and ductility of steel end at a solid share of 0.8, whatever its alloy. In between it is taken as linear.
SKELETON = 0.8
LEAST_SPAN = 1.0  # K: the temperature of a pure metal tells how much of it has melted too
SLOWEST = 0.2  # of c0, in a release: matter that boils has hardly any sound, and is molten long before


class MeltingCurve(NamedTuple):
    """How the melting point follows density, and how much of the temperature the heat of fusion takes."""

    a: Dimensionless = 0.0
    exponent: Dimensionless = 0.0  # 2 (gamma0 - a - 1/3)
    anchor: Dimensionless = 1.0  # density ratio to which the melting point belongs
    thinnest: Dimensionless = 1.0  # density ratio below which it is constant
    fusion: Kelvin = 0.0  # L / cv
    lowest: Kelvin = 0.0  # no melting point lies below
    # Matter that melts over a range, at the density of the anchor; with a span of 0 it melts at one temperature.
    solidus: Kelvin = 0.0
    span: Kelvin = 0.0  # liquidus less solidus
    vaporisation: JoulePerKilogram = np.inf  # energy at no pressure with which vaporisation begins


def lindemann(eos, melt_temperature, a, *, fusion=0.0, density_ratio=None, liquidus=None):
    """The curve of an equation of state through a melting point (K), by default at no pressure.

    With a ``liquidus`` (K) matter begins to melt at the melting point, and ends there, a kelvin later at least.

    Matter whose heat hardly stretches it (gamma0 of 1/3 or less) has no such rule: its melting point is constant.
    """
    gamma0 = pressure_terms(eos, reference_density(eos), 0.0)[1] / reference_density(eos)
    solidus, span = (0.0, 0.0) if liquidus is None else (melt_temperature, max(liquidus - melt_temperature, LEAST_SPAN))
    if a is None or gamma0 <= 1.0 / 3.0:
        return MeltingCurve(fusion=fusion, solidus=solidus, span=span)
    anchor = density_ratio or stretched(eos, eos.heat_capacity * (melt_temperature - eos.temperature))
    thinnest = min(THINNEST_SOLID, anchor) if density_ratio else anchor
    exponent = float(2.0 * (gamma0 - a - 1.0 / 3.0))
    curve = MeltingCurve(float(a), exponent, anchor, thinnest, fusion, solidus=solidus, span=span)
    return curve._replace(lowest=float(melt_temperature * _growth(curve, 0.0)))


def stretched(eos, energy):
    """The density ratio at which matter with an energy (J/kg) has no pressure."""
    thin, dense = 0.5, 1.0
    for _ in range(BISECTIONS):
        middle = 0.5 * (thin + dense)
        cold, thermal = pressure_terms(eos, middle * reference_density(eos), energy)
        thin, dense = (thin, middle) if cold + thermal * energy > 0.0 else (middle, dense)
    return 0.5 * (thin + dense)


@device
def melting_point(matter, density_ratio):
    """Melting point in K at rho / rho0; infinite for matter that never melts."""
    curve = matter.melting
    if curve.a == 0.0:
        return alike(matter.melt_temperature, density_ratio)
    return matter.melt_temperature * _growth(curve, density_ratio)


@device
def _growth(curve, density_ratio):
    ratio = maximum(density_ratio, curve.thinnest)
    rise = 2.0 * curve.a * (1.0 / curve.anchor - 1.0 / ratio) + curve.exponent * log(ratio * (1.0 / curve.anchor))
    return exp(rise)


@device
def growth(matter, density_ratio):
    """The melting point at rho / rho0 over that at the density of the anchor."""
    if matter.melting.a == 0.0:
        return alike(1.0, density_ratio)
    return _growth(matter.melting, density_ratio)


@device
def with_fusion(matter, kelvin, density_ratio):
    """The temperature in K of matter to which its equation of state gives ``kelvin``, less its heat of fusion."""
    curve = matter.melting
    if curve.fusion == 0.0 or not anywhere(kelvin > curve.lowest):
        return kelvin
    if curve.span == 0.0:
        return minimum(kelvin, maximum(kelvin - curve.fusion, melting_point(matter, density_ratio)))
    grown = growth(matter, density_ratio)
    solidus, span = curve.solidus * grown, curve.span * grown
    melting = solidus + (kelvin - solidus) * span / (span + curve.fusion)
    return minimum(kelvin, maximum(kelvin - curve.fusion, melting))


@device
def coherence(matter, kelvin, density_ratio):
    """Part 0..1 of its cold strength that melting leaves to matter at a temperature (K) and rho / rho0.

    1 up to the solidus, and falls with the solid share to 0 where solid does not hang together. Matter that melts at
    one temperature has all of it: there its laws end strength and tension themselves.
    """
    curve = matter.melting
    if curve.span == 0.0:
        return alike(1.0, kelvin)
    grown = growth(matter, density_ratio)
    molten = (kelvin * (1.0 / grown) - curve.solidus) * (1.0 / curve.span)
    return minimum(maximum(1.0 - molten * (1.0 / (1.0 - SKELETON)), 0.0), 1.0)


def onset_of_melting(matter):
    """Specific energy in J/kg with which matter at no pressure begins to melt; infinite where it never does."""
    eos, energy, curve = matter.eos, 0.0, matter.melting
    if not np.isfinite(matter.melt_temperature) or not np.isfinite(eos.heat_capacity):
        return np.inf
    for _ in range(ITERATIONS):
        ratio = stretched(eos, energy)
        cold = temperature_at(eos, ratio * reference_density(eos), 0.0)
        melt = curve.solidus * growth(matter, ratio) if curve.span else melting_point(matter, ratio)
        energy = eos.heat_capacity * (melt - cold)
    return float(energy)


def melted_mass(matter, residual, mass):
    """Molten mass in kg of particles (n,) of some matter, by their residual energy (n,) in J/kg."""
    onset = onset_of_melting(matter)
    if not np.isfinite(onset):
        return 0.0
    share = melted_share(residual, onset, (matter.melting.fusion + matter.melting.span) * matter.eos.heat_capacity)
    return float((mass * share).sum())


def melted_share(residual, onset, latent_heat):
    """Melted share (n,) of matter with some residual energy (n,), of which ``onset`` begins to melt it, all in J/kg.

    The share of the latent heat that it has taken up (lever rule); without latent heat all melts at once.
    """
    if latent_heat == 0.0:
        return np.where(residual >= onset, 1.0, 0.0)
    return np.clip((residual - onset) / latent_heat, 0.0, 1.0)


def residual_energy(eos, density, energy, pressure):
    """Specific energy (n,) in J/kg of matter once it has expanded to no pressure at constant entropy.

    Its state (n,) is given by density in kg/m3, energy in J/kg and pressure in Pa. It expands along de / drho = p /
    rho^2 to the reference density, where isentropes have a kink, and along drho / dp = 1 / c^2 from there. Matter
    without pressure, or under tension, has the energy that it has: what elastic tension stores is p^2 / (2 K rho), less
    than 1 % of a heat of fusion at 1 GPa.
    """
    # By a round-off thinner, on the side of the kink where the second half runs.
    rest, pressed = reference_density(eos) * (1.0 - 1e-12), np.asarray(pressure) > 0.0
    floor = (SLOWEST * reference_sound_speed(eos)) ** 2

    def by_density(rho, energy):
        cold, thermal = pressure_terms(eos, rho, energy[0])
        return ((cold + thermal * energy[0]) / (rho * rho),)

    def by_pressure(p, state):
        rho, energy = state
        inverse = 1.0 / np.maximum(sound_speed_squared(eos, rho, energy, p), floor)
        return inverse, p / (rho * rho) * inverse

    dense, warm = np.array(density, float), np.array(energy, float)
    thin = np.where(pressed & (dense > rest), rest, dense)
    (warm,) = _integrated(by_density, dense, thin, (warm,))
    cold, thermal = pressure_terms(eos, thin, warm)
    left = np.where(pressed, cold + thermal * warm, 0.0)
    return _integrated(by_pressure, left, 0.0 * left, (thin, warm))[1]


def _integrated(slopes, begin, end, state):
    """A state, a tuple of arrays (n,), taken from one value (n,) of its variable to another by its slopes."""
    step = (end - begin) / RELEASE_STEPS

    def ahead(by, rates):
        return tuple(each + by * rate for each, rate in zip(state, rates, strict=True))

    for index in range(RELEASE_STEPS):
        at = begin + index * step
        first = slopes(at, state)
        second = slopes(at + 0.5 * step, ahead(0.5 * step, first))
        third = slopes(at + 0.5 * step, ahead(0.5 * step, second))
        last = slopes(at + step, ahead(step, third))
        rates = (a + 2.0 * b + 2.0 * c + d for a, b, c, d in zip(first, second, third, last, strict=True))
        state = ahead(step / 6.0, tuple(rates))
    return state
