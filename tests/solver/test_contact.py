"""Bodies with velocity fields of their own: approach, slide, separate, and the energy that meeting takes."""

import math
from typing import Any

import numpy as np
import pytest

from solver.problem import Contact, Problem, Scheme
from solver.registry import entries
from solver.shapes.linear import Linear
from solver.shapes.quadratic_bspline import QuadraticBSpline
from solver.simulation import Simulation, start
from tests.solver.bodies import OPEN, SPACING, block, box, two_blocks

SHAPES = [entry.record() for entry in entries("solver.shapes", "SHAPE").values()]
each_shape = pytest.mark.parametrize("shape", SHAPES, ids=lambda shape: type(shape).__name__)
ROUND_OFF = 1e-12
SPEED = 200.0


def pair(
    first: tuple[float, float, float],
    second: tuple[float, float, float],
    *,
    gap: float = 0.0,
    **changes: Any,
) -> Simulation:
    """Two equal cubes above each other along z, with their velocities (m/s) and a gap in cells."""
    geometry = box(8, 8, 14)
    bodies = (
        block(geometry, (2.0, 2.0, 3.0), (5.0, 5.0, 6.0), velocity=first, name="lower"),
        block(
            geometry,
            (2.0, 2.0, 6.0 + gap),
            (5.0, 5.0, 9.0 + gap),
            velocity=second,
            name="upper",
        ),
    )
    problem = Problem(geometry, bodies, OPEN, end_time=1.0, **{"contact": Contact(), **changes})
    return start(problem, threads=1)


def velocity(simulation: Simulation, body: int) -> np.ndarray:
    """Velocity of a body's centre of mass, (3,) m/s."""
    of = simulation.body == body
    mass = simulation.particles.mass[of]
    return np.asarray(mass @ simulation.particles.velocity[of] / mass.sum())


@each_shape
def test_contact__leaves_bodies_alone_that_draw_apart(shape: Any) -> None:
    """One velocity field would hold them together; two let them go, with nothing taken and no stress."""
    simulation = pair((0.0, 0.0, -SPEED), (0.0, 0.0, SPEED), shape=shape)
    for _ in range(40):
        simulation.advance()
    assert simulation.removed == 0.0
    assert np.allclose(velocity(simulation, 0), (0.0, 0.0, -SPEED), rtol=ROUND_OFF, atol=1e-9)
    assert np.abs(simulation.particles.pressure).max() <= 1.0


@each_shape
def test_contact__never_adds_kinetic_energy_at_first_touch(shape: Any) -> None:
    """Until the first waves have crossed a body and come back: 6 cells at 4.7 km/s."""
    simulation = pair((0.0, 0.0, SPEED), (0.0, 0.0, -SPEED), gap=2.5, shape=shape)
    kinetic = [simulation.audit().kinetic]
    touched = None
    while touched is None or simulation.time < touched + 6.0 * SPACING / 4700.0:
        simulation.advance()
        kinetic.append(simulation.audit().kinetic)
        if touched is None and simulation.removed > 0.0:
            touched = simulation.time
    rises = np.diff(kinetic) / kinetic[0]
    assert rises.max() <= ROUND_OFF
    assert kinetic[-1] < kinetic[0]


@each_shape
@pytest.mark.parametrize("kind", ["axisymmetric", "cartesian"])
@pytest.mark.parametrize("friction", [0.0, 0.3])
def test_contact__books_what_it_takes(kind: str, shape: Any, friction: float) -> None:
    simulation = start(two_blocks(kind, shape=shape, contact=Contact(friction)), threads=1)
    for _ in range(60):
        simulation.advance()
    audit = simulation.audit()
    assert audit.removed_energy == audit.contact_energy > 0.0
    assert abs(audit.energy_drift) <= ROUND_OFF
    assert audit.momentum_error <= ROUND_OFF


@pytest.mark.parametrize("shape", [Linear(), QuadraticBSpline()])  # those that stand these schemes
@pytest.mark.parametrize("scheme", [Scheme.USF, Scheme.USL])
def test_contact__books_what_it_takes_in_schemes_that_do_not_map_back(
    shape: Any, scheme: Scheme
) -> None:
    """The sum drifts with the scheme as it does in one velocity field, and not by what contact takes."""
    drift = {}
    for contact in (Contact(), None):
        problem = two_blocks("axisymmetric", shape=shape, contact=contact, scheme=scheme)
        simulation = start(problem, threads=1)
        for _ in range(60):
            simulation.advance()
        drift[contact] = simulation.audit().energy_drift
    assert abs(drift[Contact()] - drift[None]) < 0.03


@each_shape
def test_contact__lets_bodies_separate_after_an_impact(shape: Any) -> None:
    simulation = pair((0.0, 0.0, SPEED), (0.0, 0.0, -SPEED), shape=shape)
    while simulation.time < 4.0 * 6.0 * SPACING / 4700.0:
        simulation.advance()
    lower, upper = velocity(simulation, 0)[2], velocity(simulation, 1)[2]
    assert lower < 0.0 < upper
    assert math.isclose(lower, -upper, rel_tol=1e-6)


@each_shape
def test_contact__without_friction_lets_bodies_slide(shape: Any) -> None:
    """The normals at the edges tilt, so a little is lost; one velocity field holds the bodies fast."""
    lost = {}
    for contact in (Contact(), None):
        simulation = pair((SPEED, 0.0, 20.0), (-SPEED, 0.0, -20.0), shape=shape, contact=contact)
        for _ in range(40):
            simulation.advance()
        lost[contact] = SPEED - velocity(simulation, 0)[0]
    assert abs(lost[Contact()]) < 0.25 * lost[None]


@each_shape
def test_contact__friction_slows_sliding_bodies_and_keeps_their_momentum(shape: Any) -> None:
    speeds = {}
    for friction in (0.0, 0.5):
        simulation = pair(
            (SPEED, 0.0, 20.0), (-SPEED, 0.0, -20.0), shape=shape, contact=Contact(friction)
        )
        for _ in range(40):
            simulation.advance()
        speeds[friction] = velocity(simulation, 0)[0]
        assert simulation.audit().momentum_error <= ROUND_OFF
    assert speeds[0.5] < speeds[0.0]
