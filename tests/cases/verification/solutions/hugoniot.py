"""Exact states of plane shocks in Mie-Grueneisen solids without strength, and of their release.

Written from the equations alone, apart from ``solver.matter.eos``: Rankine and Hugoniot's jumps with Us = c0 + s up,
pressure and velocity continuous where two bodies meet, and the isentrope dp/drho = c^2, du = -c drho / rho behind a
centred wave (Zel'dovich and Raizer 1966, chapters I and XI). The solid is p = p_H (1 - gamma mu / 2) + gamma rho e
with gamma rho = gamma0 rho0 in compression, and p = rho0 c0^2 mu + gamma0 rho e in expansion.
"""

import math
from dataclasses import dataclass

from solver.units import Dimensionless, JoulePerKilogram, KilogramPerCubicMetre, MetrePerSecond, Pascal

# Of the fourth-order integration: where the isentrope goes on in expansion its slope has a kink, which leaves an error
# of 1e-5 at 6 km/s.
RELEASE_STEPS = 4000


@dataclass(frozen=True)
class Solid:
    """A solid with a linear Us-up line."""

    name: str
    density: KilogramPerCubicMetre
    c0: MetrePerSecond
    s: Dimensionless
    gamma0: Dimensionless


# Copper and aluminium: Steinberg (1996), UCRL-MA-106439, by way of the input files of Uintah (commit d4508b23),
# gamma0 of copper within the published 1.96 to 2.02. Tungsten: Marsh (1980), LASL Shock Hugoniot Data, from memory,
# with which the pressures of the reference table are met to all their digits.
COPPER = Solid("Cu", 8930.0, 3940.0, 1.489, 1.99)
ALUMINIUM_2024 = Solid("Al 2024", 2785.0, 5328.0, 1.338, 2.00)
TUNGSTEN = Solid("W", 19224.0, 4029.0, 1.237, 1.54)
# Aluminium 6061-T6 and Ti-6Al-4V: Steinberg (1996), and iron: Marsh (1980), both by way of the same files. Lead: Marsh
# (1980), from memory. Steel: Howell and Ball (2002), J. Comput. Phys. 175, 128, whose gamma0 this is; of the published
# 4569 to 4600 m/s this c0 meets the reference table.
ALUMINIUM_6061 = Solid("Al 6061", 2703.0, 5240.0, 1.40, 1.97)
LEAD = Solid("Pb", 11340.0, 2051.0, 1.46, 2.77)
IRON = Solid("Fe", 7850.0, 3574.0, 1.920, 1.69)
STEEL_304 = Solid("304", 7900.0, 4570.0, 1.49, 2.17)
TITANIUM_6AL_4V = Solid("Ti-6Al-4V", 4419.0, 5130.0, 1.028, 1.23)
# The pair of the first example of pyKO (commit 52a848bf, test1-mgrun.yml), a code after Wilkins (1999).
ALUMINIUM_WILKINS = Solid("Al (Wilkins)", 2700.0, 5200.0, 1.5, 2.0)
COPPER_WILKINS = Solid("Cu (Wilkins)", 8930.0, 3900.0, 1.49, 1.99)


@dataclass(frozen=True)
class Shock:
    """A state behind a plane shock that runs into matter at rest."""

    particle_speed: MetrePerSecond
    shock_speed: MetrePerSecond
    pressure: Pascal
    density: KilogramPerCubicMetre
    energy: JoulePerKilogram


def shocked(solid: Solid, particle_speed: float) -> Shock:
    """The state behind a shock of a given particle speed (m/s).

    Copper against copper at 6 km/s, the reference table:

    >>> state = shocked(COPPER, 3000.0)
    >>> round(state.shock_speed, 1), round(state.pressure / 1e9, 2), round(state.density, 1)
    (8407.0, 225.22, 13884.7)

    The other metals at 7 km/s, GPa (reference table: 95.9, 284.2, 282.8, 270.6, 562, 135.0):

    >>> metals = (ALUMINIUM_6061, LEAD, IRON, STEEL_304, TUNGSTEN, TITANIUM_6AL_4V)
    >>> [round(shocked(metal, 3500.0).pressure / 1e9, 1) for metal in metals]
    [95.9, 284.2, 282.8, 270.6, 562.4, 135.0]
    """
    shock_speed = solid.c0 + solid.s * particle_speed
    return Shock(
        particle_speed=particle_speed,
        shock_speed=shock_speed,
        pressure=solid.density * shock_speed * particle_speed,
        density=solid.density * shock_speed / (shock_speed - particle_speed),
        energy=0.5 * particle_speed**2,
    )


def impedance_match(flyer: Solid, target: Solid, speed: float) -> tuple[Shock, Shock]:
    """The states in flyer and target after an impact (m/s); particle speeds are relative to each one's matter ahead.

    rho_t u (c_t + s_t u) = rho_f (v - u) (c_f + s_f (v - u)) is a quadratic equation for u. A symmetric impact has u
    = v / 2; aluminium 2024 on copper at 4 km/s 1290.6 m/s and 67.56 GPa; tungsten on copper at 6 km/s 308.78 GPa
    (reference table of the same constants):

    >>> impedance_match(COPPER, COPPER, 6000.0)[1].particle_speed
    3000.0
    >>> state = impedance_match(ALUMINIUM_2024, COPPER, 4000.0)[1]
    >>> round(state.particle_speed, 1), round(state.pressure / 1e9, 2)
    (1290.6, 67.56)
    >>> [round(state.pressure / 1e9, 2) for state in impedance_match(TUNGSTEN, COPPER, 6000.0)]
    [308.78, 308.78]

    Aluminium on copper at 0.7 km/s 209.2 m/s and 7.867 GPa, at 1 km/s 302.7 m/s and 11.760 GPa; steel on aluminium
    2024 at 3.1 km/s 47.69 GPa:

    >>> weak = [impedance_match(ALUMINIUM_WILKINS, COPPER_WILKINS, speed)[1] for speed in (700.0, 1000.0)]
    >>> [(round(state.particle_speed, 1), round(state.pressure / 1e9, 3)) for state in weak]
    [(209.2, 7.867), (302.7, 11.76)]
    >>> round(impedance_match(STEEL_304, ALUMINIUM_2024, 3100.0)[1].pressure / 1e9, 2)
    47.69
    """
    a = target.density * target.s - flyer.density * flyer.s
    b = target.density * target.c0 + flyer.density * (flyer.c0 + 2.0 * flyer.s * speed)
    c = flyer.density * speed * (flyer.c0 + flyer.s * speed)
    u = 2.0 * c / (b + math.sqrt(b * b + 4.0 * a * c))
    return shocked(flyer, speed - u), shocked(target, u)


def pressure(solid: Solid, density: float, energy: float) -> float:
    """Pressure of the solid, Pa.

    >>> state = shocked(COPPER, 2000.0)
    >>> math.isclose(pressure(COPPER, state.density, state.energy), state.pressure, rel_tol=1e-12)
    True
    """
    return _pressure_and_slopes(solid, density, energy)[0]


def sound_speed(solid: Solid, density: float, energy: float) -> float:
    """c of c^2 = dp/drho + (p / rho^2) dp/de, m/s.

    >>> round(sound_speed(COPPER, COPPER.density, 0.0), 6)
    3940.0
    """
    p, by_density, by_energy = _pressure_and_slopes(solid, density, energy)
    return math.sqrt(by_density + p / density**2 * by_energy)


def _pressure_and_slopes(solid: Solid, density: float, energy: float) -> tuple[float, float, float]:
    """p, dp/drho at constant energy, dp/de at constant density."""
    mu = density / solid.density - 1.0
    stiffness = solid.density * solid.c0**2
    if mu < 0.0:
        p = stiffness * mu + solid.gamma0 * density * energy
        return p, solid.c0**2 + solid.gamma0 * energy, solid.gamma0 * density
    pole = 1.0 - (solid.s - 1.0) * mu
    hugoniot = stiffness * mu * (1.0 + mu) / pole**2
    slope = stiffness * (1.0 + (solid.s + 1.0) * mu) / pole**3
    share = 1.0 - 0.5 * solid.gamma0 * mu / (1.0 + mu)
    by_mu = slope * share - hugoniot * 0.5 * solid.gamma0 / (1.0 + mu) ** 2
    by_energy = solid.gamma0 * solid.density
    return hugoniot * share + by_energy * energy, by_mu / solid.density, by_energy


@dataclass(frozen=True)
class Release:
    """A shocked state after it has expanded to no pressure, or to a tension."""

    velocity_gain: MetrePerSecond  # on top of the particle speed behind the shock
    density: KilogramPerCubicMetre
    energy: JoulePerKilogram
    sound_speed: MetrePerSecond


def released(solid: Solid, state: Shock, *, to: float = 0.0) -> Release:
    """The end of the isentrope from a shocked state to a pressure (Pa), by Runge and Kutta's fourth-order rule.

    de = p / (rho c)^2 dp, drho = dp / c^2, du = -dp / (rho c). A free surface moves with up + gain, a little faster
    than 2 up for copper below 20 GPa and more so above:

    >>> weak = shocked(COPPER, 200.0)
    >>> round((weak.particle_speed + released(COPPER, weak).velocity_gain) / 400.0, 3)
    1.0
    """

    def slopes(p: float, density: float, energy: float) -> tuple[float, float, float]:
        c = sound_speed(solid, density, energy)
        return 1.0 / c**2, p / (density * c) ** 2, -1.0 / (density * c)

    step = (to - state.pressure) / RELEASE_STEPS
    density, energy, gain = state.density, state.energy, 0.0
    for index in range(RELEASE_STEPS):
        p = state.pressure + index * step
        k1 = slopes(p, density, energy)
        k2 = slopes(p + 0.5 * step, density + 0.5 * step * k1[0], energy + 0.5 * step * k1[1])
        k3 = slopes(p + 0.5 * step, density + 0.5 * step * k2[0], energy + 0.5 * step * k2[1])
        k4 = slopes(p + step, density + step * k3[0], energy + step * k3[1])
        mean = [(a + 2.0 * b + 2.0 * c + d) / 6.0 for a, b, c, d in zip(k1, k2, k3, k4, strict=True)]
        density += step * mean[0]
        energy += step * mean[1]
        gain += step * mean[2]
    return Release(gain, density, energy, sound_speed(solid, density, energy))
