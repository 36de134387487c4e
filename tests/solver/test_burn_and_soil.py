"""Explosives, null materials and soils: the isentrope of Jones, Wilkins and Lee, the polynomial, Drucker and Prager."""

import math
from typing import Any

import numpy as np
import pytest

from solver.eos import pressure_terms, reference_sound_speed, sound_speed_squared
from solver.eos.jwl import burnt_fraction, lighting_times
from solver.eos.linear_elastic import LinearElastic
from solver.eos.polynomial import Polynomial
from solver.errors import ProblemError
from solver.problem import ArtificialViscosity, Matter, Problem
from solver.simulation import start
from solver.strength.drucker_prager import DruckerPrager
from solver.stress import PointState, advance
from solver.tension.recoverable import RecoverableTension
from solver.tensor import equivalent_stress
from studies.values.recipes import RECIPES
from studies.verification._detonation import TNT, Isentrope, chapman_jouguet
from studies.verification.chapman_jouguet import bar, explosive

ROUND_OFF = 1e-12
INTEGRATED = 1e-9  # of the energy along an isentrope by Simpson's rule
COHESION, FRICTION, TENSILE = 9.74e3, 0.3545, 2.0e4  # Pa, of a soil
SOIL = Matter(
    eos=LinearElastic(density=2100.0, bulk_modulus=5.8e7, temperature=293.0),
    strength=DruckerPrager(COHESION, FRICTION, TENSILE),
    tension=RecoverableTension(TENSILE),
    shear_modulus=2.7e7,
    room_temperature=293.0,
    melt_temperature=math.inf,
)


def pressure(eos: Any, density: float, energy: float) -> float:
    a, b = pressure_terms(eos, density, energy)
    return float(a + b * energy)


def strained(strain: np.ndarray, matter: Matter = SOIL) -> PointState:
    """Soil at rest after one step of a strain (3, 3)."""
    rest = PointState(matter.eos.density, 0.0, 0.0, 0.0, (0.0,) * 6, 0.0, 293.0)
    dt = 1e-6
    quiet = ArtificialViscosity(0.0, 0.0)
    point, _, _ = advance(matter, quiet, 1e-3, dt, strain / dt, rest)
    return point


@pytest.mark.parametrize("volume", [0.75, 1.0, 2.0, 7.0])
def test_products__lie_on_their_isentrope(volume: float) -> None:
    """p and c of the solver at the energy of the closed isentrope from Chapman's and Jouguet's state."""
    state = chapman_jouguet(TNT)
    energy = TNT.E0 + 0.5 * state.pressure * (1.0 - state.volume)
    isentrope = Isentrope(TNT, state.volume, energy)
    burnt = explosive()._replace(burnt=1.0)
    density, specific = TNT.density / volume, isentrope.energy_at(volume) / TNT.density
    got = pressure(burnt, density, specific)
    assert math.isclose(got, isentrope.pressure(volume), rel_tol=ROUND_OFF)
    sound = math.sqrt(sound_speed_squared(burnt, density, specific, got))
    assert math.isclose(sound, isentrope.sound_speed(volume), rel_tol=ROUND_OFF)


def test_products__lose_the_work_of_their_expansion() -> None:
    """The closed isentrope against the integral of the solver's own pressure, step by step."""
    burnt = explosive()._replace(burnt=1.0)
    volumes = np.linspace(1.0, 3.0, 2001)
    isentrope = Isentrope(TNT, 1.0, TNT.E0)
    along = [pressure(burnt, TNT.density / v, isentrope.energy_at(v) / TNT.density) for v in volumes]
    weights = np.array([1.0, *([4.0, 2.0] * 1000)[:-1], 1.0])
    work = float((weights * along).sum()) * (volumes[1] - volumes[0]) / 3.0
    lost = isentrope.energy_at(1.0) - isentrope.energy_at(3.0)
    assert math.isclose(work, lost, rel_tol=INTEGRATED)


def test_explosive__is_without_pressure_until_it_is_lit() -> None:
    assert pressure(explosive(), 2000.0, 1e7) == 0.0


def test_burnt_fraction__rises_over_the_width_of_the_burn() -> None:
    tnt, cell = explosive(), 1e-3
    passed = tnt.width * cell / tnt.detonation_velocity  # s
    times = (-1.0, 0.0, 0.25 * passed, passed, 1.0)
    got = [burnt_fraction(tnt, 0.0, time, cell) for time in times]
    assert got == pytest.approx([0.0, 0.0, 0.25, 1.0, 1.0], rel=ROUND_OFF)


def test_lighting__is_that_of_the_first_detonation_to_arrive() -> None:
    place = np.array([[0.0, 0.0, 0.0], [0.08, 0.0, 0.0]])
    got = lighting_times(place, 1e3, points=[(0.03, 0.04, 0.0)], planes=[((0.1, 0.0, 0.0), (1.0, 0.0, 0.0))])
    assert got == pytest.approx([5e-5, 2e-5], rel=ROUND_OFF)
    assert np.all(np.isinf(lighting_times(place, 1e3)))


def test_problem__asks_an_explosive_for_its_lighting() -> None:
    unlit = bar(20, RECIPES["whipple"])
    [body] = unlit.bodies
    fields = {name: getattr(body, name) for name in body.__dataclass_fields__}
    with pytest.raises(ProblemError, match="an explosive has times"):
        Problem(unlit.geometry, (type(body)(**{**fields, "lighting": None}),), unlit.faces, unlit.end_time)


def test_lighting__goes_with_its_particle_when_they_are_sorted() -> None:
    problem = bar(20, RECIPES["whipple"])
    [body] = problem.bodies
    backwards = {name: getattr(body, name)[::-1] for name in ("position", "velocity", "mass", "lighting")}
    fields = {name: getattr(body, name) for name in body.__dataclass_fields__}
    mirrored = Problem(problem.geometry, (type(body)(**{**fields, **backwards}),), problem.faces, problem.end_time)
    simulation = start(mirrored)
    lit = lighting_times(simulation.particles.position, TNT.velocity, planes=[((0.0,) * 3, (1.0, 0.0, 0.0))])
    assert np.array_equal(simulation.table[-1], lit)


@pytest.mark.parametrize(("density", "energy"), [(1200.0, 0.0), (1200.0, 3e5), (800.0, 1e5)])
def test_polynomial__is_its_formula(density: float, energy: float) -> None:
    c = (1e5, 2.2e9, 9.5e9, 1.457e10, 0.28, 0.3, 0.1)
    water = Polynomial(1000.0, *c, 4186.0, 293.0, 1e6)
    mu, volumetric = density / 1000.0 - 1.0, 1000.0 * energy
    expected = c[0] + c[1] * mu + c[2] * mu**2 + c[3] * mu**3
    expected += (c[4] + c[5] * mu + c[6] * mu**2) * volumetric
    assert math.isclose(pressure(water, density, energy), expected, rel_tol=ROUND_OFF)


def test_polynomial__of_a_gas_is_ideal() -> None:
    """C4 = C5 = gamma - 1: p = (gamma - 1) rho e, and c^2 = gamma p / rho at its reference state."""
    gas = Polynomial(1.2, 0.0, 0.0, 0.0, 0.0, 0.4, 0.4, 0.0, 718.0, 293.0, 2.5e5)
    assert math.isclose(pressure(gas, 2.4, 3e5), 0.4 * 2.4 * 3e5, rel_tol=ROUND_OFF)
    assert math.isclose(reference_sound_speed(gas) ** 2, 1.4 * 1e5 / 1.2, rel_tol=ROUND_OFF)


@pytest.mark.parametrize("squeeze", [0.0, -1e-3, -5e-3])
def test_soil__returns_to_the_cone_at_its_own_pressure(squeeze: float) -> None:
    """Shear far beyond the surface ends at tau = k + q p, with the pressure of the density and no other."""
    strain = np.eye(3) * squeeze / 3.0
    strain[0, 1] = strain[1, 0] = 0.02
    point = strained(strain)
    tau = equivalent_stress(point.deviator) / math.sqrt(3.0)
    assert math.isclose(tau, COHESION + FRICTION * point.pressure, rel_tol=1e-9)
    assert point.plastic_strain > 0.0
    compression = point.density / SOIL.eos.density - 1.0
    assert math.isclose(point.pressure, SOIL.eos.bulk_modulus * compression, rel_tol=1e-9, abs_tol=1e-6)


def test_soil__is_elastic_inside_the_cone() -> None:
    strain = np.zeros((3, 3))
    strain[0, 1] = strain[1, 0] = 0.9 * COHESION / (2.0 * SOIL.shear_modulus)
    point = strained(strain)
    assert point.plastic_strain == 0.0
    tau = equivalent_stress(point.deviator) / math.sqrt(3.0)
    assert math.isclose(tau, 0.9 * COHESION, rel_tol=1e-6)


@pytest.mark.parametrize("tensile", [2.0e4, 5.0e4])
def test_soil__is_cut_off_in_tension(tensile: float) -> None:
    """p ends at -t, and shear at k - q t; at the apex of the cone, p = -k / q, none is left."""
    soil = SOIL._replace(strength=DruckerPrager(COHESION, FRICTION, tensile), tension=RecoverableTension(tensile))
    strain = np.eye(3) * 1e-2
    strain[0, 1] = strain[1, 0] = 0.02
    point = strained(strain, soil)
    assert point.pressure == -tensile
    tau = equivalent_stress(point.deviator) / math.sqrt(3.0)
    expected = max(0.0, COHESION - FRICTION * tensile)
    assert math.isclose(tau, expected, rel_tol=1e-9, abs_tol=1e-9 * COHESION)
