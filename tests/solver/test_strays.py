"""A stray: a grain of no weight in a void that two blocks close, and what becomes of it."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from solver.audit import BodyBalance, Books, Ledger, Totals, totals
from solver.errors import UnphysicalState
from solver.grid.strays import LIGHT, MOST_DISCARDED, strays
from solver.problem import Body, Problem
from solver.simulation import Outcome, simulate
from tests.solver.bodies import (
    ABOUT_AXIS,
    DENSITY,
    OPEN,
    ROUND_OFF,
    SPACING,
    after,
    along,
    assert_balanced,
    block,
    box,
    each_kind,
    real_copper,
    two_blocks,
)

SPEED = 4000.0  # m/s
GAP = 2.5  # cells between the blocks
ENERGY_LIMIT = 100.0 * 0.5 * SPEED**2  # J/kg, that of a physical state


def closing(kind: str, *, grain: float = 1e-6, **changes: Any) -> Problem:
    """A block that flies at one at rest, and a grain of solid copper alone in the space between them.

    Its mass is the part ``grain`` of that of the heaviest particle of the blocks.
    """
    flat = kind == "axisymmetric"
    geometry = box(8, 20) if flat else box(8, 8, 20)
    low, high = ((0.0,), (6.0,)) if flat else ((1.0, 1.0), (7.0, 7.0))
    middle, matter = 6.0 + 0.5 * GAP, real_copper()
    flyer = block(geometry, (*low, 3.0), (*high, 6.0), velocity=along(kind, SPEED), name="flyer", matter=matter)
    plate = block(geometry, (*low, 6.0 + GAP), (*high, 9.0 + GAP), name="plate", matter=matter)
    lone = Body(
        name="grain",
        matter=matter,
        position=SPACING * np.array([[0.75, middle, 0.0] if flat else [3.75, 3.75, middle]]),
        velocity=np.zeros(3),
        mass=np.array([grain * flyer.mass.max()]),
        density=DENSITY,
        spacing=(0.5 * SPACING,) * 3,
    )
    faces = ABOUT_AXIS if flat else OPEN
    return Problem(geometry, (flyer, plate, lone), faces, **{"end_time": 1e-6, **changes})


def hottest(outcome: Outcome) -> float:
    particles = outcome.snapshot.particles
    return float(particles.energy[particles.alive == 1].max())


@each_kind
def test_stray__in_a_void_that_closes_is_discarded_and_accounted_for(kind: str) -> None:
    """A grain of no weight takes a hundred times the energy of the impact; it departs with all of it, counted."""
    outcome = simulate(closing(kind))
    [grain] = np.flatnonzero(outcome.snapshot.departed.body == 2)
    departed, audit = outcome.snapshot.departed, outcome.audit
    assert outcome.counters.discarded == 1
    assert departed.energy[grain] > ENERGY_LIMIT
    assert outcome.books.ledger.discarded == departed.mass[grain]
    assert audit.discarded_mass == pytest.approx(departed.mass[grain] / outcome.books.start.mass, rel=ROUND_OFF)
    assert_balanced(audit)
    assert hottest(outcome) < 0.02 * ENERGY_LIMIT


def test_stray__carries_its_mass_momentum_and_energy_into_the_ledger() -> None:
    outcome = simulate(closing("axisymmetric"))
    away, ledger = totals(outcome.snapshot.departed), outcome.books.ledger
    assert ledger.mass == pytest.approx(away.mass, rel=ROUND_OFF)
    assert ledger.kinetic + ledger.internal == pytest.approx(away.kinetic + away.internal, rel=ROUND_OFF)
    np.testing.assert_allclose(ledger.momentum, away.momentum, rtol=ROUND_OFF, atol=1e-300)


@pytest.mark.parametrize("grain", [1.5 * LIGHT, 1.0])
def test_grain__with_weight_stays_physical(grain: float) -> None:
    """A grain that bears on its neighbours stops them before its state is unphysical."""
    outcome = simulate(closing("axisymmetric", grain=grain))
    assert outcome.counters.discarded == 0
    assert hottest(outcome) < 0.1 * ENERGY_LIMIT


def test_run__that_has_discarded_its_part_dies_of_the_next_stray() -> None:
    """What the stages before have discarded counts."""
    problem = closing("axisymmetric")
    before = MOST_DISCARDED * sum(float(body.mass.sum()) for body in problem.bodies)
    nothing = Totals(mass=0.0, momentum=np.zeros(3), kinetic=0.0, internal=0.0, momentum_scale=0.0)
    books = Books(
        start=nothing, ledger=Ledger(discarded=before), impulse=np.zeros(3), left=3 * (BodyBalance(*6 * [0.0]),)
    )
    with pytest.raises(UnphysicalState, match=r"specific internal energy = .* of 'grain'"):
        simulate(replace(problem, books=books))


def test_particle__of_whole_matter_is_no_stray() -> None:
    simulation = after(two_blocks("axisymmetric"), 5)
    particles = simulation.particles
    assert not strays(simulation.problem, particles, np.arange(particles.mass.size)).any()


@pytest.mark.parametrize("name", ["position", "velocity", "energy", "pressure", "deviator", "temperature"])
def test_stray__with_a_state_that_is_not_finite_is_none(name: str) -> None:
    simulation = after(closing("axisymmetric"), 5)
    [grain] = np.flatnonzero(simulation.body == 2)
    assert strays(simulation.problem, simulation.particles, np.array([grain])).all()
    getattr(simulation.particles, name)[grain] = np.nan
    assert not strays(simulation.problem, simulation.particles, np.array([grain])).any()
