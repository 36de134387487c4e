"""Debris on a clear way out leaves the particles, and nothing else does: records, balances and bits."""

from dataclasses import asdict, replace
from typing import Any

import numpy as np
import pytest

from solver import simulation as simulation_module
from solver.debris import departed, flown
from solver.errors import ProblemError
from solver.problem import Face, Problem, Retirement
from solver.simulation import Simulation, simulate, start
from solver.state import NO_DEBRIS, Retired
from tests.solver.bodies import ABOUT_AXIS, FREE, OPEN, block, box, real_copper

ROUND_OFF = 1e-12  # of sums over a few hundred particles
SPEED = 1000.0  # m/s
REORDERED = 50  # steps between reorderings here, so that short runs have some
STEPS = REORDERED + 10

Corner = tuple[float, ...]


@pytest.fixture(autouse=True)
def reordered_often(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(simulation_module, "SORT_INTERVAL", REORDERED)


def beside(
    low: Corner, high: Corner, velocity: tuple[float, float, float], *, after: float = 0.0
) -> Problem:
    """A target of copper about the axis in the middle of a grid (cells 10 to 13 along it), and a block somewhere."""
    geometry = box(12, 40)
    bodies = (
        block(geometry, low, high, velocity=velocity, name="debris", matter=real_copper()),
        block(geometry, (4.0, 10.0), (10.0, 13.0), name="target", matter=real_copper()),
    )
    rule = Retirement(body=1, after=after)
    return Problem(geometry, bodies, ABOUT_AXIS, end_time=9e-6, retirement=rule)


def behind(**changes: Any) -> Problem:
    """A block that flies away behind the target."""
    return replace(beside((4.0, 17.0), (6.0, 19.0), (0.0, SPEED, 0.0)), **changes)


def leaves(problem: Problem) -> bool:
    """Whether all of the block goes, or nothing does; whatever goes is of the block."""
    simulation = start(problem, threads=1)
    gone = departed(problem, simulation.particles, simulation.body)
    assert (simulation.body[gone] == 0).all()
    assert gone.size in (0, problem.bodies[0].mass.size)
    return bool(gone.size)


def after_retirement(problem: Problem) -> tuple[Simulation, Simulation]:
    """A simulation just before particles are retired, and some steps later."""
    before, simulation = start(problem, threads=1), start(problem, threads=1)
    for _ in range(REORDERED):
        before.advance()
    for _ in range(STEPS):
        simulation.advance()
    return before, simulation


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
        (
            (1.0, 17.0),
            (3.0, 19.0),
            (-SPEED, -SPEED, 0.0),
            False,
        ),  # across the axis, at the far side
        ((1.0, 17.0), (3.0, 19.0), (-SPEED, SPEED, 0.0), True),  # across the axis, and away
    ],
)
def test_departed__is_what_has_come_off_and_meets_nothing(
    low: Corner, high: Corner, velocity: tuple[float, float, float], goes: bool
) -> None:
    assert leaves(beside(low, high, velocity)) == goes


def test_departed__goes_as_a_piece_or_not_at_all() -> None:
    problem = behind()
    debris = problem.bodies[0]
    velocity = np.tile(debris.velocity, (debris.mass.size, 1))
    velocity[-1] = (0.0, -SPEED, 0.0)
    held = replace(debris, velocity=velocity)
    assert not leaves(replace(problem, bodies=(held, problem.bodies[1])))


def test_departed__knows_the_target_by_its_mass_and_not_by_its_size() -> None:
    """The heaviest piece of the target's body stays, whatever is heavier."""
    problem = behind()
    debris = problem.bodies[0]
    heavy = replace(debris, mass=1e3 * debris.mass)
    assert leaves(replace(problem, bodies=(heavy, problem.bodies[1])))


def test_departed__in_three_dimensions_flies_past_the_side_of_the_target() -> None:
    geometry = box(8, 8, 20)
    target = block(geometry, (1.0, 1.0, 8.0), (4.0, 7.0, 10.0), name="target")
    for across, goes in ((2.0 * SPEED, True), (0.0, False)):
        debris = block(geometry, (1.0, 3.0, 14.0), (2.0, 4.0, 15.0), velocity=(across, 0.0, -SPEED))
        rule = Retirement(body=1, after=0.0)
        problem = Problem(geometry, (debris, target), OPEN, end_time=1.0, retirement=rule)
        assert leaves(problem) == goes


def test_debris__is_followed_until_its_time_has_come() -> None:
    for after, retired in ((0.0, True), (1.0, False)):
        _, simulation = after_retirement(behind(retirement=Retirement(body=1, after=after)))
        assert bool(simulation.retired.mass.size) == retired
        assert (simulation.particles.mass.size == simulation.problem.bodies[1].mass.size) == retired


def test_debris__without_retirement_is_followed() -> None:
    _, simulation = after_retirement(behind(retirement=None))
    assert simulation.retired is NO_DEBRIS


@pytest.mark.parametrize("pair", [(Face.WALL, Face.FREE), (Face.SYMMETRIC, Face.SYMMETRIC)])
def test_retirement__where_debris_may_come_back_is_refused(pair: tuple[Face, Face]) -> None:
    with pytest.raises(ProblemError, match="follow it"):
        behind(faces=(ABOUT_AXIS[0], pair, FREE))


# What it leaves


def test_record__is_the_state_in_which_it_went() -> None:
    before, simulation = after_retirement(behind())
    retired = simulation.retired
    order = np.flatnonzero(before.body == 0)
    order = order[np.argsort(before.particles.number[order])]
    place = np.argsort(retired.number)
    for name in set(Retired._fields) - {"time", "body"}:
        np.testing.assert_array_equal(
            getattr(retired, name)[place], getattr(before.particles, name)[order], name
        )
    assert (retired.body == 0).all()
    assert (retired.time == before.time).all()


def test_balances__with_what_was_retired_are_those_of_one_that_is_followed() -> None:
    before, simulation = after_retirement(behind())
    audit = simulation.audit()
    assert simulation.ledger.particles == simulation.problem.bodies[0].mass.size
    assert simulation.ledger.mass == pytest.approx(simulation.retired.mass.sum(), rel=ROUND_OFF)
    assert audit.outflow_energy == pytest.approx(1.0, rel=ROUND_OFF)
    assert audit.mass_error <= ROUND_OFF
    assert audit.momentum_error <= ROUND_OFF
    assert abs(audit.energy_drift) <= ROUND_OFF
    assert before.audit().outflow_mass == 0.0


def test_step__is_no_longer_that_of_debris_which_was_retired() -> None:
    """The convective rule follows the fastest particle."""
    problem = beside((4.0, 17.0), (6.0, 19.0), (0.0, 2.0 * SPEED, 0.0))
    retired, followed = (
        simulate(replace(problem, retirement=rule), threads=1)
        for rule in (problem.retirement, None)
    )
    assert retired.snapshot.retired.mass.size
    assert retired.particle_steps < followed.particle_steps
    assert retired.snapshot.step < followed.snapshot.step


def test_flown__is_straight_mirrored_at_the_axis_and_ends_at_the_edge() -> None:
    problem = behind()
    _, simulation = after_retirement(problem)
    one = Retired(*(field[:1] for field in simulation.retired))
    one = one._replace(
        time=np.array([1e-6]),
        position=np.array([[2e-3, 18e-3, 0.0]]),
        velocity=np.array([[-1000.0, 500.0, 0.0]]),
    )
    # Places at 1, 2, 5 and 20 us: with the record, before the axis, beyond it and mirrored, off the grid of 12 mm.
    expected = {1e-6: (2e-3, 18e-3), 2e-6: (1e-3, 18.5e-3), 5e-6: (2e-3, 20e-3)}
    for time, place in expected.items():
        np.testing.assert_allclose(flown(problem, one, time)[0, :2], place, rtol=1e-12)
    assert np.isnan(flown(problem, one, 20e-6)).all()


# The same bits


def test_retirement__gives_the_same_bits_with_two_threads() -> None:
    one, two = (simulate(behind(), threads=threads, shares=3) for threads in (1, 2))
    assert one.snapshot.retired.mass.size
    for mine, other in zip(
        (*one.snapshot.particles, *one.snapshot.retired),
        (*two.snapshot.particles, *two.snapshot.retired),
        strict=True,
    ):
        assert mine.tobytes() == other.tobytes()
    assert asdict(one.audit) == asdict(two.audit)
