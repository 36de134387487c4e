"""Tillotson's copper, its shocks and its isentropes, written from the equations alone, apart from the solver.

Tillotson (1962), General Atomic GA-3216; constants of copper as in ``studies/materials/copper-ofhc-tillotson.toml``.
"""

import math
from collections.abc import Iterator

import numpy as np
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

from tests.cases.verification.solutions.hugoniot import Shock

EXACT = 1e-12  # relative error of an integration
DENSITY, A, B = 8900.0, 139e9, 110e9  # kg/m3, Pa, Pa
SMALL_A, SMALL_B, ALPHA, BETA = 0.5, 1.5, 5.0, 5.0
E0, E_IV, E_CV = 32.5e6, 1.38e6, 6.9e6  # J/kg


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
    """The state behind a shock of a particle speed (m/s): Rankine and Hugoniot's jumps from rest.

    >>> state = shocked(3000.0)
    >>> math.isclose(pressure(state.density, state.energy), state.pressure, rel_tol=1e-9)
    True
    """
    energy = 0.5 * particle_speed**2
    sound = math.sqrt(A / DENSITY)

    def state(speed: float) -> Shock:
        density = DENSITY * speed / (speed - particle_speed)
        return Shock(particle_speed, speed, DENSITY * speed * particle_speed, density, energy)

    def excess(speed: float) -> float:
        return pressure(state(speed).density, energy) - state(speed).pressure

    low, high = sound + 0.5 * particle_speed, sound + 3.0 * particle_speed
    return state(float(brentq(excess, low, high, xtol=1e-9)))


def released(state: Shock, densities: list[float]) -> Iterator[tuple[float, float]]:
    """Energy and pressure on the isentrope of a state at falling densities: de = p / rho^2 drho."""

    def slope(density: float, energy: np.ndarray) -> np.ndarray:
        return np.array([pressure(density, energy[0]) / density**2])

    ends = (state.density, densities[-1])
    path = solve_ivp(slope, ends, [state.energy], t_eval=densities, method="DOP853", rtol=EXACT, atol=1e-9)
    for density, energy in zip(densities, path.y[0], strict=True):
        yield float(energy), pressure(density, float(energy))
