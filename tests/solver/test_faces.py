"""What faces hold, what they let go, and that they book what they give."""

from typing import Any

import numpy as np
import pytest

from solver.faces import (
    CLOSED,
    OPEN,
    closed_nodes,
    cross_faces,
)
from solver.geometry import node_positions
from solver.problem import Face, Problem, clamp
from solver.registry import entries
from solver.shapes.linear import Linear
from solver.simulation import Simulation, start
from solver.state import Nodes, empty_table, views
from solver.step import Field
from tests.solver.bodies import (
    FREE,
    SOUND_SPEED,
    SPACING,
    SYMMETRIC,
    block,
    box,
    two_blocks,
)

BOX = box(4, 4, 4)
LINEAR = Linear()
SHAPES = [entry.record() for entry in entries("solver.shapes", "SHAPE").values()]
ROUND_OFF = 1e-12
DT = 1e-8
MOMENTUM, FORCE = (1.0, 2.0, 3.0), (10e8, 20e8, 30e8)

LENGTH, GAP = 20.0, 0.25  # of the bar and in front of it, in cells
SPEED = 100.0


# On nodes


def field_with(kind: Face, axis: int, side: int) -> Field:
    """The nodes of the box, one of whose faces is closed."""
    faces = [[Face.FREE, Face.FREE] for _ in range(3)]
    faces[axis][side] = kind
    body = block(BOX, (1.0, 1.0, 1.0), (3.0, 3.0, 3.0))
    problem = Problem(BOX, (body,), tuple(map(tuple, faces)), end_time=1.0)  # type: ignore[arg-type]
    field = Field(problem, slice(0, 1), 1)
    return field


def held(
    kind: Face, axis: int, side: int, *, momentum: Any = MOMENTUM, force: Any = FORCE
) -> tuple[Nodes, np.ndarray, np.ndarray]:
    """All nodes but the ghosts of one face loaded alike, that face held: nodes, indices of the face, impulse."""
    field, impulse = field_with(kind, axis, side), np.zeros(3)
    nodes = field.nodes
    nodes.mass[:] = 1.0
    nodes.momentum[:] = momentum
    nodes.force[:] = force
    nodes.state[field.closed.ghost] = 0.0
    field.close(DT, impulse)
    return nodes, field.closed.face, impulse


@pytest.mark.parametrize("axis", [0, 1, 2])
@pytest.mark.parametrize("side", [0, 1])
@pytest.mark.parametrize("kind", [Face.FIXED, Face.SYMMETRIC, Face.WALL])
def test_face__touches_its_own_nodes_only(kind: Face, axis: int, side: int) -> None:
    nodes, index, _ = held(kind, axis, side)
    ghosts = field_with(kind, axis, side).closed.ghost
    others = np.setdiff1d(np.arange(nodes.mass.size), [index, ghosts])
    assert index.size == 7 * 7  # ghosts of the other faces included
    assert not nodes.state[ghosts].any()
    assert (nodes.momentum[others] == MOMENTUM).all()
    assert (nodes.force[others] == FORCE).all()


@pytest.mark.parametrize("side", [0, 1])
def test_fixed_face__holds_all_components(side: int) -> None:
    nodes, index, _ = held(Face.FIXED, 1, side)
    assert not nodes.momentum[index].any()
    assert not nodes.force[index].any()


@pytest.mark.parametrize("axis", [0, 1, 2])
def test_symmetric_face__holds_the_normal_component_and_lets_slide(axis: int) -> None:
    nodes, index, _ = held(Face.SYMMETRIC, axis, 0)
    along = [other for other in range(3) if other != axis]
    assert not nodes.momentum[index, axis].any()
    assert not nodes.force[index, axis].any()
    assert (nodes.momentum[index][:, along] == np.array(MOMENTUM)[along]).all()
    assert (nodes.force[index][:, along] == np.array(FORCE)[along]).all()


@pytest.mark.parametrize(("side", "approach"), [(0, -1.0), (1, 1.0)])
def test_wall__holds_what_approaches_and_lets_go_what_leaves(side: int, approach: float) -> None:
    for direction, stays in ((approach, 0.0), (-approach, -approach)):
        nodes, index, _ = held(
            Face.WALL, 2, side, momentum=(0.0, 0.0, direction), force=(0.0, 0.0, 0.0)
        )
        assert (nodes.momentum[index, 2] == stays).all()


def test_wall__judges_by_where_the_step_would_end() -> None:
    """A node that still approaches is let go if the force turns it round within the step."""
    nodes, index, impulse = held(
        Face.WALL, 2, 0, momentum=(0.0, 0.0, -1.0), force=(0.0, 0.0, 2.0 / DT)
    )
    assert (nodes.momentum[index, 2] == -1.0).all()
    assert not impulse.any()


@pytest.mark.parametrize("kind", [Face.FIXED, Face.SYMMETRIC])
def test_face__books_the_momentum_that_its_force_would_have_given(kind: Face) -> None:
    _, index, impulse = held(kind, 0, 1)
    taken = index.size * DT * np.array(FORCE)
    if kind == Face.SYMMETRIC:
        taken[1:] = 0.0
    assert np.allclose(impulse, -taken, rtol=ROUND_OFF, atol=0.0)


def test_fold__mirrors_what_ghosts_hold_and_keeps_mass() -> None:
    field = field_with(Face.SYMMETRIC, 0, 0)
    nodes, closed = field.nodes, field.closed
    nodes.mass[closed.ghost], nodes.mass[closed.inner] = 0.25, 1.0
    nodes.momentum[closed.ghost], nodes.force[closed.ghost] = MOMENTUM, FORCE
    field.close(DT, np.zeros(3))
    mirrored = np.array([-1.0, 1.0, 1.0])
    assert (nodes.mass[closed.inner] == 1.25).all()
    assert not nodes.mass[closed.ghost].any()
    assert (nodes.momentum[closed.inner] == mirrored * MOMENTUM).all()
    assert (nodes.force[closed.inner] == mirrored * FORCE).all()
    assert not nodes.momentum[closed.ghost].any()


def test_closed_faces__fold_a_corner_once_along_each_axis() -> None:
    """What a particle leaves in the ghosts of an edge comes back into the body, turned round twice."""
    body = block(BOX, (1.0, 1.0, 1.0), (3.0, 3.0, 3.0))
    problem = Problem(BOX, (body,), (SYMMETRIC, SYMMETRIC, SYMMETRIC), end_time=1.0)
    field = Field(problem, slice(0, 1), 1)
    nodes = field.nodes
    nodes.mass[0], nodes.momentum[0] = 1.0, MOMENTUM  # the ghost of the lower corner
    field.close(DT, np.zeros(3))
    inside = (2 * 7 + 2) * 7 + 2
    assert nodes.mass[inside] == nodes.mass.sum() == 1.0
    assert (nodes.momentum[inside] == -np.array(MOMENTUM)).all()
    nodes.velocity[inside] = MOMENTUM
    field.mirror()
    assert (nodes.velocity[0] == -np.array(MOMENTUM)).all()


def test_mirror__gives_ghosts_the_velocity_of_the_mirrored_body() -> None:
    field = field_with(Face.FIXED, 1, 1)
    nodes, closed = field.nodes, field.closed
    for vectors in (nodes.velocity, nodes.before, nodes.acceleration):
        vectors[closed.inner] = (1.0, 2.0, 3.0)
    field.mirror()
    for vectors in (nodes.velocity, nodes.before, nodes.acceleration):
        assert (vectors[closed.ghost] == (-1.0, -2.0, -3.0)).all()


# On particles


def crossed(*kinds: Face, place: float, velocity: float) -> tuple[Any, np.ndarray, int]:
    """A particle of 2 kg past a face of the first axis, in cells from the lower one."""
    particles = views(empty_table(1))
    particles.position[0] = (place * SPACING, 2.0 * SPACING, 2.0 * SPACING)
    particles.velocity[0, 0] = velocity
    particles.mass[0] = 2.0
    faces = np.zeros((3, 2), np.int64)
    faces[0] = [int(kind) for kind in kinds]
    impulse = np.zeros(3)
    _, reflected = cross_faces(BOX, faces, clamp(), particles, impulse)
    return particles, impulse, reflected


@pytest.mark.parametrize("place", [-0.1, 4.0, 4.3])
def test_free_face__lets_particles_go(place: float) -> None:
    particles, impulse, reflected = crossed(*FREE, place=place, velocity=5.0)
    assert particles.alive[0] == 0
    assert reflected == 0
    assert not impulse.any()


@pytest.mark.parametrize("kind", [Face.FIXED, Face.SYMMETRIC, Face.WALL])
@pytest.mark.parametrize(("place", "velocity"), [(-0.1, -5.0), (4.1, 5.0)])
def test_closed_face__puts_back_turns_round_and_books(
    kind: Face, place: float, velocity: float
) -> None:
    particles, impulse, reflected = crossed(kind, kind, place=place, velocity=velocity)
    mirrored = -place if place < 0.0 else 8.0 - place
    assert particles.alive[0] == 1
    assert reflected == 1
    assert particles.position[0, 0] == pytest.approx(mirrored * SPACING)
    assert particles.velocity[0, 0] == -velocity
    assert impulse[0] == pytest.approx(2.0 * -2.0 * velocity)


def test_closed_face__does_not_turn_round_what_already_comes_back() -> None:
    particles, impulse, _ = crossed(Face.WALL, Face.FREE, place=-0.1, velocity=3.0)
    assert particles.velocity[0, 0] == 3.0
    assert not impulse.any()


STRESS = (3e8, -1e8, -2e8, 0.5e8, -0.7e8, 1.1e8)  # 11 22 33 12 23 31
VELOCITY = (5.0, -7.0, 11.0)


def tensor(a: Any) -> np.ndarray:
    """Components 11 22 33 12 23 31 as a matrix."""
    return np.array([[a[0], a[3], a[5]], [a[3], a[1], a[4]], [a[5], a[4], a[2]]])


def stressed_past(kind: Face, axis: int, side: int, geometry: Any = BOX) -> Any:
    """A stressed particle a tenth of a cell past a closed face, after it was put back."""
    particles = views(empty_table(1))
    particles.position[0] = np.where(geometry.cells > 0, 2.0 * SPACING, 0.0)
    particles.position[0, axis] = (-0.1, 4.1)[side] * SPACING
    particles.velocity[0], particles.deviator[0] = VELOCITY, STRESS
    faces = np.zeros((3, 2), np.int64)
    faces[axis, side] = int(kind)
    cross_faces(geometry, faces, clamp(), particles, np.zeros(3))
    return particles


@pytest.mark.parametrize("axis", [0, 1, 2])
@pytest.mark.parametrize("side", [0, 1])
def test_symmetric_face__puts_the_mirror_image_in_the_place_of_a_particle(
    axis: int, side: int
) -> None:
    """Also where its velocity points inwards, as it does at one of the two sides."""
    particles = stressed_past(Face.SYMMETRIC, axis, side)
    mirror = np.diag(np.where(np.arange(3) == axis, -1.0, 1.0))
    assert (particles.velocity[0] == mirror @ VELOCITY).all()
    assert (tensor(particles.deviator[0]) == mirror @ tensor(STRESS) @ mirror).all()


def test_axis__turns_the_shear_of_a_particle_that_crosses_it() -> None:
    """Half a turn about z: r and theta change their signs, and so does the stress across r and z."""
    particles = stressed_past(Face.SYMMETRIC, 0, 0, box(4, 4))
    assert particles.position[0, 0] > 0.0
    assert particles.velocity[0, 0] == -VELOCITY[0]
    assert particles.deviator[0, 3] == -STRESS[3]
    assert (particles.deviator[0, :3] == STRESS[:3]).all()


@pytest.mark.parametrize("axis", [0, 1, 2])
@pytest.mark.parametrize("side", [0, 1])
@pytest.mark.parametrize("kind", [Face.FIXED, Face.WALL])
def test_wall__leaves_the_stress_of_a_particle_that_it_turns_round(
    kind: Face, axis: int, side: int
) -> None:
    """What hits a wall is no image: the same matter comes back."""
    assert (stressed_past(kind, axis, side).deviator[0] == STRESS).all()


@pytest.mark.parametrize("place", [-1e9, -7.0, 4.0, 4.0 + 1e-15, 12.0, 1e9])
def test_closed_face__puts_back_inside_the_grid_from_anywhere(place: float) -> None:
    particles, _, _ = crossed(Face.FIXED, Face.FIXED, place=place, velocity=0.0)
    assert 0.0 <= particles.position[0, 0] < 4.0 * SPACING


def test_closed_faces__do_not_keep_what_leaves_through_a_free_one_beside_them() -> None:
    particles = views(empty_table(1))
    particles.position[0] = (-0.1 * SPACING, 4.2 * SPACING, 2.0 * SPACING)
    faces = np.zeros((3, 2), np.int64)
    faces[0, 0] = int(Face.FIXED)
    cross_faces(BOX, faces, clamp(), particles, np.zeros(3))
    assert particles.alive[0] == 0


# Within a clamp

GRIP = clamp(
    lower=(-np.inf, SPACING, -np.inf), upper=(np.inf, 2.0 * SPACING, np.inf)
)  # layers 1 and 2 along y


def test_clamp__holds_a_fixed_face_within_it_and_leaves_it_free_beyond() -> None:
    faces = ((Face.FIXED, Face.FREE), FREE, FREE)
    found = closed_nodes(BOX, faces, GRIP)
    place = node_positions(BOX)[found.face, 1] / SPACING
    held = (place > 0.9) & (place < 2.1)
    assert (found.closed[held] == CLOSED).all()
    assert (found.closed[~held] == OPEN).all()


@pytest.mark.parametrize("kind", [Face.SYMMETRIC, Face.WALL])
def test_clamp__is_of_fixed_faces_only(kind: Face) -> None:
    found = closed_nodes(BOX, ((kind, Face.FREE), FREE, FREE), GRIP)
    assert found.closed.size
    assert (found.closed == CLOSED).all()


@pytest.mark.parametrize(("along", "stays"), [(0.5, 0), (1.5, 1), (3.0, 0)])
def test_clamp__puts_back_within_it_and_lets_go_beyond(along: float, stays: int) -> None:
    particles = views(empty_table(1))
    particles.position[0] = (-0.1 * SPACING, along * SPACING, 2.0 * SPACING)
    faces = np.zeros((3, 2), np.int64)
    faces[0, 0] = int(Face.FIXED)
    _, reflected = cross_faces(BOX, faces, GRIP, particles, np.zeros(3))
    assert particles.alive[0] == reflected == stays


# In a simulation


def bar_towards(face: Face, shape: Any = LINEAR) -> Simulation:
    """An elastic bar in uniaxial strain, a quarter of a cell in front of the lower face, flying towards it."""
    geometry = box(2, 2, 30)
    bar = block(geometry, (0.0, 0.0, GAP), (2.0, 2.0, GAP + LENGTH), velocity=(0.0, 0.0, -SPEED))
    faces = (SYMMETRIC, SYMMETRIC, (face, Face.FREE))
    return start(Problem(geometry, (bar,), faces, end_time=1.0, shape=shape), threads=1)


def after_contact(simulation: Simulation) -> tuple[np.ndarray, float]:
    """Impulse of the lower face in each step (N s) until well after the wave came back, and the bar's momentum."""
    there_and_back = 2.0 * LENGTH * SPACING / SOUND_SPEED
    impulses = []
    while simulation.time < 1.6 * there_and_back:
        before = simulation.impulse[2]
        simulation.advance()
        impulses.append(simulation.impulse[2] - before)
    particles = simulation.particles
    return np.array(impulses), float(particles.mass @ particles.velocity[:, 2])


@pytest.mark.parametrize("shape", SHAPES, ids=lambda shape: type(shape).__name__)
def test_wall__lets_a_bar_rebound(shape: Any) -> None:
    simulation = bar_towards(Face.WALL, shape)
    momentum = simulation.particles.mass.sum() * SPEED
    _, after = after_contact(simulation)
    # Ringing of the bar and the viscosity of its shock keep a tenth.
    assert 0.9 * momentum < after <= momentum
    assert simulation.particles.position[:, 2].min() > SPACING  # out of the cell at the wall


@pytest.mark.parametrize("shape", SHAPES, ids=lambda shape: type(shape).__name__)
def test_wall__never_pulls(shape: Any) -> None:
    impulses, _ = after_contact(bar_towards(Face.WALL, shape))
    assert impulses.min() >= 0.0


def test_wall__cancels_no_force_that_points_away_from_it() -> None:
    """The node still approaches at the end of the step: it is stopped, but its force is not the wall's."""
    _, _, impulse = held(Face.WALL, 2, 0, momentum=(0.0, 0.0, -1.0), force=(0.0, 0.0, 0.5 / DT))
    assert impulse[2] >= 0.0


@pytest.mark.parametrize("shape", SHAPES, ids=lambda shape: type(shape).__name__)
def test_wall__is_let_go_once_the_wave_has_come_back(shape: Any) -> None:
    """In the last third of the time the ringing bar touches the wall with less than a thousandth of the impulse."""
    impulses, _ = after_contact(bar_towards(Face.WALL, shape))
    late = impulses[-impulses.size // 3 :]
    assert late.sum() < 1e-3 * impulses.sum()


@pytest.mark.parametrize("face", [Face.FIXED, Face.SYMMETRIC])
def test_closed_face__does_not_let_a_bar_go(face: Face) -> None:
    simulation = bar_towards(face)
    impulses, after = after_contact(simulation)
    momentum = simulation.particles.mass.sum() * SPEED
    assert impulses.min() < 0.0  # it pulls
    assert after < 0.5 * momentum
    assert (
        simulation.particles.position[:, 2].min() < 0.75 * SPACING
    )  # still in the cell at the face


@pytest.mark.parametrize("face", [Face.FIXED, Face.SYMMETRIC, Face.WALL])
@pytest.mark.parametrize("shape", SHAPES, ids=lambda shape: type(shape).__name__)
def test_face__impulse_closes_the_momentum_balance(face: Face, shape: Any) -> None:
    simulation = bar_towards(face, shape)
    after_contact(simulation)
    assert abs(simulation.impulse[2]) > 0.0
    assert simulation.audit().momentum_error <= ROUND_OFF


@pytest.mark.parametrize("face", [Face.FIXED, Face.SYMMETRIC, Face.WALL])
@pytest.mark.parametrize("shape", SHAPES, ids=lambda shape: type(shape).__name__)
def test_face__does_no_work_that_is_not_booked(face: Face, shape: Any) -> None:
    simulation = bar_towards(face, shape)
    after_contact(simulation)
    assert abs(simulation.audit().energy_drift) <= ROUND_OFF


def test_symmetric_face__lets_a_block_slide_along_it() -> None:
    geometry = box(10, 3, 3)
    sliding = block(geometry, (1.0, 0.0, 0.0), (3.0, 2.0, 2.0), velocity=(500.0, 0.0, 0.0))
    faces = (FREE, (Face.SYMMETRIC, Face.FREE), (Face.SYMMETRIC, Face.FREE))
    simulation = start(Problem(geometry, (sliding,), faces, end_time=1.0), threads=1)
    for _ in range(40):
        simulation.advance()
    assert np.allclose(simulation.particles.velocity, (500.0, 0.0, 0.0), rtol=0.0, atol=1e-6)


def test_axis__gets_no_momentum_along_itself() -> None:
    """The symmetric face at r = 0 pushes in r alone, so the balance along z closes without it."""
    simulation = start(two_blocks("axisymmetric"), threads=1)
    for _ in range(40):
        simulation.advance()
    assert simulation.impulse[1] == 0.0
    assert simulation.audit().momentum_error <= ROUND_OFF


def test_face__is_where_the_momentum_of_a_pressed_block_goes() -> None:
    """A block under pressure p between two fixed faces is pushed by p times the area from each side."""
    geometry = box(2, 2, 4)
    full = block(geometry, (0.0, 0.0, 0.0), (2.0, 2.0, 4.0))
    fixed = (Face.FIXED, Face.FIXED)
    lower_only = (SYMMETRIC, SYMMETRIC, (Face.FIXED, Face.FREE))
    pressure = 1e9
    for faces, expected in (((SYMMETRIC, SYMMETRIC, fixed), 0.0), (lower_only, 1.0)):
        simulation = start(Problem(geometry, (full,), faces, end_time=1.0), threads=1)
        simulation.particles.pressure[:] = pressure
        dt = simulation.dt
        simulation.advance()
        push = simulation.impulse[2] / (pressure * (2.0 * SPACING) ** 2 * dt)
        assert push == pytest.approx(expected, abs=1e-9)
