"""Smoothed particles coupled to finite elements: common motion, balances, bits and refusals."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from solver.errors import ProblemError
from solver.methods.fem.mesh import lattice, node_masses
from solver.problem import Body, Face, Problem, Smoothing, Traction
from solver.simulation import simulate, start
from tests.solver.bodies import DENSITY, FREE, OPEN, SPACING, box, elastic_copper

CELLS = 4
LINE = (CELLS + np.arange(CELLS + 1)) * SPACING


def bar(velocity: Any = 0.0, across: np.ndarray = LINE, **changes: Any) -> Problem:
    """A block of elements beneath one of particles that begin at the nodes of the mesh that would go on."""
    position, mesh = lattice(across, LINE, LINE)
    above = position + np.array([0.0, 0.0, CELLS * SPACING])

    def body(name: str, place: np.ndarray, own: Any) -> Body:
        flow = velocity(place) if callable(velocity) else np.full(place.shape, velocity)
        masses = node_masses(mesh, position, DENSITY)
        return Body(name, elastic_copper(), place, flow, masses, DENSITY, (SPACING,) * 3, mesh=own)

    standard = {
        "geometry": box(3 * CELLS, 3 * CELLS, 5 * CELLS),
        "bodies": (body("elements", position, mesh), body("particles", above, None)),
        "faces": OPEN,
        "end_time": 1e-6,
        "smoothing": Smoothing(),
    }
    return Problem(**{**standard, **changes})


def pressing(place: np.ndarray) -> np.ndarray:
    """The particles run into the elements, m/s."""
    return np.outer(50.0 * (2.0 - place[:, 2] / (CELLS * SPACING)), [0.0, 0.0, 1.0])


def test_common_motion_strains_nothing() -> None:
    outcome = simulate(bar(10.0))
    p = outcome.snapshot.particles
    np.testing.assert_allclose(p.velocity, 10.0, rtol=1e-9)
    assert np.abs(p.density / DENSITY - 1.0).max() < 1e-9


def test_particles_fixed_to_nodes_move_with_them() -> None:
    p = simulate(bar(pressing)).snapshot.particles
    nodes = p.number.size // 2
    node, particle = p.number[:nodes] % nodes, p.number[nodes:] % nodes
    np.testing.assert_array_equal(node, np.arange(nodes))
    top, bottom = node % (CELLS + 1) == CELLS, particle % (CELLS + 1) == 0
    place = p.position[nodes:][bottom][np.argsort(particle[bottom])]
    np.testing.assert_allclose(p.position[:nodes][top], place, atol=1e-9 * SPACING)
    assert np.abs(p.deviator).max() > 1e6


def test_momentum_is_kept_to_round_off_and_energy_to_the_error_of_two_readings() -> None:
    audit = simulate(bar(pressing)).audit
    assert audit.mass_error < 1e-12
    assert audit.momentum_error < 1e-12
    assert abs(audit.energy_drift) < 0.02


@pytest.mark.claim("methods", "coupled-ringing", minutes=0.1)
def test_block_that_rings_never_gains_energy() -> None:
    """A coupled block that rings never gains energy."""
    history = simulate(bar(pressing, end_time=60e-6), lambda _: None, interval=2e-6).history
    drifts = np.array([audit.energy_drift for audit in history])
    assert drifts.max() < 0.005
    assert drifts.min() > -0.25
    assert history[-1].momentum_error < 1e-10


def test_half_a_block_at_a_plane_of_symmetry_moves_as_the_whole_one() -> None:
    """On the plane stand halves of particles and nodes."""
    half, whole = np.arange(4) * SPACING, np.arange(7) * SPACING
    mirror = ((Face.SYMMETRIC, Face.FREE), FREE, FREE)
    outcome = simulate(bar(pressing, half, faces=mirror, fixed_dt=2e-8))
    assert outcome.audit.momentum_error < 1e-12
    one = outcome.snapshot.particles
    place = 3 * SPACING
    both = simulate(bar(pressing, whole + place, fixed_dt=2e-8)).snapshot.particles
    begin = np.concatenate([body.position for body in bar(across=whole + place).bodies])
    right = np.flatnonzero(begin[both.number, 0] > 1.99 * place)
    right = right[np.argsort(both.number[right])]
    mine = np.argsort(one.number)
    np.testing.assert_allclose(one.velocity[mine], both.velocity[right], atol=1e-9 * np.abs(both.velocity).max())


def test_bodies_that_cannot_be_coupled_are_refused() -> None:
    problem = bar()
    elements, particles = problem.bodies
    with pytest.raises(ProblemError, match="mesh come first"):
        start(replace(problem, bodies=(particles, elements)))
    load = Traction(1, 2, 1, np.array([0.0, 1.0]), np.full(2, 1e6))
    with pytest.raises(ProblemError, match="a traction presses on particles"):
        start(replace(problem, tractions=(load,)))
    away = replace(particles, position=particles.position + 0.3 * SPACING)
    with pytest.raises(ProblemError, match="no particle begins at a node"):
        start(replace(problem, bodies=(elements, away)))
