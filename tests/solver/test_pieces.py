"""Debris of a body of revolution as pieces: books balanced, neighbours together, a seed that repeats."""

import math
from collections.abc import Callable
from functools import cache

import numpy as np
import pytest

from solver.audit import Books, Totals
from solver.grid.flight import Flight
from solver.grid.pieces import QUARTER, Scattered, scatter
from solver.problem import Problem
from solver.state import DENSITY, ENERGY, LONGEST, MASS, PARTED, S11, S33, VX, VY, VZ, Arrivals, X, Y, Z
from tests.claims.rows import Row, equal, relative
from tests.solver.bodies import ABOUT_AXIS, block, box, real_copper
from tests.solver.bodies import DENSITY as COPPER

SPACING = 0.5e-3  # of the particles of the next grid, m
SIZE = 1e-3  # of the pieces, m
SPEED = 6000.0  # m/s
EXACT = 1e-12
SAMPLING = 0.15  # of a mean of some hundred drawn masses


def stage() -> Problem:
    """A disc of copper."""
    geometry = box(12, 12)
    disc = block(geometry, (0.0, 2.0), (8.0, 6.0), matter=real_copper(), velocity=(0.0, SPEED, 0.0))
    return Problem(geometry=geometry, bodies=(disc,), faces=ABOUT_AXIS, end_time=1e-6)


def flight(problem: Problem) -> Flight:
    """The disc as it flies to a grid, growing evenly; each particle with heat and stress of its own."""
    [disc] = problem.bodies
    count = disc.mass.size
    table = np.zeros((LONGEST, count))
    table[X], table[Y], table[MASS], table[DENSITY] = disc.position[:, 0], 5e-4, disc.mass, 0.5 * COPPER
    table[VX], table[VY] = 2e5 * disc.position[:, 0], SPEED + 2e5 * disc.position[:, 1]
    table[ENERGY], table[PARTED] = np.linspace(1e5, 2e5, count), 1e6
    table[S11 : S33 + 1] = np.array([[2e6], [-1e6], [-1e6]])
    time = 1e-5 - disc.position[:, 1] / SPEED
    order = np.argsort(time, kind="stable")
    table, mass = table[:, order], disc.mass
    energy = float((table[MASS] * (table[ENERGY] + 0.5 * (table[VX] ** 2 + table[VY] ** 2))).sum())
    momentum = np.array([0.0, float(table[MASS] @ table[VY]), 0.0])
    start = Totals(float(mass.sum()), momentum, kinetic=energy, internal=0.0, momentum_scale=1.0)
    arrivals = Arrivals(time[order], np.zeros(count, np.int64), table)
    return Flight(arrivals, order, Books(start), missed=0.0, ahead=0.0, angular_momentum_error=0.0)


@cache
def landed(size: float = SIZE, seed: int = 1) -> Scattered:
    problem = stage()
    flown = flight(problem)
    return scatter(problem, flown, np.full(flown.number.size, size), spacing=SPACING, seed=seed)


def energy_of(table: np.ndarray) -> float:
    return float((table[MASS] * (table[ENERGY] + 0.5 * (table[VX : VZ + 1] ** 2).sum(axis=0))).sum())


@pytest.mark.claim("debris", "pieces-in-the-books")
@pytest.mark.parametrize("size", [SIZE, math.inf, 0.01 * SPACING])
def test_pieces__keep_mass_momentum_and_energy(size: float, compared: Callable[[Row], None]) -> None:
    """Pieces, whole matter and what is finer than a particle bring a quarter of what flew, and what planes gave."""
    table, books = landed(size).flight.arrivals.table, landed(size).flight.books
    where, start = f"pieces of {1e3 * size:g} mm", flight(stage()).books.start
    for name, expected, got in (
        ("mass (kg)", QUARTER * start.mass, float(table[MASS].sum())),
        ("momentum along the flight (N s)", QUARTER * float(start.momentum[1]), float(table[MASS] @ table[VZ])),
        ("energy (J)", QUARTER * start.kinetic, energy_of(table)),
        ("momentum in the books (N s)", QUARTER * float(start.momentum[1]), float(books.start.momentum[2])),
        ("impulse of a plane (N s)", float(table[MASS] @ table[VX]), float(books.impulse[0])),
    ):
        compared(relative(f"{where}: {name}", expected=expected, got=got, within=EXACT))
    compared(equal(f"{where}: in the quarter", expected=True, got=bool((table[X : Y + 1] >= 0.0).all())))
    assert (np.diff(landed(size).flight.arrivals.time) >= 0.0).all()


def test_pieces__are_drawn_about_the_cube_of_their_size() -> None:
    pieces = [landed(seed=seed) for seed in range(1, 9)]
    whole = np.concatenate([np.pi / 6.0 * COPPER * each.diameter**3 for each in pieces])
    assert whole.mean() == pytest.approx(COPPER * SIZE**3, rel=SAMPLING)
    assert np.median(whole) == pytest.approx(math.log(2.0) * COPPER * SIZE**3, rel=2.0 * SAMPLING)


def test_pieces__are_spheres_of_solid_matter_that_fly_as_one() -> None:
    table = landed(3.0 * SIZE).flight.arrivals.table
    speeds = np.unique(table[VZ])
    assert speeds.size < 100
    assert (table[DENSITY] > 0.95 * COPPER).all()
    assert not table[S11].any()
    for speed in speeds:
        mine = table[:, table[VZ] == speed]
        assert np.ptp(mine[VX]) == np.ptp(mine[ENERGY]) == 0.0
        assert np.ptp(mine[Z]) == 0.0


def test_whole_matter__keeps_its_state_turned_about_the_axis() -> None:
    table = landed(math.inf).flight.arrivals.table
    radius, outward = np.hypot(table[X], table[Y]), np.hypot(table[VX], table[VY])
    assert np.allclose(outward, 2e5 * radius, rtol=1e-9)
    assert np.allclose(table[X] * table[VY], table[Y] * table[VX], rtol=1e-9)
    assert np.allclose(table[S11 : S33 + 1].sum(axis=0), 0.0, atol=1.0)
    cos = (table[X] / radius) ** 2
    assert np.allclose(table[S11], cos * 2e6 + (1.0 - cos) * -1e6)


def test_seed__repeats_the_pieces_and_another_draws_others() -> None:
    first, again, other = (landed(seed=seed).flight.arrivals.table for seed in (1, 1, 2))
    assert np.array_equal(first, again)
    assert not np.array_equal(first, other)
