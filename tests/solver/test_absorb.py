"""Absorbing surfaces: the traction that they give, what leaves, and the energy that they remove."""

from typing import Any

import numpy as np
import pytest

from solver.grid.absorb import Dashpots, absorber, dashpots
from solver.grid.faces import closed_nodes
from solver.grid.nodes import node_positions
from solver.problem import Absorber, Body, Contact, Damping, Problem
from solver.simulation import start
from tests.solver.bodies import (
    ABOUT_AXIS,
    DENSITY,
    FREE,
    OPEN,
    ROUND_OFF,
    SHEAR_MODULUS,
    SOUND_SPEED,
    SPACING,
    SYMMETRIC,
    after,
    assert_balanced,
    block,
    box,
    each_shape,
    elastic_copper,
)

NORMAL = np.sqrt(DENSITY * (DENSITY * SOUND_SPEED**2 + 4.0 / 3.0 * SHEAR_MODULUS))  # rho c, Pa s/m
ACROSS = np.sqrt(DENSITY * SHEAR_MODULUS)
TINY = 1e-13  # s: so short a step that the velocities stay what they are


def end(axis: int, place: float) -> Absorber:
    """The upper end of a body, at a place in cells."""
    return absorber(elastic_copper(), body=0, axis=axis, side=1, place=place * SPACING)


def column(body_end: float, speed: float, **changes: Any) -> Problem:
    """A column of one cell's width between mirrors, from 2 cells to its absorbing end, that flies along x."""
    geometry = box(12, 1, 1)
    body = block(geometry, (2.0, 0.0, 0.0), (body_end, 1.0, 1.0), velocity=(speed, 0.0, 0.0))
    faces = (FREE, SYMMETRIC, SYMMETRIC)
    absorbers = (end(0, body_end),)
    return Problem(geometry, (body,), faces, end_time=1.0, absorbers=absorbers, **changes)


@each_shape
@pytest.mark.parametrize(("offset", "within"), [(0.0, 1e-6), (0.2, 0.03), (0.5, 1e-6)])
def test_dashpots__answer_a_velocity_with_area_times_impedance(shape: Any, offset: float, within: float) -> None:
    """Along the normal and across it; where the lattice does not fit the grid, as well as the shapes allow."""
    velocity = (1.0, 2.0, 3.0)
    geometry = box(14, 10, 10)
    body = block(geometry, (2.0 + offset, 3.0, 3.0), (8.0 + offset, 7.0, 7.0), velocity=velocity)
    absorbers = (end(0, 8.0 + offset),)
    problem = Problem(geometry, (body,), OPEN, end_time=1.0, shape=shape, fixed_dt=TINY, absorbers=absorbers)
    impedance = np.array([NORMAL, ACROSS, ACROSS])
    expected = -impedance * velocity * (4.0 * SPACING) ** 2 * TINY
    assert np.allclose(after(problem, 1).books.impulse, expected, rtol=within, atol=0.0)


@each_shape
@pytest.mark.parametrize("body_end", [8.0, 8.5])
def test_dashpots__balance_the_stress_of_a_wave_at_every_node(shape: Any, body_end: float) -> None:
    """Matter under the stress of a wave, with its velocity, goes on as if there were no end."""
    simulation = start(column(body_end, 1.0, shape=shape, fixed_dt=TINY), threads=1)
    simulation.particles.pressure[:] = NORMAL
    simulation.advance()
    far = simulation.particles.position[:, 0] > 5.0 * SPACING  # from the other end, which is free
    change = simulation.particles.velocity[far, 0] - 1.0
    unbalanced = TINY * NORMAL / (DENSITY * SPACING)  # what the stress alone would change
    assert np.abs(change).max() < 1e-3 * unbalanced


@each_shape
@pytest.mark.parametrize(
    "changes", [{}, {"damping": Damping(1e6, 2), "contact": Contact()}], ids=["alone", "with damping and contact"]
)
def test_absorbed_energy__is_removed_to_round_off(shape: Any, changes: dict[str, Any]) -> None:
    """And so is the momentum, in a body that leaves its place too."""
    audit = after(column(8.0, -500.0, shape=shape, **changes), 60).audit()
    assert audit.removed_energy > 0.01
    assert_balanced(audit)


@each_shape
def test_dashpots__of_a_quarter_are_those_of_the_whole(shape: Any) -> None:
    """What ghosts hold at a mirror goes to the nodes inside; a node on it has half of the area."""
    whole, quarter = box(14, 12, 12), box(14, 6, 6)
    mirror = (SYMMETRIC[0], FREE[1])
    body = block(whole, (2.0, 2.0, 2.0), (8.0, 10.0, 10.0))
    part = block(quarter, (2.0, 0.0, 0.0), (8.0, 4.0, 4.0))
    expected, place = _dashpots(whole, body, OPEN, shape, end(0, 8.0))
    by_place = dict(zip(_cells(place - (0.0, 6e-3, 6e-3)), range(len(place)), strict=True))
    got, place = _dashpots(quarter, part, (FREE, mirror, mirror), shape, end(0, 8.0))
    cells = _cells(place)
    assert any(cell[1:] == (0, 0) for cell in cells)
    for i, cell in enumerate(cells):
        inside = min(cell[1:]) >= 0
        share = 0.5 ** cell[1:].count(0) if inside else 0.0
        same = by_place[cell]
        assert np.allclose(got.constant[i], share * expected.constant[same], rtol=ROUND_OFF)
        if min(cell[1:]) > 0:
            assert np.isclose(got.full[i], expected.full[same], rtol=ROUND_OFF)


@each_shape
def test_dashpots__of_a_rim_have_its_area_per_radian(shape: Any) -> None:
    """R times the height, and half the radius squared at the back."""
    geometry = box(8, 12)
    body = block(geometry, (0.0, 3.0), (6.0, 8.0))
    for surface, area in ((end(0, 6.0), 6.0 * 5.0), (end(1, 8.0), 0.5 * 6.0**2)):
        surfaces, _ = _dashpots(geometry, body, ABOUT_AXIS, shape, surface)
        assert np.isclose(surfaces.constant[:, 2].sum(), ACROSS * area * SPACING**2, rtol=1e-2)


def _dashpots(geometry: Any, body: Body, faces: Any, shape: Any, surface: Absorber) -> tuple[Dashpots, np.ndarray]:
    """The dashpots of a surface and the places of their nodes, (n, 3) m."""
    problem = Problem(geometry, (body,), faces, end_time=1.0, shape=shape, absorbers=(surface,))
    made = dashpots(problem, surface, closed_nodes(geometry, faces, problem.clamp))
    return made, node_positions(geometry)[made.node]


def _cells(place: np.ndarray) -> list[tuple[int, ...]]:
    return [tuple(cells) for cells in np.rint(place / SPACING).astype(int).tolist()]
