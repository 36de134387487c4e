"""Absorbing surfaces: the traction that they give, what stands still and what leaves, and the books of it."""

import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from solver.absorb import Dashpots, absorber, dashpots
from solver.errors import ProblemError
from solver.faces import closed_nodes
from solver.geometry import node_positions
from solver.problem import Absorber, Body, Contact, Damping, Problem
from solver.registry import entries
from solver.simulation import Simulation, start
from tests.solver.bodies import (
    ABOUT_AXIS,
    DENSITY,
    FREE,
    SHEAR_MODULUS,
    SOUND_SPEED,
    SPACING,
    SYMMETRIC,
    block,
    box,
    elastic_copper,
)

SHAPES = [entry.record() for entry in entries("solver.shapes", "SHAPE").values()]
each_shape = pytest.mark.parametrize("shape", SHAPES, ids=lambda shape: type(shape).__name__)
NORMAL = np.sqrt(DENSITY * (DENSITY * SOUND_SPEED**2 + 4.0 / 3.0 * SHEAR_MODULUS))  # rho c, Pa s/m
ACROSS = np.sqrt(DENSITY * SHEAR_MODULUS)
SPEED = 1.0
TINY = 1e-13  # s: so short a step that the velocities stay what they are


def end(axis: int, place: float) -> Absorber:
    """The upper end of a body, at a place in cells."""
    return absorber(elastic_copper(), body=0, axis=axis, side=1, place=place * SPACING)


def column(body_end: float, velocity: tuple[float, float, float], **changes: Any) -> Simulation:
    """A column of one cell's width between mirrors, from 2 cells to its absorbing end."""
    geometry = box(12, 1, 1)
    body = block(geometry, (2.0, 0.0, 0.0), (body_end, 1.0, 1.0), velocity=velocity)
    faces = (FREE, SYMMETRIC, SYMMETRIC)
    absorbers = (end(0, body_end),)
    problem = Problem(geometry, (body,), faces, end_time=1.0, absorbers=absorbers, **changes)
    return start(problem, threads=1)


def test_absorber__has_the_impedances_of_its_matter() -> None:
    """rho c of the two waves; the normal one is that of the axis."""
    surface = end(1, 3.0)
    assert np.allclose(surface.impedance, (ACROSS, NORMAL, ACROSS), rtol=1e-12)


@each_shape
@pytest.mark.parametrize("offset", [0.0, 0.2, 0.5])
@pytest.mark.parametrize(
    "direction", [(1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)], ids=["x", "y", "z"]
)
def test_dashpots__answer_a_velocity_with_area_times_impedance(
    shape: Any, offset: float, direction: tuple[float, float, float]
) -> None:
    """Along the normal and across it; where the lattice does not fit the grid, as well as the shapes allow."""
    velocity = SPEED * np.array(direction)
    geometry = box(14, 10, 10)
    low, high = (2.0 + offset, 3.0, 3.0), (8.0 + offset, 7.0, 7.0)
    problem = Problem(
        geometry,
        (block(geometry, low, high, velocity=tuple(velocity)),),
        (FREE, FREE, FREE),
        end_time=1.0,
        shape=shape,
        fixed_dt=TINY,
        absorbers=(end(0, 8.0 + offset),),
    )
    simulation = start(problem, threads=1)
    simulation.advance()
    impedance = np.array([NORMAL, ACROSS, ACROSS])
    expected = -impedance * velocity * (4.0 * SPACING) ** 2 * TINY
    within = 1e-6 if offset in (0.0, 0.5) else 0.03
    assert np.allclose(simulation.impulse, expected, rtol=within, atol=0.0)


@each_shape
@pytest.mark.parametrize("body_end", [8.0, 8.5])
def test_dashpots__balance_the_stress_of_a_wave_at_every_node(shape: Any, body_end: float) -> None:
    """Matter under the stress of a wave, with its velocity, goes on as if there were no end."""
    simulation = column(body_end, (SPEED, 0.0, 0.0), shape=shape, fixed_dt=TINY)
    simulation.particles.pressure[:] = NORMAL * SPEED
    simulation.advance()
    far = simulation.particles.position[:, 0] > 5.0 * SPACING  # from the other end, which is free
    change = simulation.particles.velocity[far, 0] / SPEED - 1.0
    unbalanced = TINY * NORMAL / (DENSITY * SPACING)  # what the stress alone would change
    assert np.abs(change).max() < 1e-3 * unbalanced


@each_shape
@pytest.mark.parametrize(
    "changes",
    [{}, {"damping": Damping(1e6, 2)}, {"contact": Contact()}],
    ids=["plain", "damping", "contact"],
)
def test_absorbed_energy__is_booked_to_round_off(shape: Any, changes: dict[str, Any]) -> None:
    """And so is the momentum, in a body that leaves its place too."""
    simulation = column(8.0, (-500.0, 0.0, 0.0), shape=shape, **changes)
    for _ in range(60):
        simulation.advance()
    audit = simulation.audit()
    assert audit.removed_energy > 0.01
    assert abs(audit.energy_drift) < 1e-12
    assert abs(audit.momentum_error) < 1e-12


@each_shape
def test_dashpots__let_thin_debris_through(shape: Any) -> None:
    """A node with a fifth of its mass feels nothing."""
    simulation = column(8.0, (SPEED, 0.0, 0.0), shape=shape)
    simulation.particles.mass[:] *= 0.2
    simulation.advance()
    assert np.allclose(simulation.particles.velocity, (SPEED, 0.0, 0.0), rtol=1e-12, atol=1e-12)
    assert simulation.removed == 0.0


def test_dashpots__hold_the_body_alone_that_has_them() -> None:
    """Where bodies have fields of their own, another one that stands there is free."""
    geometry = box(12, 1, 1)
    bodies = [
        block(geometry, (low, 0.0, 0.0), (8.0, 1.0, 1.0), velocity=(0.0, 0.0, 0.0), name=name)
        for low, name in ((2.0, "held"), (4.0, "free"))
    ]
    faces = (FREE, SYMMETRIC, SYMMETRIC)
    problem = Problem(
        geometry,
        tuple(bodies),
        faces,
        end_time=1.0,
        contact=Contact(),
        absorbers=(end(0, 8.0),),
    )
    held, free = start(problem, threads=1).stepper.fields
    assert [len(held.dashpots), len(free.dashpots)] == [1, 0]
    alone = start(replace(problem, bodies=(bodies[0],)), threads=1).stepper.fields[0]
    assert np.array_equal(held.dashpots[0].constant, alone.dashpots[0].constant)


def test_absorber__without_a_surface_is_refused() -> None:
    inside = replace(column(8.0, (0.0, 0.0, 0.0)).problem, absorbers=(end(0, 6.0),))
    with pytest.raises(ProblemError, match=r"'block' has no surface at 0\.006 m on axis 0"):
        start(inside, threads=1)


@each_shape
def test_dashpots__of_a_half_are_those_of_the_whole(shape: Any) -> None:
    """At a mirror the ghosts' area goes to the nodes inside."""
    whole, half = box(14, 12, 10), box(14, 6, 10)
    low, high = (2.0, 2.0, 3.0), (8.0, 10.0, 7.0)
    bodies = block(whole, low, high), block(half, (2.0, 0.0, 3.0), (8.0, 4.0, 7.0))
    faces = (FREE, FREE, FREE), (FREE, (SYMMETRIC[0], FREE[1]), FREE)
    total = [
        _constants(geometry, body, sides, shape)
        for geometry, body, sides in zip((whole, half), bodies, faces, strict=True)
    ]
    middle = np.isclose(total[0][:, 1], 6.0 * SPACING)
    of_half = np.isclose(total[1][:, 1], 0.0)
    # On the mirror stands half of the area that the whole has there, and next to it all of it.
    assert np.isclose(total[0][middle, 3].sum(), 2.0 * total[1][of_half, 3].sum(), rtol=1e-12)
    beside = np.isclose(total[0][:, 1], 7.0 * SPACING)
    beside_half = np.isclose(total[1][:, 1], SPACING)
    assert np.isclose(total[0][beside, 3].sum(), total[1][beside_half, 3].sum(), rtol=1e-12)


@each_shape
def test_dashpots__of_a_quarter_know_the_mass_of_the_whole(shape: Any) -> None:
    """At a mirror the ghosts' mass goes to the nodes inside, and at an edge of two mirrors along each of them."""
    whole, quarter = box(14, 12, 12), box(14, 6, 6)
    bodies = (
        block(whole, (2.0, 2.0, 2.0), (8.0, 10.0, 10.0)),
        block(quarter, (2.0, 0.0, 0.0), (8.0, 4.0, 4.0)),
    )
    mirror = (SYMMETRIC[0], FREE[1])
    found = [
        _found(geometry, body, faces, shape)
        for geometry, body, faces in zip(
            (whole, quarter), bodies, ((FREE,) * 3, (FREE, mirror, mirror)), strict=True
        )
    ]
    full = [
        dict(zip(map(tuple, np.rint((place - low) / SPACING).astype(int)), one.full, strict=True))
        for (one, place), low in zip(found, ((0.0, 6e-3, 6e-3), (0.0, 0.0, 0.0)), strict=True)
    ]
    inner = [place for place in full[1] if min(place[1:]) > 0]
    assert any(place[1:] == (1, 1) for place in inner)
    for place in inner:
        assert math.isclose(full[1][place], full[0][place], rel_tol=1e-12)


@each_shape
def test_dashpots__of_a_rim_have_its_area_per_radian(shape: Any) -> None:
    """R times the height, and half the radius squared at the back."""
    geometry = box(8, 12)
    body = block(geometry, (0.0, 3.0), (6.0, 8.0))
    for surface, area in ((end(0, 6.0), 6.0 * 5.0), (end(1, 8.0), 0.5 * 6.0**2)):
        found = _constants(geometry, body, ABOUT_AXIS, shape, surface)[:, 3 + 2].sum()
        assert np.isclose(found, ACROSS * area * SPACING**2, rtol=1e-2)


def _constants(
    geometry: Any, body: Body, faces: Any, shape: Any, surface: Absorber | None = None
) -> np.ndarray:
    """Place and constants of each node of the dashpots, (n, 6)."""
    found, place = _found(geometry, body, faces, shape, surface)
    return np.hstack([place, found.constant])


def _found(
    geometry: Any, body: Body, faces: Any, shape: Any, surface: Absorber | None = None
) -> tuple[Dashpots, np.ndarray]:
    """The dashpots and the places of their nodes."""
    surface = surface or end(0, 8.0)
    problem = Problem(geometry, (body,), faces, end_time=1.0, shape=shape, absorbers=(surface,))
    found = dashpots(problem, surface, closed_nodes(geometry, faces, problem.clamp))
    return found, node_positions(geometry)[found.node]


def test_problem__without_absorbers_has_no_dashpots() -> None:
    simulation = column(8.0, (SPEED, 0.0, 0.0))
    plain = start(replace(simulation.problem, absorbers=()), threads=1)
    assert plain.stepper.fields[0].dashpots == []
