"""Schemes and damping: what each keeps, what each loses, and that the loss is booked or seen."""

from typing import Any

import numpy as np
import pytest

from solver.audit import totals
from solver.problem import Damping, Problem, Scheme
from solver.registry import entries
from solver.simulation import Simulation, start
from solver.state import Particles
from tests.solver.bodies import OPEN, SPACING, block, box, two_blocks

SHAPES = {name: entry.record() for name, entry in entries("solver.shapes", "SHAPE").items()}
ROUND_OFF = 1e-12
STEPS = 60


def after(
    kind: str, steps: int = STEPS, threads: int = 1, shares: int = 0, **changes: Any
) -> Simulation:
    """The impact of two blocks after some steps."""
    simulation = start(two_blocks(kind, **changes), threads=threads, shares=shares)
    for _ in range(steps):
        simulation.advance()
    return simulation


@pytest.mark.parametrize("kind", ["axisymmetric", "cartesian"])
@pytest.mark.parametrize("name", SHAPES)
def test_musl__keeps_energy_and_momentum_to_round_off(kind: str, name: str) -> None:
    audit = after(kind, shape=SHAPES[name]).audit()
    assert abs(audit.energy_drift) <= ROUND_OFF
    assert audit.momentum_error <= ROUND_OFF


@pytest.mark.parametrize("name", SHAPES)
def test_flight__of_particles_on_nodes_is_as_free_as_any(name: str) -> None:
    geometry = box(8, 8, 12)
    body = block(geometry, (2.25, 2.25, 2.25), (5.25, 5.25, 5.25), velocity=(0.0, 0.0, 6e3))
    problem = Problem(geometry, (body,), OPEN, end_time=1.0, shape=SHAPES[name])
    simulation = start(problem, threads=1)
    assert (simulation.particles.position % SPACING == 0.0).any()
    for _ in range(3):
        simulation.advance()
    assert np.abs(simulation.particles.pressure).max() <= 1.0


@pytest.mark.parametrize("name", ["linear", "quadratic-bspline"])
@pytest.mark.parametrize("scheme", [Scheme.USF, Scheme.USL])
def test_scheme__keeps_momentum_and_shows_its_energy(name: str, scheme: Scheme) -> None:
    """Neither sees the velocities that the particles end with: the audit is not blind to it."""
    audit = after("axisymmetric", shape=SHAPES[name], scheme=scheme).audit()
    assert audit.momentum_error <= ROUND_OFF
    assert ROUND_OFF < abs(audit.energy_drift) < 0.05


@pytest.mark.parametrize("scheme", [Scheme.USF, Scheme.USL])
def test_scheme__error_of_the_energy_falls_with_the_step(scheme: Scheme) -> None:
    """Both are of first order in dt: a quarter of the step must at least halve it."""
    drifts = []
    for courant in (0.2, 0.05):
        problem = two_blocks("axisymmetric", scheme=scheme, courant=courant)
        simulation = start(problem, threads=1)
        while simulation.time < 0.4e-6:
            simulation.advance()
        drifts.append(abs(simulation.audit().energy_drift))
    assert drifts[1] < 0.5 * drifts[0]


@pytest.mark.parametrize("order", [1, 2])
@pytest.mark.parametrize("name", SHAPES)
@pytest.mark.parametrize("kind", ["axisymmetric", "cartesian"])
def test_damping__books_what_it_takes(kind: str, name: str, order: int) -> None:
    simulation = after(kind, shape=SHAPES[name], damping=Damping(1e6, order))
    audit = simulation.audit()
    assert audit.removed_energy > 0.0
    assert abs(audit.energy_drift) <= ROUND_OFF
    assert audit.momentum_error <= ROUND_OFF
    # Nothing is outside of free bodies that could have taken momentum along their flight.
    along = 2 if kind == "cartesian" else 1
    begin, end = (
        totals(one.particles).momentum[along]
        for one in (start(simulation.problem, threads=1), simulation)
    )
    assert end + simulation.ledger.momentum[along] == pytest.approx(begin, rel=ROUND_OFF)


def test_damping__of_second_order_takes_less_than_the_first() -> None:
    first, second = (
        after("axisymmetric", damping=Damping(1e6, order)).audit().removed_energy
        for order in (1, 2)
    )
    assert second < first


def flown(damping: Damping, field: str, fixed_dt: float) -> Simulation:
    """A free block with a velocity field, after 0.2 us in which damping is all that happens to it."""
    geometry = box(8, 8, 8)
    body = block(geometry, (2.0, 2.0, 2.0), (6.0, 6.0, 6.0), velocity=(100.0, 0.0, 0.0))
    problem = Problem(geometry, (body,), OPEN, end_time=1.0, damping=damping, fixed_dt=fixed_dt)
    simulation = start(problem, threads=1)
    if field == "checkerboard":
        place = np.floor(simulation.particles.position / (0.5 * SPACING)).astype(int)
        simulation.particles.velocity[:, 2] = np.where(place.sum(axis=1) % 2, 1.0, -1.0)
    while simulation.time < 0.2e-6:
        simulation.advance()
    return simulation


@pytest.mark.parametrize("order", [1, 2])
def test_damping__leaves_rigid_motion_alone(order: int) -> None:
    simulation = flown(Damping(1e8, order), "rigid", 1e-8)
    assert np.allclose(simulation.particles.velocity, (100.0, 0.0, 0.0), rtol=0.0, atol=1e-9)


@pytest.mark.parametrize("order", [1, 2])
def test_damping__is_defined_per_time(order: int) -> None:
    """Velocities that the nodes do not see decay as exp(-rate t), whatever the step."""
    rate = 5e6
    for fixed_dt in (1e-8, 2.5e-9):
        simulation = flown(Damping(rate, order), "checkerboard", fixed_dt)
        inner = np.abs(simulation.particles.position / SPACING - 4.02).max(axis=1) < 0.9
        left = np.abs(simulation.particles.velocity[inner, 2]).mean()
        assert left == pytest.approx(np.exp(-rate * simulation.time), rel=0.02)


@pytest.mark.parametrize("name", SHAPES)
@pytest.mark.parametrize("scheme", [Scheme.MUSL, Scheme.USF])
def test_scheme__gives_the_same_bits_with_any_number_of_threads(name: str, scheme: Scheme) -> None:
    changes = {"shape": SHAPES[name], "scheme": scheme, "damping": Damping(1e6, 2)}
    one = after("axisymmetric", threads=1, shares=3, **changes).particles
    two = after("axisymmetric", threads=2, shares=3, **changes).particles
    for field in Particles._fields:
        assert np.array_equal(getattr(one, field), getattr(two, field)), field


@pytest.mark.parametrize("kind", ["axisymmetric", "cartesian"])
@pytest.mark.parametrize("name", SHAPES)
@pytest.mark.parametrize("scheme", list(Scheme))
def test_scheme__gives_the_same_numbers_with_any_number_of_shares(
    kind: str, name: str, scheme: Scheme
) -> None:
    """But for round-off: sums are taken in another order. A few particles a share, the last ones even none."""
    changes = {
        "shape": SHAPES[name],
        "scheme": scheme,
        "damping": Damping(1e6, 2),
        "fixed_dt": 1e-8,
    }
    one, many = (after(kind, 5, shares=shares, **changes).particles for shares in (1, 13))
    for field in Particles._fields:
        expected, got = getattr(one, field), getattr(many, field)
        scale = np.abs(expected).max()
        assert np.allclose(got, expected, rtol=0.0, atol=1e-11 * scale), field
