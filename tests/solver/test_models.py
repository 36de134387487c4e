"""Models of matter one by one: their published numbers, and the branches that their contracts do not reach."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from solver.eos import pressure_terms, reference_density, reference_sound_speed, temperature
from solver.failure.spall import Spall
from solver.problem import ArtificialViscosity, Matter
from solver.strength import hardening, melting, rate_and_heat, stiffness, yield_stress
from solver.strength.johnson_cook import JohnsonCook
from solver.strength.steinberg_guinan import SOFTEST, THINNEST_SOLID
from solver.stress import RETURN_TOLERANCE, PointState, advance, homologous_temperature, return_to_yield
from solver.tensor import equivalent_stress, scaled
from tests.contracts.test_eos import made, pressure, shock
from tests.contracts.test_strength import copper, directions, stretched
from tests.solver.bodies import DENSITY, MELT, ROOM, SHEAR_MODULUS, SOUND_SPEED, SPACING, elastic_copper, real_copper

DT = 1e-9
ROUND_OFF = 1e-12
UNSTRESSED = (0.0,) * 6

# Equations of state

# K on the copper Hugoniot at 2..7 km/s, printed to 1 K in reference/physics.md 1.4; the closed form. The cubic one is
# cooler by up to 5 %, because its shocks are weaker.
HUGONIOT_KELVIN = {1000.0: 709, 1500.0: 1351, 2000.0: 2430, 2500.0: 4015, 3000.0: 6150, 3500.0: 8868}  # fmt: skip
PRINTED_KELVIN = 0.501


@pytest.mark.parametrize(("particle_speed", "kelvin"), HUGONIOT_KELVIN.items())
def test_closed_form__is_as_hot_on_the_hugoniot_as_published(particle_speed: float, kelvin: float) -> None:
    eos = made("mie-grueneisen")
    _, _, density = shock(eos, particle_speed)
    assert abs(temperature(eos, density, 0.5 * particle_speed**2) - kelvin) <= PRINTED_KELVIN


@pytest.mark.parametrize("particle_speed", list(HUGONIOT_KELVIN))
def test_linear__shock_is_the_closed_form(particle_speed: float) -> None:
    """rho0 Us up = K up / (Us - up), so Us = up / 2 + sqrt(up^2 / 4 + c^2)."""
    eos = made("linear-elastic")
    half = 0.5 * particle_speed
    expected = half + math.hypot(half, reference_sound_speed(eos))
    assert math.isclose(shock(eos, particle_speed)[0], expected, rel_tol=1e-11)


def test_tillotson__has_no_jump_at_either_end_of_boiling() -> None:
    eos = made("tillotson")
    for share in (0.95, 0.7, 0.4, 0.1):
        at = [
            pressure(eos, share * eos.density, edge * (1.0 + side))
            for edge in (eos.e_iv, eos.e_cv)
            for side in (-1e-9, 1e-9)
        ]
        # Cold matter bears tension, boiling matter none: the floor of molten matter is zero there.
        assert math.isclose(max(at[0], 0.0), at[1], rel_tol=1e-6, abs_tol=1e3)
        assert math.isclose(at[2], at[3], rel_tol=1e-6)


def test_tillotson__vapour_presses_where_the_other_forms_pull() -> None:
    """At a tenth of the density with 10 MJ/kg: an ideal gas of a = 0.5, and tension in Mie and Grueneisen's form."""
    vapour = pressure(made("tillotson"), 890.0, 10e6)
    assert math.isclose(vapour, 0.5 * 890.0 * 10e6, rel_tol=1e-6)
    assert pressure(made("mie-grueneisen"), 890.0, 10e6) < 0.0


# Strengths

# Copper at a point, MPa: 90 at no strain, 90 + 292 * 0.2^0.31 = 267.3 at 0.2 (267 in reference/physics.md 5.7), times
# 1 + 0.025 ln(1e6) = 1.3454, times 1 - T*^1.09: 0.5303 at 827 K (T* = 0.5), 0.0010302 at 1355 K (T* = 1 - 1 / 1058).
POINTS = [
    (0.0, 1.0, ROOM, 90.0),
    (0.2, 1.0, ROOM, 267.3),
    (0.0, 1e6, ROOM, 121.1),
    (0.2, 1e6, ROOM, 359.6),
    (0.0, 1.0, 827.0, 47.73),
    (0.2, 1.0, 827.0, 141.8),
    (0.2, 1.0, 1355.0, 0.2754),
    (0.2, 1.0, MELT, 0.0),
    (0.2, 1e6, 2000.0, 0.0),
]
FOUR_DIGITS = 5e-4  # half of the last digit of the smallest first one


@pytest.mark.parametrize(("strain", "rate", "kelvin", "expected"), POINTS)
def test_johnson_cook__is_the_stress_of_a_stretched_point(
    strain: float, rate: float, kelvin: float, expected: float
) -> None:
    """The whole strain is the plastic one and the elastic one, stress / 3 G, on top of it."""
    total = strain + expected * 1e6 / (3.0 * SHEAR_MODULUS)
    point = stretched(real_copper(), kelvin=kelvin, strain=total, rate=rate, steps=400)
    assert math.isclose(equivalent_stress(point.deviator) / 1e6, expected, rel_tol=FOUR_DIGITS)


def test_johnson_cook__without_a_softening_exponent_is_strong_until_it_melts() -> None:
    plain = JohnsonCook(90e6, 292e6, 0.31, 0.025, math.inf, 1.0)
    assert [rate_and_heat(plain, 1.0, homologous, 1.0) for homologous in (0.0, 0.999, 1.0)] == [1, 1, 0]


@pytest.mark.parametrize(
    "constants",
    [
        (1507e6, 176.6e6, 0.12, 0.016, 1.0, 1.0),  # tungsten (studies/materials)
        (90e6, 270e6, 0.1, 0.0, 1.0, 1.0),
    ],
)
@given(directions(), st.floats(1.0, 1e3), st.just(0.0) | st.floats(1e-12, 1.0))
def test_return__arrives_where_hardening_begins_steeply(
    constants: tuple[float, ...], direction: tuple[float, ...], beyond: float, plastic_strain: float
) -> None:
    strength = JohnsonCook(*constants)
    size = beyond * yield_stress(strength, plastic_strain, 1.0, 0.0)
    trial = scaled(direction, size)
    stress, slip = return_to_yield(strength, trial, SHEAR_MODULUS, plastic_strain, 1.0)
    surface = yield_stress(strength, plastic_strain + slip, 1.0, 0.0)
    assert abs(equivalent_stress(stress) - surface) <= 1.01 * RETURN_TOLERANCE * size
    gap = size - 3.0 * SHEAR_MODULUS * slip - equivalent_stress(stress)
    assert abs(gap) <= ROUND_OFF * size


def test_steinberg_guinan__hardens_no_farther_than_its_hardest() -> None:
    assert hardening(copper("steinberg-guinan"), 20.0) == (640e6, 0.0)


def test_steinberg_guinan__melts_with_gaps_as_the_metal_between_them() -> None:
    steinberg = copper("steinberg-guinan")
    assert melting(steinberg, 0.5) == melting(steinberg, THINNEST_SOLID) < 1.0


def test_steinberg_guinan__melts_before_it_is_as_soft_as_its_floor() -> None:
    """Pulled as hard as a tensile floor lets it be, or cold with the pressure of its compression."""
    matter = real_copper()._replace(strength=copper("steinberg-guinan"), melt_temperature=1790.0)
    for ratio in np.linspace(0.8, 2.0, 121):
        melt = matter.melt_temperature * melting(matter.strength, ratio)
        cold, _ = pressure_terms(matter.eos, ratio * reference_density(matter.eos), 0.0)
        law = stiffness(matter.strength, ratio, max(cold, -2e9), melt)
        assert law / min(ratio / THINNEST_SOLID, 1.0) > 2.0 * SOFTEST


@pytest.mark.parametrize(
    ("matter", "kelvin", "expected"),
    [
        (real_copper(), 0.0, 0.0),
        (real_copper(), ROOM, 0.0),
        (real_copper(), 0.5 * (ROOM + MELT), 0.5),
        (real_copper(), MELT, 1.0),
        (real_copper(), 2.0 * MELT, 1.0),
        (elastic_copper(), 1e5, 0.0),
        (real_copper()._replace(melt_temperature=ROOM), 0.0, 1.0),
    ],
)
def test_homologous_temperature__runs_from_room_to_melt_and_no_farther(
    matter: Matter, kelvin: float, expected: float
) -> None:
    assert math.isclose(homologous_temperature(matter, kelvin, 1.0), expected, rel_tol=ROUND_OFF)


# Spall and tension: matter at a constant tension, at rest, under a tensile floor at the same spall strength

SPALL, TIME = 1.9e9, 1e-7  # Pa, s
STRETCHED = real_copper()._replace(failure=Spall(SPALL, TIME))


def held(tension_share: float, *, damage: float = 0.0, kelvin: float = ROOM) -> PointState:
    """A point whose equation of state asks for a tension in units of the threshold."""
    density = DENSITY * (1.0 - tension_share * SPALL / (DENSITY * SOUND_SPEED**2))
    cold, _ = pressure_terms(STRETCHED.eos, density, 0.0)
    return PointState(density, 0.0, cold, 0.0, UNSTRESSED, 0.0, kelvin, damage)


def rested(point: PointState, steps: int) -> list[PointState]:
    """A point after each of some steps in which nothing moves, until it has failed."""
    states = [point]
    while len(states) <= steps and states[-1].damage < 1.0:
        new, _, _ = advance(STRETCHED, ArtificialViscosity(), SPACING, DT, np.zeros((3, 3)), states[-1])
        states.append(new)
    return states[1:]


@pytest.mark.parametrize("tension_share", [1.6, 2.1, 2.9])
def test_spall__breaks_held_matter_when_the_integral_reaches_its_time(tension_share: float) -> None:
    """At (sigma / sigma0 - 1)^2 t = K of the tension that is stored, to the step; until then it is carried."""
    point = held(tension_share)
    *whole, broken = rested(point, 1000)
    assert {state.pressure for state in whole} == {point.pressure}
    assert math.isclose(-point.pressure, tension_share * SPALL, rel_tol=ROUND_OFF)
    assert math.ceil(TIME / (-point.pressure / SPALL - 1.0) ** 2 / DT) == len(whole) + 1
    assert broken.pressure == 0.0


@pytest.mark.parametrize("tension_share", [0.5, 0.99])
def test_spall__never_breaks_matter_below_its_threshold(tension_share: float) -> None:
    assert {state.damage for state in rested(held(tension_share), 1000)} == {0.0}


def test_spall__does_not_count_tension_that_molten_matter_does_not_carry() -> None:
    (state,) = rested(held(3.0, kelvin=MELT), 1)
    assert (state.pressure, state.damage) == (0.0, 0.0)
