"""Finite elements against exact answers: patches, rotation, balances, loads, faces."""

import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from solver.errors import ProblemError, UnphysicalState
from solver.methods.fem.mesh import lattice, node_masses, volumes_of
from solver.problem import Body, Face, Mesh, Problem, Traction
from solver.simulation import simulate, start
from tests.solver.bodies import (
    DENSITY,
    FREE,
    OPEN,
    ROUND_OFF,
    SPACING,
    SYMMETRIC,
    assert_balanced,
    box,
    elastic_copper,
    real_copper,
)

CELLS, JITTER = 4, 0.15
STEP = 1e-8  # s


def skewed() -> tuple[np.ndarray, Mesh]:
    """A cube whose inner nodes are moved at random."""
    line = np.arange(CELLS + 1) * SPACING
    position, mesh = lattice(line, line, line)
    inner = ((position > 0.0) & (position < CELLS * SPACING)).all(axis=1)
    position[inner] += np.random.default_rng(1).uniform(-JITTER, JITTER, position[inner].shape) * SPACING
    return position, mesh


def problem_of(flow: Any = 0.0, *, matter: Any = None, **changes: Any) -> Problem:
    """A free body whose nodes begin with the velocities ``flow(position)``."""
    position, mesh = skewed()
    velocity = flow(position) if callable(flow) else np.full(position.shape, flow)
    body = Body(
        name="body",
        matter=matter or real_copper(),
        position=position,
        velocity=velocity,
        mass=node_masses(mesh, position, DENSITY),
        density=DENSITY,
        spacing=(SPACING,) * 3,
        mesh=mesh,
    )
    standard = {"geometry": box(*[2 * CELLS] * 3), "bodies": (body,), "faces": OPEN, "end_time": 1e-6, "courant": 0.8}
    return Problem(**{**standard, **changes})


def squeezing(position: np.ndarray) -> np.ndarray:
    """A flow that strains, turns and bends, m/s."""
    x, y, z = position.T / (CELLS * SPACING)
    return 300.0 * np.stack([-x + 0.3 * y * x, 0.5 * x - y * y, 0.4 * z], axis=-1)


def test_uniform_stress_leaves_inner_nodes_alone() -> None:
    """The patch test: however skewed the mesh, a uniform pressure pushes on the surface alone."""
    simulation = start(problem_of())
    simulation.stepper.carried()["elements"][9] = 1e9  # pressure
    simulation.advance()
    particles = simulation.particles
    extent = particles.position / SPACING
    inner = ((extent > 0.5) & (extent < CELLS - 0.5)).all(axis=1)
    speed = np.abs(particles.velocity).max(axis=1)
    assert inner.sum() > 3
    assert speed[inner].max() < 1e-9 * speed.max()


def test_mass_momentum_and_energy_are_kept() -> None:
    outcome = simulate(problem_of(squeezing))
    assert outcome.snapshot.particles.plastic_strain.max() > 0.01
    assert_balanced(outcome.audit)


def test_rigid_rotation_stores_no_energy() -> None:
    """A tenth of a turn of an unloaded cube: midpoint strains are of second order in the angle of a step."""
    omega = 1e5
    problem = problem_of(
        lambda x: omega * np.stack([-x[:, 1], x[:, 0], 0.0 * x[:, 2]], axis=-1),
        matter=elastic_copper(),
        end_time=0.2 * math.pi / omega,
    )
    outcome = simulate(problem)
    assert abs(outcome.audit.internal) < 2e-3 * outcome.audit.kinetic


def test_hourglass_springs_push_back() -> None:
    """A mode that a single point does not see swings back; without springs it goes on for ever."""

    def mode(x: np.ndarray) -> np.ndarray:
        signs = (-1.0) ** np.rint(x / SPACING).sum(axis=1)
        return np.stack([10.0 * signs, 0.0 * signs, 0.0 * signs], axis=-1)

    def moved(hourglass: float) -> float:
        problem = problem_of(mode, matter=elastic_copper(), hourglass=hourglass, end_time=2e-6)
        position = start(problem).particles.position.copy()
        return float(np.abs(simulate(problem).snapshot.particles.position - position).max())

    assert moved(0.0) == pytest.approx(10.0 * 2e-6, rel=0.05)
    assert moved(0.05) < 0.5 * moved(0.0)


def test_traction_gives_its_impulse_and_work() -> None:
    pressure, axis, area = 1e8, 1, (CELLS * SPACING) ** 2
    load = Traction(0, axis, 1, np.array([0.0, 1.0]), np.full(2, pressure))
    outcome = simulate(problem_of(matter=elastic_copper(), tractions=(load,), end_time=20 * STEP, fixed_dt=STEP))
    p = outcome.snapshot.particles
    momentum = float((p.mass * p.velocity[:, axis]).sum())
    # Velocities live half a step before.
    elapsed = outcome.snapshot.time - 0.5 * STEP
    assert momentum == pytest.approx(-pressure * area * elapsed, rel=2e-3)
    assert abs(outcome.audit.energy_drift) < ROUND_OFF
    assert outcome.audit.exchanged.worked > 0.0


def test_closed_faces_hold_their_nodes_and_count_the_impulse() -> None:
    faces = ((Face.FIXED, Face.FREE), SYMMETRIC, FREE)
    outcome = simulate(problem_of(squeezing, faces=faces))
    p = outcome.snapshot.particles
    fixed = p.position[:, 0] == 0.0
    assert fixed.sum() == (CELLS + 1) ** 2
    assert (p.velocity[fixed] == 0.0).all()
    assert (p.velocity[p.position[:, 1] == 0.0, 1] == 0.0).all()
    assert outcome.audit.momentum_error < ROUND_OFF


def test_wall_stops_nodes_and_lets_go() -> None:
    faces = ((Face.WALL, Face.FREE), FREE, FREE)
    problem = problem_of(
        lambda x: np.tile([-20.0, 0.0, 0.0], (len(x), 1)), matter=elastic_copper(), faces=faces, end_time=8e-6
    )
    outcome = simulate(problem)
    p = outcome.snapshot.particles
    assert p.position[:, 0].min() > 0.0
    assert float((p.mass * p.velocity[:, 0]).sum()) > 0.0
    assert abs(outcome.audit.energy_drift) < ROUND_OFF


def test_elements_that_turn_inside_out_are_named() -> None:
    simulation = start(problem_of())
    middle = np.abs(simulation.particles.position - 0.5 * CELLS * SPACING).max(axis=1)
    simulation.particles.position[middle.argmin(), 0] += 6.0 * SPACING
    with pytest.raises(UnphysicalState, match=r"density = -.* of 'body'"):
        simulation.advance()


def test_meshes_that_cannot_be_computed_are_refused() -> None:
    position, mesh = skewed()
    with pytest.raises(ProblemError, match="no volume"):
        volumes_of(Mesh(mesh.nodes[:, [3, 2, 1, 0, 7, 6, 5, 4]]), position)
    problem = problem_of()
    with pytest.raises(ProblemError, match=r"do not compute .*revolution"):
        start(replace(problem, geometry=box(8, 8)))
