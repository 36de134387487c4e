"""What every failure must do: never heal, stay within 0..1, leave no shear and no tension, and cost its work."""

import math
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from solver.eos import pressure_terms
from solver.failure import FailureEntry, floor_until_failure, grown_damage
from solver.problem import ArtificialViscosity, Matter
from solver.registry import entries
from solver.stress import Acts, PointState, advance
from solver.tension.unlimited import UnlimitedTension
from solver.tensor import equivalent_stress
from tests.solver.bodies import DENSITY, MELT, ROOM, SOUND_SPEED, SPACING, real_copper

MEMBERS = entries("solver.failure", "FAILURE")
SPALL, TIME, LIMIT = 1.9e9, 1e-7, 0.3  # Pa, s, plastic strain
COPPER: dict[str, tuple[float, ...]] = {
    "none": (),
    "plastic_strain": (LIMIT,),
    "spall": (SPALL, TIME),
}
BREAKS = sorted(set(MEMBERS) - {"none"})

DT = 1e-9
UNSTRESSED = (0.0,) * 6
ROUND_OFF = 1e-12
VISCOSITY = ArtificialViscosity()

# Stretch in one direction in a step: pulls harder than the spall strength and shears.
PULL = np.diag([0.05, 0.0, 0.0]) / DT
# Tension of the order of the scatter behind a shock, and plastic strains of an impact.
histories = st.lists(
    st.tuples(st.floats(0.0, 0.5), st.floats(-3e10, 3e10), st.floats(1e-12, 1e-7)), max_size=20
)
members = st.sampled_from(sorted(MEMBERS))


def copper(name: str) -> Any:
    entry: FailureEntry = MEMBERS[name]
    return entry.record(*COPPER[name])


def matter(name: str) -> Matter:
    """Copper that fails in a way, and until then bears any tension and does not melt of it."""
    return real_copper()._replace(
        failure=copper(name), tension=UnlimitedTension(), melt_temperature=math.inf
    )


def at_rest(damage: float = 0.0) -> PointState:
    return PointState(DENSITY, 0.0, 0.0, 0.0, UNSTRESSED, 0.0, ROOM, damage)


def step(of: Matter, gradient: np.ndarray, old: PointState) -> tuple[PointState, float, Acts]:
    new, present, acts = advance(of, VISCOSITY, SPACING, DT, gradient, old)
    return new, present, acts


def pulled_until_broken(name: str) -> list[PointState]:
    """A point that is stretched step by step; the last state is the first that has failed."""
    states = [at_rest()]
    while states[-1].damage < 1.0 and len(states) < 200:
        states.append(step(matter(name), PULL, states[-1])[0])
    return states


def test_failure__brings_an_example() -> None:
    assert set(COPPER) == set(MEMBERS), "give each failure its copper above"


@given(members, histories)
def test_damage__never_heals_and_never_exceeds_one(
    name: str, history: list[tuple[float, float, float]]
) -> None:
    damage = plastic_strain = 0.0
    for slip, pressure, dt in history:
        plastic_strain += slip
        grown = grown_damage(copper(name), damage, plastic_strain, pressure, dt)
        assert damage <= grown <= 1.0
        damage = grown


@given(members, st.floats(0.0, 3e10), st.floats(1e-12, 1e-3))
def test_damage__of_matter_that_is_pressed_without_slip_does_not_grow(
    name: str, pressure: float, dt: float
) -> None:
    assert grown_damage(copper(name), 0.0, 0.0, pressure, dt) == 0.0


@given(members, st.floats(-1e11, 0.0))
def test_failure__never_lifts_the_floor_of_whole_matter(name: str, floor: float) -> None:
    assert floor_until_failure(copper(name), floor) <= floor


@pytest.mark.parametrize("name", sorted(MEMBERS))
def test_failure__gives_molten_matter_no_tension(name: str) -> None:
    assert floor_until_failure(copper(name), 0.0) == 0.0


@pytest.mark.parametrize("name", BREAKS)
def test_failure__breaks_what_is_pulled_for_long_enough(name: str) -> None:
    assert pulled_until_broken(name)[-1].damage == 1.0


def test_none__breaks_nothing() -> None:
    states = pulled_until_broken("none")
    assert {state.damage for state in states} == {0.0}
    assert states[-1].pressure < -2.0 * SPALL


@pytest.mark.parametrize("name", BREAKS)
def test_failure__takes_shear_and_tension_in_the_step_in_which_it_happens(name: str) -> None:
    *_, before, broken = pulled_until_broken(name)
    assert before.pressure < 0.0
    assert equivalent_stress(before.deviator) > 0.0
    assert broken.pressure == 0.0
    assert broken.deviator == UNSTRESSED


@pytest.mark.parametrize("name", BREAKS)
def test_failure__leaves_damaged_matter_as_strong_as_whole_matter(name: str) -> None:
    whole, _, _ = step(matter("none"), PULL, at_rest())
    damaged, _, _ = step(matter(name), PULL, at_rest(damage=0.5))
    assert damaged._replace(damage=0.0) == whole


@pytest.mark.parametrize("name", BREAKS)
@given(
    gradient=st.lists(st.floats(-0.03, 0.03), min_size=9, max_size=9),
    pressure=st.floats(0.0, 1e10),
)
def test_failed__bears_neither_shear_nor_tension_whatever_is_done_to_it(
    name: str, gradient: list[float], pressure: float
) -> None:
    old = at_rest(damage=1.0)._replace(pressure=pressure, plastic_strain=LIMIT)
    new, _, _ = step(matter(name), np.array(gradient).reshape(3, 3) / DT, old)
    assert new.pressure >= 0.0
    assert new.deviator == UNSTRESSED
    assert new.plastic_strain == LIMIT
    assert new.damage == 1.0


@pytest.mark.parametrize("name", BREAKS)
def test_failed__carries_pressure_when_it_is_closed_again(name: str) -> None:
    new, _, acts = step(matter(name), np.diag([-0.05, 0.0, 0.0]) / DT, at_rest(damage=1.0))
    assert new.pressure > SPALL
    assert acts.tension_floor == 0


@pytest.mark.parametrize("name", BREAKS)
@pytest.mark.parametrize("stretch", [0.05, -0.05])
def test_failed__energy_is_the_work_of_the_stored_pressure(name: str, stretch: float) -> None:
    """Half of a step's work when the energy to come is formed, -p_new dv / 2 and that of the viscosity, no shear."""
    new, present, _ = step(matter(name), np.diag([stretch, 0.0, 0.0]) / DT, at_rest(damage=1.0))
    pushed = new.pressure + VISCOSITY.heating * new.viscosity
    work = -0.5 * pushed * stretch / DENSITY
    assert math.isclose(present - new.energy, work, rel_tol=1e-9, abs_tol=1e-9)


@pytest.mark.parametrize("name", BREAKS)
def test_failed__counts_each_use_of_the_floor(name: str) -> None:
    _, _, acts = step(matter(name), PULL, at_rest(damage=1.0))
    assert acts.tension_floor == 1


def test_plastic_strain__breaks_at_its_limit() -> None:
    damage = [
        grown_damage(copper("plastic_strain"), 0.0, share * LIMIT, 0.0, DT)
        for share in (0.0, 0.5, 1.0, 3.0)
    ]
    assert damage == [0.0, 0.5, 1.0, 1.0]


@pytest.mark.parametrize("threshold_share", [-1.0, 0.0, 0.5, 1.0])
def test_spall__does_not_mind_tension_up_to_its_threshold(threshold_share: float) -> None:
    assert grown_damage(copper("spall"), 0.3, 0.0, -threshold_share * SPALL, 1.0) == 0.3


@pytest.mark.parametrize(("tension", "duration"), [(1.5, 4.0), (2.0, 1.0), (3.0, 0.25)])
def test_spall__breaks_after_its_time_at_twice_the_threshold_and_by_the_square_elsewhere(
    tension: float, duration: float
) -> None:
    """(sigma / sigma0 - 1)^2 t = K, reached in equal steps to round-off."""
    steps = 1000
    damage = 0.0
    for _ in range(steps - 1):
        damage = grown_damage(
            copper("spall"), damage, 0.0, -tension * SPALL, duration * TIME / steps
        )
    assert math.isclose(damage, 1.0 - 1.0 / steps, rel_tol=1e-10)
    last = grown_damage(copper("spall"), damage, 0.0, -tension * SPALL, duration * TIME)
    assert last == 1.0


# Matter at a constant tension: at rest, thinner than it likes to be, under a tensile floor at the same spall strength

STRETCHED = real_copper()._replace(failure=copper("spall"))


def held(tension_share: float, *, damage: float = 0.0, temperature: float = ROOM) -> PointState:
    """A point whose equation of state asks for a tension in units of the threshold."""
    thinned = 1.0 - tension_share * SPALL / (DENSITY * SOUND_SPEED**2)
    density = DENSITY * thinned
    pressure, _ = pressure_terms(STRETCHED.eos, density, 0.0)
    return PointState(density, 0.0, pressure, 0.0, UNSTRESSED, 0.0, temperature, damage)


def rested(point: PointState, steps: int) -> list[PointState]:
    """A point after each of some steps in which nothing moves, until it has failed."""
    states = [point]
    while len(states) <= steps and states[-1].damage < 1.0:
        states.append(step(STRETCHED, np.zeros((3, 3)), states[-1])[0])
    return states[1:]


@pytest.mark.parametrize("tension_share", [1.6, 2.1, 2.9])
def test_spall__breaks_what_is_held_at_a_tension_when_the_integral_says(
    tension_share: float,
) -> None:
    """At (sigma / sigma0 - 1)^2 t = K of the tension that is stored, to the step."""
    states = rested(held(tension_share), 1000)
    carried = -states[0].pressure
    assert math.isclose(carried, tension_share * SPALL, rel_tol=ROUND_OFF)
    expected = TIME / (carried / SPALL - 1.0) ** 2
    assert math.ceil(expected / DT) == len(states)


@pytest.mark.parametrize("tension_share", [1.6, 2.1, 2.9])
def test_spall__lets_matter_carry_its_tension_until_it_breaks_and_none_after(
    tension_share: float,
) -> None:
    point = held(tension_share)
    *whole, broken = rested(point, 1000)
    assert {state.pressure for state in whole} == {point.pressure}
    assert broken.pressure == 0.0


@pytest.mark.parametrize("tension_share", [0.5, 0.99])
def test_spall__never_breaks_what_is_held_below_its_threshold(tension_share: float) -> None:
    states = rested(held(tension_share), 1000)
    assert {state.damage for state in states} == {0.0}


@pytest.mark.parametrize("tension_share", [1.5, 3.0])
def test_spall__does_not_count_tension_that_molten_matter_does_not_carry(
    tension_share: float,
) -> None:
    (state,) = rested(held(tension_share, temperature=MELT), 1)
    assert (state.pressure, state.damage) == (0.0, 0.0)


@pytest.mark.parametrize("tension_share", [1.5, 3.0])
def test_spall__adds_nothing_to_what_has_failed(tension_share: float) -> None:
    new, _, _ = step(STRETCHED, np.zeros((3, 3)), held(tension_share, damage=1.0))
    assert (new.pressure, new.damage) == (0.0, 1.0)
