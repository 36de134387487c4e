"""Schemes, damping and threads: what each keeps, what each loses, and that the loss is accounted for or seen."""

from typing import Any

import numpy as np
import pytest

from solver.audit import totals
from solver.problem import Damping, Problem, Scheme
from solver.simulation import Simulation, start
from solver.state import Particles
from solver.steps.threads import ThreadPool
from tests.solver.bodies import (
    OPEN,
    ROUND_OFF,
    SHAPES,
    SPACING,
    after,
    assert_balanced,
    assert_same_bits,
    block,
    box,
    each_kind,
    each_shape,
    two_blocks,
)

STEPS = 60


@pytest.mark.parametrize("name", ["linear", "quadratic-bspline"])
@pytest.mark.parametrize("scheme", [Scheme.USF, Scheme.USL])
def test_scheme__keeps_momentum_and_shows_its_energy(name: str, scheme: Scheme) -> None:
    """Neither sees the velocities that the particles end with: the audit is not blind to it."""
    audit = after(two_blocks("axisymmetric", shape=SHAPES[name], scheme=scheme), STEPS).audit()
    assert audit.momentum_error <= ROUND_OFF
    assert ROUND_OFF < abs(audit.energy_drift) < 0.05


@pytest.mark.parametrize("scheme", [Scheme.USF, Scheme.USL])
def test_scheme__error_of_the_energy_falls_with_the_step(scheme: Scheme) -> None:
    """Both are of first order in dt: a quarter of the step must at least halve it."""
    drifts = []
    for courant in (0.2, 0.05):
        simulation = start(two_blocks("axisymmetric", scheme=scheme, courant=courant), threads=1)
        while simulation.time < 0.4e-6:
            simulation.advance()
        drifts.append(abs(simulation.audit().energy_drift))
    assert drifts[1] < 0.5 * drifts[0]


@pytest.mark.parametrize("order", [1, 2])
@each_shape
@each_kind
def test_damping__accounts_for_what_it_removes(kind: str, shape: Any, order: int) -> None:
    simulation = after(two_blocks(kind, shape=shape, damping=Damping(1e6, order)), STEPS)
    audit = simulation.audit()
    assert audit.removed_energy > 0.0
    assert_balanced(audit)
    # Nothing is outside of free bodies that could have taken momentum along their flight.
    axis = 2 if kind == "cartesian" else 1
    end = totals(simulation.particles).momentum[axis] + simulation.books.ledger.momentum[axis]
    assert end == pytest.approx(simulation.books.start.momentum[axis], rel=ROUND_OFF)


def flown(damping: Damping, fixed_dt: float, checkerboard: float) -> Simulation:
    """A free block that flies, with velocities across that the nodes do not see, after 0.2 us of damping alone."""
    geometry = box(8, 8, 8)
    body = block(geometry, (2.0, 2.0, 2.0), (6.0, 6.0, 6.0), velocity=(100.0, 0.0, 0.0))
    problem = Problem(geometry, (body,), OPEN, end_time=1.0, damping=damping, fixed_dt=fixed_dt)
    simulation = start(problem, threads=1)
    place = np.floor(simulation.particles.position / (0.5 * SPACING)).astype(int)
    simulation.particles.velocity[:, 2] = checkerboard * (-1.0) ** place.sum(axis=1)
    while simulation.time < 0.2e-6:
        simulation.advance()
    return simulation


@pytest.mark.parametrize("order", [1, 2])
def test_damping__leaves_rigid_motion_alone(order: int) -> None:
    velocity = flown(Damping(1e8, order), 1e-8, 0.0).particles.velocity
    assert np.allclose(velocity, (100.0, 0.0, 0.0), rtol=0.0, atol=1e-9)


@pytest.mark.parametrize("order", [1, 2])
@pytest.mark.parametrize("fixed_dt", [1e-8, 2.5e-9])
def test_damping__is_defined_per_time(order: int, fixed_dt: float) -> None:
    """Velocities that the nodes do not see decay as exp(-rate t), whatever the step."""
    rate = 5e6
    simulation = flown(Damping(rate, order), fixed_dt, 1.0)
    inner = np.abs(simulation.particles.position / SPACING - 4.02).max(axis=1) < 0.9
    left = np.abs(simulation.particles.velocity[inner, 2]).mean()
    assert left == pytest.approx(np.exp(-rate * simulation.time), rel=0.02)


@pytest.mark.claim("speed", "same-bits")
@each_shape
@pytest.mark.parametrize("scheme", [Scheme.MUSL, Scheme.USF])
def test_scheme__gives_the_same_bits_with_any_number_of_threads(shape: Any, scheme: Scheme) -> None:
    """Two threads change no bit in any shape and scheme."""
    problem = two_blocks("axisymmetric", shape=shape, scheme=scheme, damping=Damping(1e6, 2))
    serial, parallel = (after(problem, STEPS, threads=threads, shares=3).particles for threads in (1, 2))
    assert_same_bits(serial, parallel)


@pytest.mark.claim("speed", "same-bits")
@each_kind
def test_step__gives_the_same_bits_with_any_number_of_threads(kind: str) -> None:
    """Two and three threads change no bit."""
    serial, *others = (after(two_blocks(kind), STEPS, threads=threads, shares=4).particles for threads in (1, 2, 3))
    for particles in others:
        assert_same_bits(serial, particles)


@pytest.mark.parametrize("threads", [1, 3])
def test_pool__runs_every_share_and_passes_on_what_one_raises(threads: int) -> None:
    done: list[int] = []
    ThreadPool(threads).run(done.append, [3, 1, 2])
    assert sorted(done) == [1, 2, 3]
    with pytest.raises(ZeroDivisionError):
        ThreadPool(threads).run(lambda share: 1 // share, [1, 0])


@each_kind
@each_shape
@pytest.mark.parametrize("scheme", list(Scheme))
def test_scheme__gives_the_same_numbers_with_any_number_of_shares(kind: str, shape: Any, scheme: Scheme) -> None:
    """But for round-off: sums are taken in another order. A few particles a share, the last ones even none."""
    problem = two_blocks(kind, shape=shape, scheme=scheme, damping=Damping(1e6, 2), fixed_dt=1e-8)
    serial, several = (after(problem, 5, shares=shares).particles for shares in (1, 13))
    for field in Particles._fields:
        expected, got = getattr(serial, field), getattr(several, field)
        scale = np.abs(expected).max()
        assert np.allclose(got, expected, rtol=0.0, atol=1e-11 * scale), field
