"""Tillotson's copper, its shocks and its isentropes, written from the equations alone, apart from ``solver.eos``.

Tillotson (1962), General Atomic GA-3216; constants of copper as in ``studies/materials/copper-ofhc-tillotson.toml``.
"""

import math
from collections.abc import Iterator

from studies.verification._hugoniot import Shock

DENSITY, A, B = 8900.0, 139e9, 110e9  # kg/m3, Pa, Pa
SMALL_A, SMALL_B, ALPHA, BETA = 0.5, 1.5, 5.0, 5.0
E0, E_IV, E_CV = 32.5e6, 1.38e6, 6.9e6  # J/kg
HALVINGS = 200
STEPS = 20_000  # of the fourth-order rule, over the whole release


def pressure(density: float, energy: float) -> float:
    """Pa.

    No pressure at rest; a tenth of the density with 10 MJ/kg is an ideal gas of a = 0.5:

    >>> pressure(DENSITY, 0.0), round(pressure(890.0, 10e6) / (0.5 * 890.0 * 10e6), 6)
    (0.0, 1.0)
    """
    eta = density / DENSITY
    mu, stretch = eta - 1.0, 1.0 / eta - 1.0
    thermal = SMALL_B * density * energy / (energy / (E0 * eta**2) + 1.0)
    condensed = SMALL_A * density * energy + thermal + A * mu + B * mu**2
    if eta >= 1.0 or energy <= E_IV:
        return condensed
    bonds = A * mu * math.exp(-BETA * stretch)
    vapour = SMALL_A * density * energy + (thermal + bonds) * math.exp(-ALPHA * stretch**2)
    if energy >= E_CV:
        return vapour
    boiled = (energy - E_IV) / (E_CV - E_IV)
    return boiled * vapour + (1.0 - boiled) * max(condensed, 0.0)


def shocked(particle_speed: float) -> Shock:
    """The state behind a shock of a particle speed (m/s), by halving: Rankine and Hugoniot's jumps from rest.

    >>> state = shocked(3000.0)
    >>> math.isclose(pressure(state.density, state.energy), state.pressure, rel_tol=1e-9)
    True
    """
    energy = 0.5 * particle_speed**2
    sound = math.sqrt(A / DENSITY)
    low, high = sound + 0.5 * particle_speed, sound + 3.0 * particle_speed
    for _ in range(HALVINGS):
        speed = 0.5 * (low + high)
        density = DENSITY * speed / (speed - particle_speed)
        if pressure(density, energy) > DENSITY * speed * particle_speed:
            low = speed
        else:
            high = speed
    return Shock(particle_speed, speed, DENSITY * speed * particle_speed, density, energy)


def released(state: Shock, densities: list[float]) -> Iterator[tuple[float, float]]:
    """Energy and pressure on the isentrope of a state at falling densities: de = p / rho^2 drho."""
    density, energy = state.density, state.energy
    steps = STEPS // len(densities)
    for end in densities:
        step = (end - density) / steps
        start = density
        for index in range(steps):
            density = start + index * step
            k1 = _slope(density, energy)
            k2 = _slope(density + 0.5 * step, energy + 0.5 * step * k1)
            k3 = _slope(density + 0.5 * step, energy + 0.5 * step * k2)
            k4 = _slope(density + step, energy + step * k3)
            energy += step * (k1 + 2.0 * k2 + 2.0 * k3 + k4) / 6.0
        density = end
        yield energy, pressure(density, energy)


def _slope(density: float, energy: float) -> float:
    return pressure(density, energy) / density**2
