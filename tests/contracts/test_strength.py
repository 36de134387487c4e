"""Every strength stays positive, hardens, returns to its surface, dissipates, and is objective under rotation."""

import math
from typing import Any

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from solver.matter.laws import Matter
from solver.matter.strength import StrengthEntry, hardening, rate_and_heat, stiffness, yield_stress
from solver.matter.strength.johnson_cook import JohnsonCook
from solver.matter.stress import RETURN_TOLERANCE, PointState, advance, return_to_yield
from solver.matter.tensor import added, contract, equivalent_stress, rotated, scaled
from solver.problem import ArtificialViscosity
from solver.registry import entries
from tests.solver.bodies import DENSITY, MELT, SHEAR_MODULUS, SPACING, real_copper

MEMBERS = entries("solver.matter.strength", "STRENGTH")

# Copper in each form; a new member brings its own.
COPPER: dict[str, tuple[float, ...]] = {
    "drucker-prager": (50e6, 0.35, 30e6),
    "elastic": (),
    "johnson-cook": (90e6, 292e6, 0.31, 0.025, 1.09, 1.0),
    "modified-johnson-cook": (90e6, 292e6, 0.31, 0.025, 1.09, 1.0, 0.9),
    "linear-hardening": (157e6, 425e6),
    "perfectly-plastic": (240e6,),
    "steinberg-guinan": (120e6, 640e6, 36.0, 0.45, 28.3e-12, 3.77e-4),
}
NEVER_YIELDS = {"elastic"}
# Hardening that begins steeply; the first is tungsten (studies/materials).
STEEP = [JohnsonCook(1507e6, 176.6e6, 0.12, 0.016, 1.0, 1.0), JohnsonCook(90e6, 270e6, 0.1, 0.0, 1.0, 1.0)]
ROUND_OFF = 1e-12

plastic_strains = st.just(0.0) | st.floats(1e-9, 20.0)
rates = st.floats(0.0, 1e9)
solid_temperatures = st.just(0.0) | st.floats(1e-6, 0.999)
members = st.sampled_from(sorted(MEMBERS))
yielding = st.sampled_from(sorted(set(MEMBERS) - NEVER_YIELDS))
components = st.floats(-1.0, 1.0)
spins = st.tuples(*[st.floats(-3.0, 3.0)] * 3)


@st.composite
def directions(draw: st.DrawFn) -> tuple[float, ...]:
    """Deviators of unit equivalent stress."""
    a, b, *shear = draw(st.tuples(*[components] * 5))
    deviator = (a, b, -a - b, *shear)
    size = equivalent_stress(deviator)
    assume(size > 1e-3)
    return scaled(deviator, 1.0 / size)


def stretched(matter: Matter, *, kelvin: float, strain: float, rate: float = 1e4, steps: int = 1) -> PointState:
    """A point that is stretched in one direction, at constant volume and temperature, to an equivalent strain."""
    point = PointState(DENSITY, 0.0, 0.0, 0.0, (0.0,) * 6, 0.0, kelvin)
    dt = strain / rate / steps
    gradient = rate * np.diag([1.0, -0.5, -0.5])
    for _ in range(steps):
        point, _, _ = advance(matter, ArtificialViscosity(), SPACING, dt, gradient, point)
        point = point._replace(density=DENSITY, energy=0.0, temperature=kelvin)
    return point


def returned(
    strength: Any, trial: tuple[float, ...], modulus: float, plastic_strain: float, rate: float, homologous: float
) -> tuple[tuple[float, ...], float]:
    """The return to yield at a rate and a temperature, as stiff as at rest."""
    factor = rate_and_heat(strength, rate, homologous, 1.0)
    return return_to_yield(strength, trial, modulus, plastic_strain, factor)


@pytest.fixture(params=list(MEMBERS))
def strength(request: pytest.FixtureRequest) -> Any:
    return copper(request.param)


def copper(name: str) -> Any:
    entry: StrengthEntry = MEMBERS[name]
    return entry.record(*COPPER[name])


def test_strength__brings_an_example() -> None:
    assert set(COPPER) == set(MEMBERS), "give each form its copper above"


@given(members, plastic_strains, rates, st.floats(0.0, 1.0))
def test_yield_stress__is_never_negative(name: str, plastic_strain: float, rate: float, homologous: float) -> None:
    value = yield_stress(copper(name), plastic_strain, rate, homologous)
    assert math.isfinite(value)
    assert value >= 0.0


@given(members, plastic_strains, plastic_strains)
def test_hardening__does_not_fall_with_plastic_strain(name: str, one: float, other: float) -> None:
    low, high = sorted((one, other))
    assert hardening(copper(name), low)[0] <= hardening(copper(name), high)[0]


@given(members, st.floats(1e-6, 2.0))
def test_hardening__slope_is_its_derivative(name: str, strain: float) -> None:
    """By central differences; the step is where truncation and round-off are both small."""
    strength, half = copper(name), 1e-4 * strain
    (above, _), (below, _) = (hardening(strength, strain + gap) for gap in (half, -half))
    stress, slope = hardening(strength, strain)
    assert math.isclose(slope, (above - below) / (2.0 * half), rel_tol=1e-6, abs_tol=1e-9 * stress / half)


@given(members, rates, rates, solid_temperatures)
def test_yield_stress__does_not_fall_with_rate(name: str, one: float, other: float, homologous: float) -> None:
    low, high = sorted((one, other))
    slow, fast = (rate_and_heat(copper(name), rate, homologous, 1.0) for rate in (low, high))
    assert slow <= fast


@given(members, rates, st.floats(0.0, 1.0), st.floats(0.0, 1.0))
def test_yield_stress__does_not_grow_with_temperature(name: str, rate: float, one: float, other: float) -> None:
    low, high = sorted((one, other))
    cold, warm = (rate_and_heat(copper(name), rate, homologous, 1.0) for homologous in (low, high))
    assert warm <= cold


@given(members, plastic_strains, rates)
def test_melt__takes_all_strength(name: str, plastic_strain: float, rate: float) -> None:
    assert yield_stress(copper(name), plastic_strain, rate, 1.0) == 0.0


@pytest.mark.parametrize("kelvin", [MELT, 1.5 * MELT])
def test_melt__takes_the_shear_stress_of_a_point(strength: Any, kelvin: float) -> None:
    point = stretched(real_copper()._replace(strength=strength), kelvin=kelvin, strain=1e-3)
    assert equivalent_stress(point.deviator) == 0.0


@given(
    yielding.map(lambda name: copper(name)) | st.sampled_from(STEEP),
    directions(),
    plastic_strains,
    rates,
    solid_temperatures,
    st.floats(1.0, 1e3),
)
def test_return__ends_on_the_surface_of_the_new_plastic_strain(
    strength: Any, direction: tuple[float, ...], plastic_strain: float, rate: float, homologous: float, beyond: float
) -> None:
    size = beyond * yield_stress(strength, plastic_strain, rate, homologous)
    trial = scaled(direction, size)
    stress, slip = returned(strength, trial, SHEAR_MODULUS, plastic_strain, rate, homologous)
    surface = yield_stress(strength, plastic_strain + slip, rate, homologous)
    assert abs(equivalent_stress(stress) - surface) <= 1.01 * RETURN_TOLERANCE * size
    # Along the elastic slope: trial - 3 G slip is the stress.
    gap = size - 3.0 * SHEAR_MODULUS * slip - equivalent_stress(stress)
    assert abs(gap) <= ROUND_OFF * size


@given(members, directions(), plastic_strains, st.floats(0.0, 0.999))
def test_return__leaves_stress_inside_the_surface_alone(
    name: str, direction: tuple[float, ...], plastic_strain: float, share: float
) -> None:
    strength = copper(name)
    size = share * min(yield_stress(strength, plastic_strain, 1.0, 0.0), 1e12)
    trial = scaled(direction, size)
    assert returned(strength, trial, SHEAR_MODULUS, plastic_strain, 1.0, 0.0) == (trial, 0.0)


@given(members, directions(), plastic_strains, rates, st.floats(0.0, 1.0), st.floats(0.0, 1e12))
def test_return__dissipates(
    name: str, direction: tuple[float, ...], plastic_strain: float, rate: float, homologous: float, size: float
) -> None:
    """The stress does work, never negative, on the strain that the return turns from elastic into plastic."""
    trial = scaled(direction, size)
    stress, slip = returned(copper(name), trial, SHEAR_MODULUS, plastic_strain, rate, homologous)
    plastic = scaled(added(trial, stress, -1.0), 0.5 / SHEAR_MODULUS)
    assert slip >= 0.0
    assert contract(stress, plastic) >= 0.0


@given(yielding, directions(), spins, plastic_strains, st.floats(1.0, 100.0))
def test_return__turns_with_the_trial_stress(
    name: str, direction: tuple[float, ...], spin: tuple[float, float, float], plastic_strain: float, beyond: float
) -> None:
    strength = copper(name)
    size = beyond * yield_stress(strength, plastic_strain, 1e5, 0.3)
    trial = scaled(direction, size)
    arguments = (SHEAR_MODULUS, plastic_strain, 1e5, 0.3)
    stress, slip = returned(strength, trial, *arguments)
    turned, turned_slip = returned(strength, rotated(trial, spin), *arguments)
    # The secant rule stops at RETURN_TOLERANCE of the trial stress: round-off of the rotation may cost it a turn.
    assert abs(turned_slip - slip) * 3.0 * SHEAR_MODULUS <= 2.0 * RETURN_TOLERANCE * size
    gap = added(turned, rotated(stress, spin), -1.0)
    assert equivalent_stress(gap) <= 2.0 * RETURN_TOLERANCE * size


@given(members, st.floats(0.01, 4.0), st.floats(-3e9, 5e11), st.floats(0.0, 1e5))
def test_stiffness__is_positive_and_that_at_rest_is_one(
    name: str, density_ratio: float, pressure: float, kelvin: float
) -> None:
    assert math.isclose(stiffness(copper(name), 1.0, 0.0, 300.0), 1.0, rel_tol=ROUND_OFF)
    value = stiffness(copper(name), density_ratio, pressure, kelvin)
    assert math.isfinite(value)
    assert value > 0.0
