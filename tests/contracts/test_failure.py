"""Every failure never heals, stays within 0..1, leaves no shear and no tension, and costs its work."""

import math
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from solver.matter.failure import FailureEntry, PointLoading, floor_until_failure, grown_damage, integrity
from solver.matter.laws import Matter
from solver.matter.stress import Acts, PointState, advance
from solver.matter.tension.unlimited import UnlimitedTension
from solver.matter.tensor import equivalent_stress
from solver.problem import ArtificialViscosity
from solver.registry import entries
from tests.solver.bodies import DENSITY, ROOM, SPACING, real_copper

MEMBERS = entries("solver.matter.failure", "FAILURE")
SPALL, TIME, LIMIT = 1.9e9, 1e-7, 0.3  # Pa, s, plastic strain
# Copper of Johnson and Cook (1985) as in the Uintah material files; critical damage and threshold are examples.
FRACTURE = (0.54, 4.89, -3.03, 0.014, 1.12, 1.0, 0.3, 0.05)
COPPER: dict[str, tuple[float, ...]] = {
    "johnson-cook": FRACTURE,
    "johnson-cook-spall": (*FRACTURE, SPALL, 1e5, 1.0 / 3.0, 138.6e9),
    "modified-johnson-cook": FRACTURE,
    "none": (),
    "plastic-strain": (LIMIT,),
    "spall": (SPALL, TIME),
    "spall-rate": (SPALL, 1e5, 1.0 / 3.0, 138.6e9),
    "void-growth": (SPALL, 1e5, 1.0 / 3.0, 1e-3, 0.15, 138.6e9),
}
BREAKS = sorted(set(MEMBERS) - {"none"})

DT = 1e-9
UNSTRESSED = (0.0,) * 6
ROUND_OFF = 1e-12
FRICTION = 0.1  # of rubble
RUBBLE_PRESSURE = 0.05  # of the pressure: what the work of the shear adds to it in a step
VISCOSITY = ArtificialViscosity()

# Stretch in one direction in a step: pulls harder than the spall strength and shears.
PULL = np.diag([0.05, 0.0, 0.0]) / DT
# Tension of the order of the scatter behind a shock, and plastic strains of an impact.
histories = st.lists(
    st.tuples(
        st.floats(0.0, 0.5),
        st.floats(-3e10, 3e10),
        st.floats(-1e10, 1e10),
        st.floats(0.0, 1e9),
        st.floats(0.0, 1.0),
        st.floats(1e-12, 1e-7),
    ),
    max_size=20,
)
members = st.sampled_from(sorted(MEMBERS))


def copper(name: str) -> Any:
    entry: FailureEntry = MEMBERS[name]
    return entry.record(*COPPER[name])


def matter(name: str) -> Matter:
    """Copper that fails in a way, and until then bears any tension and does not melt of it."""
    return real_copper()._replace(failure=copper(name), tension=UnlimitedTension(), melt_temperature=math.inf)


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
    name: str, history: list[tuple[float, float, float, float, float, float]]
) -> None:
    damage = plastic_strain = 0.0
    for slip, *borne in history:
        plastic_strain += slip
        grown = grown_damage(copper(name), damage, PointLoading(plastic_strain, slip, *borne))
        assert damage <= grown <= 1.0
        assert 0.0 <= integrity(copper(name), grown) <= integrity(copper(name), damage)
        damage = grown


@given(members, st.floats(-1e11, 0.0))
def test_failure__never_lifts_the_floor_of_whole_matter_and_gives_molten_matter_none(name: str, floor: float) -> None:
    assert floor_until_failure(copper(name), floor) <= floor
    assert floor_until_failure(copper(name), 0.0) == 0.0


@pytest.mark.parametrize("name", BREAKS)
def test_failure__breaks_what_is_pulled_for_long_enough(name: str) -> None:
    assert pulled_until_broken(name)[-1].damage == 1.0


@pytest.mark.parametrize("name", BREAKS)
def test_failure__takes_shear_and_tension_in_the_step_in_which_it_happens(name: str) -> None:
    *_, before, broken = pulled_until_broken(name)
    assert before.pressure < 0.0
    assert equivalent_stress(before.deviator) > 0.0
    assert broken.pressure == 0.0
    assert broken.deviator == UNSTRESSED


@pytest.mark.parametrize("name", BREAKS)
def test_failure__costs_no_energy_beyond_the_work_of_the_step_in_which_it_happens(name: str) -> None:
    """Half the work of the old stress and half that of the stored one, which has no shear: what was elastic is heat."""
    *_, before, _ = pulled_until_broken(name)
    broken, present, _ = step(matter(name), PULL, before)
    assert broken.damage == 1.0
    stretch, volume = float(np.trace(PULL)) * DT, before.density / broken.density - 1.0
    sheared = DT * sum(stress * rate for stress, rate in zip(before.deviator[:3], np.diag(PULL), strict=True))
    old = sheared - stretch * (before.pressure + VISCOSITY.heating * before.viscosity)
    new = -(broken.pressure + VISCOSITY.heating * broken.viscosity) * volume
    assert math.isclose(broken.energy, before.energy + 0.5 * old / before.density, rel_tol=1e-9, abs_tol=1e-9)
    assert math.isclose(present, broken.energy + 0.5 * new / before.density, rel_tol=1e-9, abs_tol=1e-9)


@pytest.mark.parametrize("name", BREAKS)
@given(gradient=st.lists(st.floats(-0.03, 0.03), min_size=9, max_size=9), pressure=st.floats(0.0, 1e10))
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
@pytest.mark.parametrize("stretch", [0.03, -0.03])
def test_rubble__bears_the_shear_of_its_friction_under_pressure_alone_and_costs_its_work(
    name: str, stretch: float
) -> None:
    """Of any failed matter: tau = q p of Drucker and Prager, p before the work of the shear in the step."""
    rubble = matter(name)._replace(rubble_friction=FRICTION)
    gradient = np.diag([stretch, 0.0, 0.0]) / DT
    new, present, _ = advance(rubble, ArtificialViscosity(0.0, 0.0), SPACING, DT, gradient, at_rest(damage=1.0))
    limit = math.sqrt(3.0) * FRICTION * new.pressure
    assert math.isclose(equivalent_stress(new.deviator), limit, rel_tol=RUBBLE_PRESSURE)
    volume = DENSITY / new.density - 1.0
    work = 0.5 * (stretch * new.deviator[0] - volume * new.pressure) / DENSITY
    assert math.isclose(present - new.energy, work, rel_tol=1e-9, abs_tol=1e-9)
    assert new.plastic_strain == 0.0


@pytest.mark.parametrize("name", BREAKS)
@pytest.mark.parametrize("stretch", [0.05, -0.05])
def test_failed__energy_is_the_work_of_the_stored_pressure(name: str, stretch: float) -> None:
    """Half of a step's work when the energy to come is formed, -p_new dv / 2 and that of the viscosity, no shear."""
    new, present, _ = step(matter(name), np.diag([stretch, 0.0, 0.0]) / DT, at_rest(damage=1.0))
    pushed = new.pressure + VISCOSITY.heating * new.viscosity
    work = -0.5 * pushed * stretch / DENSITY
    assert math.isclose(present - new.energy, work, rel_tol=1e-9, abs_tol=1e-9)
