"""Every equation of state rests at zero, has the sound of its isentrope, hits published shocks and stays finite."""

import math
from functools import cache
from typing import Any

import numpy as np
import pytest
from scipy.optimize import brentq

from solver.matter.eos import (
    below_range,
    outside_range,
    pressure_terms,
    reference_density,
    reference_sound_speed,
    solve_pressure,
    sound_speed_squared,
    temperature_at,
)
from solver.matter.tension import pressure_floor
from solver.matter.tension.recoverable import RecoverableTension
from solver.registry import entries

FORMS = entries("solver.matter.eos", "EOS")
DENSITY = 8930.0
COPPER = {"density": DENSITY, "c0": 3940.0, "s": 1.489, "gamma0": 1.99, "heat_capacity": 383.0, "temperature": 298.0}
HEAT = {"heat_capacity": 383.0, "temperature": 298.0}

# Each form with a state that it is at rest in. The gas is the right side of the Sod problem: reference/physics.md 5.6;
# a solid is at rest without energy.
EXAMPLES: dict[str, dict[str, float]] = {
    "mie-grueneisen": COPPER,
    "mie-grueneisen-cubic": COPPER,
    "linear-elastic": {"density": DENSITY, "bulk_modulus": DENSITY * 3940.0**2, **HEAT},
    "tillotson": {"density": 8900.0, "a": 0.5, "b": 1.5, "A": 139e9, "B": 110e9, "e0": 32.5e6, **HEAT}
    | {"e_iv": 1.38e6, "e_cv": 6.9e6, "alpha": 5.0, "beta": 5.0},
    "jwl": {"density": 1630.0, "A": 3.712e11, "B": 3.21e9, "R1": 4.15, "R2": 0.95, "omega": 0.3, **HEAT}
    | {"E0": 6.993e9, "detonation_velocity": 6930.0, "burnt": 1.0},
    "polynomial": {"density": 1000.0, "C0": 0.0, "C1": 2.2e9, "C2": 9.5e9, "C3": 1.457e10, **HEAT}
    | {"C4": 0.28, "C5": 0.28, "C6": 0.0},
    "ideal-gas": {"density": 0.125, "sound_speed": math.sqrt(1.4 * 0.8), "gamma": 1.4, **HEAT},
}
AT_REST = {"ideal-gas": 2.0}  # J/kg: p = 0.1 Pa

# Aspects that a form is not asked for, and why.
NOT_ASKED: dict[str, dict[str, str]] = {
    "linear-elastic": {
        "published": "its shocks are in closed form: tests/solver/test_models.py",
        "range": "it is a straight line without an end",
    },
    "ideal-gas": {"cold": "it resists by heat alone", "range": "it is a gas at every density"},
    "jwl": {
        "rest": "its products have pressure at the density of the explosive",
        "range": "its products expand without an end",
        "published": "its published state is Chapman's and Jouguet's: verification case chapman_jouguet",
    },
    "polynomial": {
        "range": "it is a polynomial without an end",
        "published": "its formula is its definition",
        "thin": "its gas resists by heat, and nothing holds on",
    },
    "tillotson": {"published": "its shocks are not printed; near those of the same metal: test_materials.py"},
}

# Central difference over 1e-5 of the density: truncation of the order of its square, round-off of its inverse.
DERIVATIVE = 1e-7
SOLVED = 1e-9  # of the pressure that goes with the energy
ROUND_OFF = 1e-12

# Shocks by the speed of the matter behind them (m/s): Us (m/s), P (in the unit that follows), density (kg/m3), and the
# constants that they were computed with. Symmetric copper shocks at 2..7 km/s, and the right shock of the Sod problem,
# as printed in reference/physics.md 5.1 and 5.6. A new form brings its own.
PUBLISHED: dict[str, tuple[dict[str, float], dict[float, tuple[float, float, float]]]] = {
    "ideal-gas": ({}, {0.92745: (1.75216, 0.30313, 0.26557)}),
    "mie-grueneisen": (
        {"s": 1.489},
        {
            1000.0: (5429.0, 48.48, 10946.3),
            1500.0: (6173.5, 82.69, 11796.2),
            2000.0: (6918.0, 123.56, 12561.6),
            2500.0: (7662.5, 171.07, 13254.5),
            3000.0: (8407.0, 225.22, 13884.7),
            3500.0: (9151.5, 286.03, 14460.4),
        },
    ),
    "mie-grueneisen-cubic": (
        {"s": 1.49},
        {
            1000.0: (5409, 48.31, 10955),
            1500.0: (6121, 81.99, 11829),
            2000.0: (6817, 121.75, 12638),
            2500.0: (7499, 167.43, 13395),
            3000.0: (8170, 218.88, 14111),
            3500.0: (8831, 276.02, 14793),
        },
    ),
}
UNITS = {"ideal-gas": 1.0, "mie-grueneisen": 1e9, "mie-grueneisen-cubic": 1e9}  # of P, Pa
# Half of the last printed digit (and a hair for what lies exactly between two), and the coarser one of the thesis form.
# In the gas the printed speed of the matter has a half digit of its own, 5e-6, which all three follow: dUs/dup = 0.98,
# dP/dup = rho0 (Us + up dUs/dup) = 0.333 and drho/dup = rho0 (Us - up dUs/dup) / (Us - up)^2 = 0.155.
PRINTED = {
    "ideal-gas": (0.991e-5, 0.667e-5, 0.578e-5),
    "mie-grueneisen": (0.0501, 0.00501, 0.0501),
    "mie-grueneisen-cubic": (0.501, 0.00501, 0.501),
}

SHARES = (0.01, 0.1, 0.499, 0.5, 0.9, 1.0, 1.3, 2.0, 2.6, 2.7, 3.5)
CORNERS = [(share, energy) for share in SHARES for energy in (0.0, 1e5, 1e6, 1e7, 5e7)]  # J/kg


def asked(aspect: str) -> Any:
    named = [name for name in FORMS if aspect not in NOT_ASKED.get(name, {})]
    return pytest.mark.parametrize("eos", [made(name) for name in named], ids=named)


@cache
def made(name: str, **changes: float) -> Any:
    """The example of a form; kept, for making one may integrate its isentrope."""
    return FORMS[name].make(**{**EXAMPLES[name], **changes})


def pressure(eos: Any, density: float, energy: float) -> float:
    a, b = pressure_terms(eos, density, energy)
    return float(a + b * energy)


def name_of(eos: Any) -> str:
    return next(name for name, entry in FORMS.items() if isinstance(eos, entry.record))


def shock(eos: Any, particle_speed: float, *, least_slope: float = 0.5) -> tuple[float, float, float]:
    """Us, pressure and density for which the form's own pressure closes the jump conditions, from the state at rest.

    Us exceeds the sound speed by at least ``least_slope`` times the particle speed: 0.5 in a linear law, 1 in metals.
    """
    energy = AT_REST.get(name_of(eos), 0.0)
    before = pressure(eos, eos.density, energy)

    def behind(speed: float) -> tuple[float, float]:
        density = eos.density * speed / (speed - particle_speed)
        return before + eos.density * speed * particle_speed, density

    def gap(speed: float) -> float:
        after, density = behind(speed)
        gained = 0.5 * (after + before) * (1.0 / eos.density - 1.0 / density)
        return pressure(eos, density, energy + gained) - after

    sound = reference_sound_speed(eos)
    slowest = sound + least_slope * particle_speed
    result: float = brentq(gap, slowest, 5.0 * sound, xtol=1e-9, rtol=1e-14)
    return result, *behind(result)


def test_eos__brings_an_example() -> None:
    assert set(EXAMPLES) == set(FORMS), "give each form its example above"


@asked("rest")
def test_eos__has_no_pressure_without_energy(eos: Any) -> None:
    assert pressure(eos, eos.density, 0.0) == 0.0


@asked("rest")
def test_eos__names_its_reference_state(eos: Any) -> None:
    energy = AT_REST.get(name_of(eos), 0.0)
    assert reference_density(eos) == eos.density
    at_rest = sound_speed_squared(eos, eos.density, energy, pressure(eos, eos.density, energy))
    assert math.isclose(reference_sound_speed(eos), math.sqrt(at_rest), rel_tol=ROUND_OFF)
    assert math.isclose(temperature_at(eos, eos.density, energy), 298.0, rel_tol=ROUND_OFF)


@pytest.mark.parametrize("energy", [0.0, 3e5, 5e6])
@pytest.mark.parametrize("share", [0.4, 0.7, 0.95, 1.05, 1.3, 1.8, 2.5])
@asked("sound")
def test_eos__sound_speed_is_the_slope_of_the_isentrope(eos: Any, share: float, energy: float) -> None:
    density = share * eos.density
    at = pressure(eos, density, energy)
    step = 1e-5 * density
    along = at / density**2 * step  # de = p / rho^2 drho at constant entropy
    ahead = pressure(eos, density + step, energy + along)
    behind = pressure(eos, density - step, energy - along)
    slope = (ahead - behind) / (2.0 * step)
    squared = sound_speed_squared(eos, density, energy, at)
    scale = reference_sound_speed(eos) ** 2
    assert math.isclose(squared, slope, rel_tol=DERIVATIVE, abs_tol=DERIVATIVE * scale)


@asked("published")
def test_eos__brings_published_hugoniot_points(eos: Any) -> None:
    assert name_of(eos) in PUBLISHED, "give this form its published shocks above"


@pytest.mark.parametrize(("name", "particle_speed"), [(name, up) for name in PUBLISHED for up in PUBLISHED[name][1]])
def test_eos__reproduces_published_shocks_to_the_printed_digits(name: str, particle_speed: float) -> None:
    changes, table = PUBLISHED[name]
    speed, behind, density = shock(made(name, **changes), particle_speed)
    got = (speed, behind / UNITS[name], density)
    for value, printed, half_digit in zip(got, table[particle_speed], PRINTED[name], strict=True):
        assert abs(value - printed) <= half_digit


@asked("corners")
def test_eos__is_finite_at_the_corners(eos: Any) -> None:
    for share, energy in CORNERS:
        density = share * eos.density
        at = pressure(eos, density, energy)
        squared = sound_speed_squared(eos, density, energy, at)
        kelvin = temperature_at(eos, density, energy)
        assert all(math.isfinite(x) for x in (at, squared, kelvin)), (share, energy)


@asked("cold")
def test_eos__resists_compression_without_heat(eos: Any) -> None:
    densities = np.linspace(1.0, 3.5, 200) * eos.density
    pressures = [pressure(eos, float(density), 0.0) for density in densities]
    assert np.all(np.diff(pressures) > 0.0)


@asked("range")
def test_eos__is_out_of_range_beyond_its_tangent_only(eos: Any) -> None:
    edge = eos.density * (1.0 + eos.mu_tangent)
    assert not outside_range(eos, edge * (1.0 - 1e-9))
    assert outside_range(eos, edge * (1.0 + 1e-9))
    assert not any(outside_range(eos, share * eos.density) for share in (0.01, 1.0, 1.7))


@asked("thin")
def test_eos__says_where_it_holds_on_to_a_constant(eos: Any) -> None:
    """Below its range, and only there, the cold pressure stops falling with density: cubic, mu < -0.5."""
    for share in (0.1, 0.3, 0.499, 0.501, 0.9, 1.0, 2.0):
        density, gamma = share * eos.density, pressure_terms(eos, share * eos.density, 0.0)[1]
        slope = pressure(eos, 1.001 * density, 0.0) - pressure(eos, 0.999 * density, 0.0)
        held = slope == 0.0 and gamma > 0.0 and name_of(eos) != "ideal-gas"
        assert bool(below_range(eos, density)) == held


@pytest.mark.parametrize("trace", [-0.1, -0.01, 0.01, 0.1])
@asked("implicit")
def test_eos__pressure_and_energy_are_solved_for_together(eos: Any, trace: float) -> None:
    """With the floor of copper, which is none where matter is molten."""
    for share, guess in CORNERS:
        density = share * eos.density
        after = density * math.exp(-trace)
        expansion = 1.0 / after - 1.0 / density
        heat = (temperature_at(eos, density, guess) - eos.temperature) / 1058.0
        floor = pressure_floor(RecoverableTension(1.9e9), min(max(heat, 0.0), 1.0), 1.0)
        for known in (guess, 0.9 * guess, 1.1 * guess + 1e4):
            result = max(solve_pressure(eos, after, known, expansion, guess, floor), floor)
            expected = max(pressure(eos, after, known - 0.5 * result * expansion), floor)
            assert math.isclose(result, expected, rel_tol=SOLVED, abs_tol=1.0), (share, guess, known)
