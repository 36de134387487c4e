"""Debris on a clear way out leaves the particles, and nothing else does: records, balances and bits."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from solver import simulation as simulation_module
from solver.grid.debris import clear_debris
from solver.problem import Problem, Retirement
from solver.simulation import start
from tests.solver.bodies import ABOUT_AXIS, ROUND_OFF, after, assert_balanced, block, box, leaving, real_copper

SPEED = 1000.0  # m/s
REORDERED = 50  # steps between reorderings here, so that short runs have some
STEPS = REORDERED + 10

Corner = tuple[float, ...]


@pytest.fixture(autouse=True)
def reordered_often(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(simulation_module, "SORT_INTERVAL", REORDERED)


def beside(low: Corner, high: Corner, velocity: tuple[float, float, float]) -> Problem:
    """A target of copper about the axis in the middle of a grid (cells 10 to 13 along it), and a block somewhere."""
    geometry = box(12, 40)
    debris = block(geometry, low, high, velocity=velocity, name="debris", matter=real_copper())
    target = block(geometry, (4.0, 10.0), (10.0, 13.0), name="target", matter=real_copper())
    rule = Retirement(body=1, after=0.0)
    return Problem(geometry, (debris, target), ABOUT_AXIS, end_time=9e-6, retirement=rule)


def behind(**changes: Any) -> Problem:
    """A block that flies away behind the target."""
    return replace(beside((4.0, 17.0), (6.0, 19.0), (0.0, SPEED, 0.0)), **changes)


def leaves(problem: Problem) -> bool:
    """Whether all of the block goes, or nothing does; whatever goes is of the block."""
    simulation = start(problem, threads=1)
    gone = clear_debris(problem, simulation.particles, simulation.body)
    assert (simulation.body[gone] == 0).all()
    assert gone.size in (0, problem.bodies[0].mass.size)
    return bool(gone.size)


# What goes


@pytest.mark.parametrize(
    ("low", "high", "velocity", "goes"),
    [
        ((4.0, 17.0), (6.0, 19.0), (0.0, SPEED, 0.0), True),  # away from the target
        ((4.0, 17.0), (6.0, 19.0), (0.0, -SPEED, 0.0), False),  # at it
        ((4.0, 17.0), (6.0, 19.0), (0.0, 0.0, 0.0), False),  # at rest
        ((4.0, 17.0), (6.0, 19.0), (SPEED, 0.0, 0.0), True),  # past it, through the rim of the grid
        ((4.0, 14.5), (6.0, 16.5), (0.0, SPEED, 0.0), False),  # away, and still in touch
        ((0.0, 17.0), (1.0, 19.0), (0.0, -SPEED, 0.0), True),  # through its hole
        ((1.0, 17.0), (3.0, 19.0), (-SPEED, -SPEED, 0.0), False),  # across the axis, at it
        ((1.0, 17.0), (3.0, 19.0), (-SPEED, SPEED, 0.0), True),  # across the axis, and away
    ],
)
def test_departed__is_what_has_come_off_and_meets_nothing(
    low: Corner, high: Corner, velocity: tuple[float, float, float], goes: bool
) -> None:
    assert leaves(beside(low, high, velocity)) == goes


# What it leaves


def test_balances__hold_with_what_was_retired() -> None:
    simulation = after(behind(), STEPS)
    audit, debris = simulation.audit(), simulation.problem.bodies[0]
    assert simulation.books.ledger.particles == debris.mass.size
    assert simulation.books.ledger.mass == pytest.approx(debris.mass.sum(), rel=ROUND_OFF)
    assert audit.outflow_energy == pytest.approx(1.0, rel=ROUND_OFF)
    assert_balanced(audit)


def test_ledger__books_what_still_expands_of_that_which_leaves_by_itself() -> None:
    """All of it above a limit that every particle exceeds, and none above one that no particle reaches."""
    everything, nothing = (
        after(leaving("axisymmetric", retirement=Retirement(body=0, after=np.inf, expansion=limit)), STEPS)
        for limit in (-np.inf, np.inf)
    )
    assert everything.books.ledger.expanding == pytest.approx(everything.books.ledger.mass, rel=ROUND_OFF)
    assert everything.audit().expanding_mass == pytest.approx(
        everything.books.ledger.mass / everything.books.start.mass
    )
    assert everything.books.ledger.mass == nothing.books.ledger.mass > 0.0
    assert nothing.books.ledger.expanding == 0.0


def test_ledger__books_nothing_that_expands_of_a_piece_that_is_retired() -> None:
    """The mean of the piece is below the limit, so that it leaves as a whole; half of its particles are above."""
    simulation = start(behind(retirement=Retirement(body=1, after=0.0, expansion=1.0)), threads=1)
    simulation.particles.pressure[simulation.body == 0] = np.resize([1e9, -1e9], (simulation.body == 0).sum())
    simulation._retire()
    assert simulation.books.ledger.mass == pytest.approx(simulation.problem.bodies[0].mass.sum(), rel=ROUND_OFF)
    assert simulation.books.ledger.expanding == 0.0


# What leaves by itself


@pytest.mark.parametrize("kind", ["axisymmetric", "cartesian"])
def test_record__holds_what_leaves_the_grid_with_its_totals(kind: str) -> None:
    simulation = after(leaving(kind), STEPS)
    departed, ledger, bodies = simulation.departed, simulation.books.ledger, simulation.audit().bodies
    mass = departed.mass
    assert departed.number.size == ledger.particles > 0
    assert departed.number.size == np.unique(departed.number).size
    everything = np.concatenate([departed.number, simulation.particles.number])
    assert np.unique(everything).size == sum(b.mass.size for b in simulation.problem.bodies)
    assert mass.sum() == pytest.approx(ledger.mass, rel=ROUND_OFF)
    momentum = (mass[:, None] * departed.velocity).sum(axis=0)
    np.testing.assert_allclose(momentum, ledger.momentum, rtol=ROUND_OFF, atol=ROUND_OFF)
    assert (mass * departed.energy).sum() == pytest.approx(ledger.internal, rel=ROUND_OFF)
    kinetic = 0.5 * (mass * (departed.velocity**2).sum(axis=1)).sum()
    assert kinetic == pytest.approx(ledger.kinetic, rel=ROUND_OFF)
    assert (np.diff(departed.time) >= 0.0).all()
    assert kinetic == pytest.approx(sum(body.departed_kinetic for body in bodies), rel=ROUND_OFF)
