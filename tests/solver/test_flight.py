"""Debris flies from one grid to the next with all of its state, and the books of both stages stay balanced."""

from dataclasses import replace
from functools import cache
from typing import Any

import numpy as np
import pytest

from solver.grid.debris import clear_debris
from solver.grid.flight import Flight, flown_columns, fly
from solver.problem import Face, Problem, Retirement
from solver.simulation import Outcome, simulate, start
from solver.state import MASS, S12, STORED, VX, VZ, X, Y, Z, columns, empty_table
from tests.solver.bodies import ABOUT_AXIS, FREE, SPACING, assert_balanced, block, box, real_copper
from tests.solver.test_debris import behind

SPEED = 1000.0  # m/s
SHIFT = 60e-3  # m, from one grid to the next
EXACT = 1e-12


def before(**changes: Any) -> Problem:
    """A block that flies away behind a target, retired at the first reordering."""
    return behind(**{"end_time": 40e-6, **changes})


@cache
def ended() -> Outcome:
    return simulate(before(), threads=1)


def flight(outcome: Outcome | None = None, problem: Problem | None = None) -> Flight:
    """The flight of the block to a grid of 20 cells along it."""
    outcome, problem = outcome or ended(), problem or before()
    shift = np.array([0.0, SHIFT, 0.0])
    return fly(problem, outcome.snapshot, outcome.books, geometry=box(12, 20), shift=shift, bodies=3)


def arriving(**changes: Any) -> Problem:
    """The stage in which the block hits a wall, its bodies and the target's those of the stage before."""
    geometry, flown, begin = box(12, 20), flight(), ended().snapshot.time
    nothing = np.zeros(0)
    gone = [replace(each, position=np.zeros((0, 3)), mass=nothing) for each in before().bodies]
    wall = block(geometry, (0.0, 6.0), (10.0, 9.0), name="wall", matter=real_copper())
    return Problem(
        **{
            "geometry": geometry,
            "bodies": (*(replace(each, velocity=np.zeros(3)) for each in gone), wall),
            "faces": ABOUT_AXIS,
            "start_time": begin,
            "end_time": begin + 12e-6,
            "retirement": Retirement(body=2, after=begin),
            "arrivals": flown.arrivals,
            "books": flown.books,
            **changes,
        }
    )


# The flight


def test_departed__arrives_with_all_of_its_state_on_a_straight_path() -> None:
    departed, arrivals = ended().snapshot.departed, flight().arrivals
    place = 0.5 * SPACING + SHIFT
    passed = (place - departed.position[:, 1]) / departed.velocity[:, 1]
    order = np.argsort(departed.time + passed, kind="stable")
    there = columns(departed)[:, order]
    assert np.allclose(arrivals.table[X], there[X] + (passed * departed.velocity[:, 0])[order], rtol=EXACT)
    assert np.allclose(arrivals.table[Y], 0.5 * SPACING, rtol=EXACT)
    rest = np.setdiff1d(np.arange(STORED + 1), (X, Y))
    assert (arrivals.table[rest] == there[rest]).all()
    assert np.ptp(arrivals.table[S12]) > 0.0, "the block has stresses"
    assert np.allclose(np.diff(arrivals.time), np.diff((departed.time + passed)[order]), atol=1e-18)
    assert arrivals.time[0] == ended().snapshot.time


def test_flight__across_planes_of_symmetry_is_that_of_the_mirror_image() -> None:
    """M x, M v and M s M with M = I - 2 n n."""
    faces = ((Face.SYMMETRIC, Face.FREE), (Face.SYMMETRIC, Face.FREE), FREE)
    problem = replace(before(), geometry=box(4, 4, 4), faces=faces, retirement=None)
    table = empty_table(1, remembers=True)
    table[X : Z + 1, 0], table[VX : VZ + 1, 0] = (1e-3, 2e-3, 3e-3), (-100.0, -50.0, 20.0)
    table[S12 - 3 : S12 + 3, 0] = np.arange(1.0, 7.0)  # 11 22 33 12 23 31
    [image] = flown_columns(problem, table, np.array([30e-6])).T
    assert np.allclose(image[X : Z + 1], (2e-3, 0.5e-3, 3.6e-3))
    assert list(image[VX : VZ + 1]) == [100.0, -50.0, 20.0]
    assert list(image[S12 - 3 : S12 + 3]) == [1.0, 2.0, 3.0, -4.0, 5.0, -6.0]


def test_flight__across_a_plane_of_symmetry_books_what_the_plane_gives() -> None:
    faces, geometry = ((Face.SYMMETRIC, Face.FREE), (Face.SYMMETRIC, Face.FREE), FREE), box(8, 8, 24)
    debris = block(geometry, (3.0, 1.0, 12.0), (4.0, 2.0, 13.0), velocity=(-200.0, 0.0, SPEED), matter=real_copper())
    target = block(geometry, (0.0, 0.0, 6.0), (8.0, 8.0, 8.0), name="target", matter=real_copper())
    rule = Retirement(body=1, after=0.0)
    first = Problem(geometry, (debris, target), faces, end_time=1e-7, retirement=rule)
    outcome = simulate(first, threads=1)
    there = box(8, 8, 10)
    flown = fly(first, outcome.snapshot, outcome.books, geometry=there, shift=np.array([0.0, 0.0, 40e-3]), bodies=3)
    assert (flown.arrivals.table[VX] == 200.0).all()
    bodies = [replace(each, position=np.zeros((0, 3)), velocity=np.zeros(3), mass=np.zeros(0)) for each in first.bodies]
    wall = block(there, (0.0, 0.0, 4.0), (8.0, 8.0, 6.0), name="wall", matter=real_copper())
    begin = outcome.snapshot.time
    second = Problem(
        there,
        (*bodies, wall),
        faces,
        start_time=begin,
        end_time=begin + 1e-7,
        arrivals=flown.arrivals,
        books=flown.books,
    )
    assert_balanced(simulate(second, threads=1).audit)


def test_flight__to_a_grid_aside_keeps_angular_momentum() -> None:
    faces, geometry = (FREE, (Face.SYMMETRIC, Face.FREE), FREE), box(8, 8, 24)
    debris = block(geometry, (3.0, 1.0, 12.0), (4.0, 2.0, 13.0), velocity=(300.0, 0.0, SPEED), matter=real_copper())
    target = block(geometry, (0.0, 0.0, 6.0), (8.0, 8.0, 8.0), name="target", matter=real_copper())
    problem = Problem(geometry, (debris, target), faces, end_time=1e-7, retirement=Retirement(body=1, after=0.0))
    outcome, shift = simulate(problem, threads=1), np.array([8e-3, 0.0, 40e-3])
    flown = fly(problem, outcome.snapshot, outcome.books, geometry=box(8, 8, 10), shift=shift, bodies=3)
    table = flown.arrivals.table
    x, _, z = table[X : Z + 1] + shift[:, None]
    turning = (table[MASS] * (z * table[VX] - x * table[VZ])).sum()
    at_rest = debris.position
    expected = (debris.mass * (at_rest[:, 2] * 300.0 - at_rest[:, 0] * SPEED)).sum()
    assert turning == pytest.approx(expected, rel=EXACT, abs=0.0)
    assert flown.angular_momentum_error <= EXACT
    assert abs(table[X]).max() < 8.0 * SPACING


def test_flight__that_misses_the_next_grid_stays_in_the_books() -> None:
    """The block flies outwards too, past the rim of the next grid."""
    slanted = before()
    debris = replace(slanted.bodies[0], velocity=np.array([0.5 * SPEED, SPEED, 0.0]))
    slanted = replace(slanted, bodies=(debris, slanted.bodies[1]))
    outcome = simulate(slanted, threads=1)
    flown = flight(outcome, slanted)
    assert flown.arrivals.time.size == 0
    assert flown.missed == pytest.approx(debris.mass.sum(), rel=EXACT)
    assert flown.books.ledger.mass == pytest.approx(outcome.books.start.mass, rel=EXACT)


@pytest.mark.parametrize(("bound", "goes"), [(0.99, False), (1.01, True)])
def test_debris__stays_while_its_pressure_drives_it_apart(bound: float, goes: bool) -> None:
    """The mean over its mass of p / rho decides, of a piece that is half under pressure."""
    pressure = 1e9
    problem = before()
    rule = Retirement(body=1, after=0.0, expansion=bound * 0.5 * pressure / problem.bodies[0].density)
    simulation = start(replace(problem, retirement=rule), threads=1)
    mine = np.flatnonzero(simulation.body == 0)
    mass = simulation.particles.mass[mine]
    half = np.cumsum(mass) <= 0.5 * mass.sum()
    simulation.particles.pressure[mine] = np.where(half, pressure * 0.5 * mass.sum() / mass[half].sum(), 0.0)
    assert bool(clear_debris(simulation.problem, simulation.particles, simulation.body).size) == goes


# The next stage


def test_stage__begins_and_ends_with_the_books_of_both_in_balance() -> None:
    outcome = simulate(arriving(), interval=1e-6, threads=1)
    assert len(outcome.history) > 10
    for audit in outcome.history:
        assert_balanced(audit)
    every = sum(each.mass.sum() for each in (*before().bodies, arriving().bodies[2]))
    assert outcome.books.start.mass == pytest.approx(every, rel=EXACT)
    first, last = outcome.history[0], outcome.history[-1]
    momentum = SPEED * before().bodies[0].mass.sum()
    assert first.bodies[0].departed_momentum == pytest.approx(momentum, rel=1e-6)
    assert last.bodies[2].momentum > 0.5 * momentum, "the wall was hit"
    assert outcome.snapshot.waiting == 0.0


def test_arrivals__fly_on_between_joins() -> None:
    """Without a wall in their way they are where their flight has them, whatever step they joined at."""
    problem = arriving(end_time=ended().snapshot.time + 4e-6)
    simulation, arrivals = start(problem, threads=1), flight().arrivals
    while simulation.arrived < arrivals.time.size:
        simulation.advance()
    mine = simulation.body == 0
    number = simulation.particles.number[mine] - problem.bodies[2].mass.size
    expected = flown_columns(problem, arrivals.table, simulation.time - arrivals.time)
    assert np.allclose(simulation.particles.position[mine, 1], expected[Y, number], atol=1e-3 * SPACING)
