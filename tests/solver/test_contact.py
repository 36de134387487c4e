"""Bodies with velocity fields of their own: what draws apart is left alone, and what contact removes is accounted for.

That bodies approach, slide and part, with and without friction, is the verification case ``contact``.
"""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from solver.grid.shapes.gimp import Gimp
from solver.grid.shapes.quadratic_bspline import QuadraticBSpline
from solver.problem import Contact, Criterion, Problem
from solver.simulation import start
from tests.claims.marked import claimed
from tests.solver.bodies import OPEN, ROUND_OFF, after, assert_balanced, block, box, each_kind, each_shape, two_blocks

SPEED = 200.0  # m/s
STEPS = 60
# At the edges of a flat face the normal is tilted: a few nodes there touch early, with 1e-4 of the momentum of a block
# of three cells.
CORNER, TOUCH = 0.1, 1e-3  # cells; of the momentum


@each_shape
def test_contact__leaves_bodies_alone_that_draw_apart(shape: Any) -> None:
    """One velocity field would hold them together; two let them go, with nothing removed and no stress."""
    geometry = box(8, 8, 14)
    bodies = tuple(
        block(geometry, (2.0, 2.0, low), (5.0, 5.0, low + 3.0), velocity=(0.0, 0.0, speed))
        for low, speed in ((3.0, -SPEED), (6.0, SPEED))
    )
    problem = Problem(geometry, bodies, OPEN, end_time=1.0, contact=Contact(), shape=shape)
    simulation = after(problem, 40)
    expected = np.where(simulation.body == 0, -SPEED, SPEED)
    assert simulation.books.removed == 0.0
    assert np.allclose(simulation.particles.velocity[:, 2], expected, rtol=ROUND_OFF)
    assert np.abs(simulation.particles.pressure).max() <= 1.0


@each_shape
@each_kind
@pytest.mark.parametrize("friction", [0.0, 0.3])
def test_contact__accounts_for_what_it_removes(kind: str, shape: Any, friction: float) -> None:
    audit = after(two_blocks(kind, shape=shape, contact=Contact(friction)), STEPS).audit()
    assert audit.removed_energy == audit.contact_energy > 0.0
    assert_balanced(audit)


@pytest.mark.parametrize(
    "kind", claimed(("axisymmetric", "cartesian"), ["axisymmetric"], "methods", "contact-at-the-gap")
)
def test_contact_at_the_gap__acts_when_the_faces_meet_and_accounts_for_what_it_removes(kind: str) -> None:
    """Contact at the gap acts when the faces meet, and accounts for what it removes."""
    axis, shape = (1, Gimp()) if kind == "axisymmetric" else (2, QuadraticBSpline())
    problem = two_blocks(kind, shape=shape, contact=Contact(0.3, Criterion.GAP))
    flyer, plate = problem.bodies
    gap = 0.4 * problem.geometry.spacing
    apart = replace(flyer, position=flyer.position - gap * np.eye(3)[axis])
    simulation = start(replace(problem, bodies=(apart, plate)), threads=1)
    p, given = simulation.particles, 0.0
    while given < TOUCH * flyer.mass.sum() * flyer.velocity[axis]:
        early = simulation.time
        simulation.advance()
        given = (p.mass * p.velocity[:, axis])[simulation.body == 1].sum()
    flown = np.array([early, simulation.time]) * flyer.velocity[axis]
    assert flown[0] <= gap <= flown[1] + CORNER * problem.geometry.spacing
    for _ in range(STEPS):
        simulation.advance()
    audit = simulation.audit()
    assert audit.removed_energy == audit.contact_energy > 0.0
    assert_balanced(audit)


@pytest.mark.parametrize("criterion", [Criterion.STEP, Criterion.GAP])
def test_contact__acts_however_slowly_bodies_approach(criterion: Criterion) -> None:
    """A block that touches a plate at half a metre per second gives it momentum from the first steps on."""
    problem = two_blocks("axisymmetric", contact=Contact(0.0, criterion))
    flyer, plate = problem.bodies
    slow = replace(flyer, velocity=0.5 * flyer.velocity / np.linalg.norm(flyer.velocity))
    simulation = after(replace(problem, bodies=(slow, plate)), 10)
    p = simulation.particles
    given = (p.mass * p.velocity[:, 1])[simulation.body == 1].sum()
    assert given > TOUCH * slow.mass.sum() * 0.5
