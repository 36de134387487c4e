"""Fields with an exact answer: rigid translation, rigid rotation, free flight."""

import math

import numpy as np
import pytest

from solver.matter.stress import PointState, advance
from solver.problem import ArtificialViscosity, Problem
from solver.simulation import Simulation, start
from tests.solver.bodies import ABOUT_AXIS, DENSITY, OPEN, ROOM, SPACING, block, box, elastic_copper, real_copper

ROUND_OFF = 1e-12
SPEED = 6000.0
# Round-off of weights (1e-16) times a shock of the speed of flight, rho c v = 210 GPa: what rigid motion may leave.
STRESS_NOISE = 1e-9 * DENSITY * SPEED**2


# Rigid translation


def flown(kind: str, velocity: tuple[float, float, float]) -> Simulation:
    """A block of real copper after it has crossed six cells of the grid, so that it has crossed nodes."""
    flat = kind == "axisymmetric"
    geometry = box(5, 12) if flat else box(12, 12, 12)
    low, high = ((0.0, 1.2), (3.0, 4.2)) if flat else ((1.2, 1.3, 1.4), (3.2, 3.3, 3.4))
    body = block(geometry, low, high, velocity=velocity, matter=real_copper())
    faces = ABOUT_AXIS if flat else OPEN
    simulation = start(Problem(geometry, (body,), faces, end_time=1.0), threads=1)
    while simulation.time * max(velocity) < 6.0 * SPACING:
        simulation.advance()
    return simulation


FLIGHTS = [
    ("axisymmetric", (0.0, SPEED, 0.0)),
    ("cartesian", (0.0, 0.0, SPEED)),
    ("cartesian", (SPEED, 0.5 * SPEED, 0.25 * SPEED)),
]


@pytest.mark.claim("cases", "translation", minutes=0.3)
@pytest.mark.parametrize(("kind", "velocity"), FLIGHTS)
def test_translation__keeps_stress_energy_and_shape(kind: str, velocity: tuple[float, float, float]) -> None:
    """Matter that flies through the grid in three dimensions keeps its stress, energy and shape."""
    simulation = flown(kind, velocity)
    particles, audit = simulation.particles, simulation.audit()
    assert np.abs(particles.pressure).max() <= STRESS_NOISE
    assert np.abs(particles.deviator).max() <= STRESS_NOISE
    assert particles.plastic_strain.max() == 0.0
    assert abs(audit.energy_drift) <= ROUND_OFF
    assert abs(audit.internal) <= ROUND_OFF * audit.kinetic
    before = simulation.problem.bodies[0].position[particles.number]
    moved = (particles.position - before) / simulation.time
    assert np.allclose(moved, velocity, rtol=0.0, atol=1e-9 * SPEED)
    assert np.allclose(particles.velocity, velocity, rtol=0.0, atol=1e-9 * SPEED)


# Rigid rotation of a point under stress; the case ``rotation`` looks at the stress itself


def turned(steps: int, spin: tuple[float, float, float]) -> tuple[PointState, PointState]:
    """A stressed point before and after steps that only turn it, each by a spin (rad)."""
    stress = (3e8, -1e8, -2e8, 0.5e8, -0.7e8, 1.1e8)
    point = PointState(DENSITY, 0.0, 1e9, 0.0, stress, 0.0, ROOM)
    before = point
    x, y, z = spin
    dt = 1e-8
    gradient = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]]) / dt
    viscosity = ArtificialViscosity()
    for _ in range(steps):
        point, *_ = advance(elastic_copper(), viscosity, SPACING, dt, gradient, point)
    return before, point


@pytest.mark.parametrize("steps", [100, 1000])
def test_rotation__spans_the_volume_of_its_straight_steps(steps: int) -> None:
    """Points move along tangents, so a turn by one radian grows a volume by (1 + 1 / steps^2)^steps."""
    before, after = turned(steps, (0.0, 0.0, 1.0 / steps))
    grown = (1.0 + 1.0 / steps**2) ** steps
    assert math.isclose(before.density / after.density, grown, rel_tol=ROUND_OFF)
    assert grown - 1.0 < 1.01 / steps
