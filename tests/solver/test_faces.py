"""Faces: what they hold, what they let go, and the impulse that they account for."""

from typing import Any

import numpy as np
import pytest

from solver.grid.step import Field, Kernels
from solver.problem import Face, Problem, clamp
from solver.simulation import start
from solver.state import empty_table, views
from solver.steps.crossing import cross_faces
from solver.steps.space import new_pack
from solver.steps.threads import ThreadPool
from tests.solver.bodies import FREE, SPACING, SYMMETRIC, assert_balanced, block, box, each_shape

BOX = box(4, 4, 4)
DT = 1e-8
CLOSED_FACES = [Face.FIXED, Face.SYMMETRIC, Face.WALL]
each_axis = pytest.mark.parametrize("axis", [0, 1, 2])
each_side = pytest.mark.parametrize("side", [0, 1])


# On nodes


@pytest.mark.parametrize(
    ("side", "momentum", "force", "left", "pushes"),
    [
        (0, -1.0, 0.0, 0.0, False),  # approaches: stopped
        (1, 1.0, 0.0, 0.0, False),
        (0, 1.0, 0.0, 1.0, False),  # leaves: let go
        (1, -1.0, 0.0, -1.0, False),
        (0, -1.0, 2.0, -1.0, False),  # its force turns it round within the step: let go
        (0, -1.0, 0.5, -0.5, False),  # its force slows it: stopped, and the force is not the wall's
        (0, -1.0, -0.5, 0.0, True),
    ],
)
def test_wall__holds_what_still_approaches_at_the_end_of_the_step_and_never_pulls(
    side: int, momentum: float, force: float, left: float, pushes: bool
) -> None:
    """All nodes but the ghosts of the wall are loaded alike; the force is counted in momenta per step."""
    body, impulse = block(BOX, (1.0, 1.0, 1.0), (3.0, 3.0, 3.0)), np.zeros(3)
    faces = (FREE, FREE, (Face.FREE, Face.WALL) if side else (Face.WALL, Face.FREE))
    field = Field(Problem(BOX, (body,), faces, end_time=1.0), slice(0, 1), Kernels(), ThreadPool(1), [new_pack()])
    field.touched[:] = 1
    field.nodes.mass[:] = 1.0
    field.nodes.momentum[:], field.nodes.force[:] = (0.0, 0.0, momentum), (0.0, 0.0, force / DT)
    field.nodes.state[field.closed.ghost] = 0.0
    field.close(DT, impulse)
    assert (field.nodes.momentum[field.closed.face, 2] == left).all()
    assert impulse[2] >= 0.0
    assert (impulse[2] > 0.0) == pushes


# On particles

# A clamp over layers 1 and 2 along y.
GRIP = clamp(lower=(-np.inf, SPACING, -np.inf), upper=(np.inf, 2.0 * SPACING, np.inf))
STRESS = (3e8, -1e8, -2e8, 0.5e8, -0.7e8, 1.1e8)  # 11 22 33 12 23 31
VELOCITY = (5.0, -7.0, 11.0)


def crossed(
    faces: Any, place: tuple[float, float, float], *, velocity: Any = VELOCITY, geometry: Any = BOX, within: Any = None
) -> tuple[Any, np.ndarray, int]:
    """A stressed particle of 2 kg at a place (in cells) after faces acted, their impulse, how many they put back."""
    particles = views(empty_table(2))  # columns of two have the layout, and so the kernel, of any number
    particles.position[0] = np.array(place) * SPACING
    particles.velocity[0], particles.deviator[0], particles.mass[0] = velocity, STRESS, 2.0
    impulse = np.zeros(3)
    numbers = np.array(faces, np.int64)
    _, reflected = cross_faces(geometry, numbers, within or clamp(), particles, impulse)
    return particles, impulse, reflected


def past(kind: Face, axis: int, side: int, geometry: Any = BOX) -> tuple[Any, np.ndarray, int]:
    """A particle a tenth of a cell past a closed face."""
    faces = np.zeros((3, 2))
    faces[axis, side] = kind
    place = np.where(geometry.cells > 0, 2.0, 0.0)
    place[axis] = (-0.1, 4.1)[side]
    return crossed(faces, tuple(place), geometry=geometry)


def tensor(a: Any) -> np.ndarray:
    """Components 11 22 33 12 23 31 as a matrix."""
    return np.array([[a[0], a[3], a[5]], [a[3], a[1], a[4]], [a[5], a[4], a[2]]])


@pytest.mark.parametrize(
    ("lower", "place", "within", "put_back"),
    [
        *((Face.FREE, (place, 2.0, 2.0), None, 0) for place in (-0.1, 4.0, 4.3)),
        (Face.FIXED, (-0.1, 4.2, 2.0), None, 1),  # closed, and then out through a free face beside it
        *((Face.FIXED, (-0.1, along, 2.0), GRIP, stays) for along, stays in ((0.5, 0), (1.5, 1), (3.0, 0))),
    ],
)
def test_free_face__lets_particles_go_and_so_do_fixed_ones_beyond_the_clamp(
    lower: Face, place: tuple[float, float, float], within: Any, put_back: int
) -> None:
    particles, impulse, reflected = crossed(((lower, Face.FREE), FREE, FREE), place, within=within)
    assert reflected == put_back
    assert particles.alive[0] == (put_back and place[1] < 4.0)
    assert not impulse.any()  # it flies inwards


@pytest.mark.parametrize("kind", CLOSED_FACES)
@pytest.mark.parametrize(("place", "velocity"), [(-0.1, -5.0), (4.1, 5.0)])
def test_closed_face__puts_back_turns_round_and_accounts_for_it(kind: Face, place: float, velocity: float) -> None:
    faces = ((kind, kind), FREE, FREE)
    particles, impulse, reflected = crossed(faces, (place, 2.0, 2.0), velocity=(velocity, 0.0, 0.0))
    mirrored = -place if place < 0.0 else 8.0 - place
    assert particles.alive[0] == reflected == 1
    assert particles.position[0, 0] == pytest.approx(mirrored * SPACING)
    assert particles.velocity[0, 0] == -velocity
    assert impulse[0] == pytest.approx(2.0 * -2.0 * velocity)


@each_axis
@each_side
def test_symmetric_face__puts_the_mirror_image_in_the_place_of_a_particle(axis: int, side: int) -> None:
    """Also where its velocity points inwards, as it does at one of the two sides."""
    particles, *_ = past(Face.SYMMETRIC, axis, side)
    mirror = np.diag(np.where(np.arange(3) == axis, -1.0, 1.0))
    assert (particles.velocity[0] == mirror @ VELOCITY).all()
    assert (tensor(particles.deviator[0]) == mirror @ tensor(STRESS) @ mirror).all()


def test_axis__turns_the_shear_of_a_particle_that_crosses_it() -> None:
    """Half a turn about z: r and theta change their signs, and so does the stress across r and z."""
    particles, *_ = past(Face.SYMMETRIC, 0, 0, box(4, 4))
    assert particles.position[0, 0] > 0.0
    assert particles.velocity[0, 0] == -VELOCITY[0]
    assert particles.deviator[0, :4].tolist() == [*STRESS[:3], -STRESS[3]]


# In a simulation


@pytest.mark.parametrize("face", CLOSED_FACES)
@each_shape
def test_face__closes_the_balances_of_a_bar_that_hits_it(face: Face, shape: Any) -> None:
    """Until the wave has come back from its free end: a wall lets go then, the other faces pull."""
    geometry = box(2, 2, 12)
    bar = block(geometry, (0.0, 0.0, 0.25), (2.0, 2.0, 6.25), velocity=(0.0, 0.0, -100.0))
    faces = (SYMMETRIC, SYMMETRIC, (face, Face.FREE))
    simulation = start(Problem(geometry, (bar,), faces, end_time=1.0, shape=shape), threads=1)
    impulses = []
    while simulation.time < 6e-6:
        before = simulation.books.impulse[2]
        simulation.advance()
        impulses.append(simulation.books.impulse[2] - before)
    assert max(impulses) > 0.0
    assert (min(impulses) >= 0.0) == (face == Face.WALL)
    audit = simulation.audit()
    assert_balanced(audit)


@pytest.mark.parametrize(("upper", "expected"), [(Face.FIXED, 0.0), (Face.FREE, 1.0)])
def test_face__is_where_the_momentum_of_a_pressed_block_goes(upper: Face, expected: float) -> None:
    """A block under pressure p is pushed by p times the area from each fixed face."""
    geometry = box(2, 2, 4)
    full = block(geometry, (0.0, 0.0, 0.0), (2.0, 2.0, 4.0))
    faces = (SYMMETRIC, SYMMETRIC, (Face.FIXED, upper))
    simulation = start(Problem(geometry, (full,), faces, end_time=1.0), threads=1)
    simulation.particles.pressure[:] = pressure = 1e9
    dt = simulation.dt
    simulation.advance()
    push = simulation.books.impulse[2] / (pressure * (2.0 * SPACING) ** 2 * dt)
    assert push == pytest.approx(expected, abs=1e-9)
