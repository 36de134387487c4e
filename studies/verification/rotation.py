"""Rigid rotation of matter under stress: the stress turns with it and keeps its size, at a point and on the grid.

With ``jaumann: off`` the same stress stays as it is in space, which the matter turns away from.
"""

import math
from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from solver.geometry import grid
from solver.geometry.cartesian3d import Cartesian3D
from solver.problem import ArtificialViscosity, Body, Face, Problem
from solver.simulation import start
from solver.stress import PointState, advance
from solver.tensor import Unturned, equivalent_stress
from studies.values.recipes import Recipe
from studies.verification import Case, Row, at_most, reported
from studies.verification._column import lattice, solver_numerics
from studies.verification._matter import elastic
from studies.verification._waves import Isotropic

MATTER = Isotropic(8930.0, 117e9, 0.35)  # copper: Ma (2005), Table 2.1
STRESS = (3e8, -1e8, -2e8, 0.5e8, -0.7e8, 1.1e8)  # Pa: a deviator
# Difference of the principal stresses, Pa: the change by one radian too far.
LARGEST_DIFFERENCE = 4e8
AXIS = (0.6, 0.0, 0.8)
STEPS = (50, 200)  # for a full turn
ROUND_OFF = 1e-12

CELLS, SPACING, TURN = 16, 1e-3, 0.05  # of the block on the grid; TURN in one step, rad
INSIDE = 6.0  # cells from the surface that a step can see: four mappings, each of a cell and a half


def _run(recipe: Recipe) -> Iterator[Row]:
    for steps in STEPS:
        before, after = _turned_point(2.0 * math.pi / steps, steps)
        yield at_most(
            f"point, a full turn in {steps} steps: change of the von Mises stress",
            limit=ROUND_OFF * steps,
            got=abs(_mises(after) / _mises(before) - 1.0),
        )
        # The midpoint rotation turns by 2 atan(w / 2) instead of w: (w^3 / 12) in each step.
        missed = 2.0 * math.pi * (2.0 * math.pi / steps) ** 2 / 12.0
        gap = float(np.abs(np.subtract(before, after)).max())
        yield at_most(
            f"point, a full turn in {steps} steps: stress missed (of the bound from the midpoint rule)",
            limit=1.0,
            got=gap / (2.0 * missed * LARGEST_DIFFERENCE),
        )
    yield from _on_grid(recipe)


def _mises(stress: tuple[float, ...] | np.ndarray) -> float:
    return float(equivalent_stress(tuple(stress)))


def _turned_point(angle: float, steps: int) -> tuple[tuple[float, ...], tuple[float, ...]]:
    """A stress before and after steps that only turn it."""
    dt = 1e-8
    gradient = spin([part * angle for part in AXIS]) / dt
    point = PointState(MATTER.density, 0.0, 0.0, 0.0, STRESS, 0.0, 300.0)
    matter = elastic(MATTER)
    for _ in range(steps):
        point = advance(matter, ArtificialViscosity(), SPACING, dt, np.ascontiguousarray(gradient), point)[0]
        point = point._replace(density=MATTER.density)  # its straight steps grow the volume
    return STRESS, point.deviator


def spin(vector: list[float]) -> np.ndarray:
    """The velocity gradient of a rotation."""
    x, y, z = vector
    return np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])


def _on_grid(recipe: Recipe) -> Iterator[Row]:
    """One step of a block that turns rigidly: particles that the surface cannot reach turn their stress."""
    got = _after_a_turn(_block(recipe))
    sizes = np.array([_mises(stress) for stress in got])
    yield at_most(
        f"grid, {TURN} rad in a step: change of the von Mises stress",
        limit=ROUND_OFF * 1e2,
        got=float(np.abs(sizes / _mises(STRESS) - 1.0).max()),
    )
    turned = rotated(STRESS, 2.0 * math.atan(0.5 * TURN))
    yield at_most(
        f"grid, {TURN} rad in a step: distance from the stress turned by 2 atan(w / 2) (of its size)",
        limit=ROUND_OFF * 1e2,
        got=_farthest(got, turned),
    )
    got = _after_a_turn(replace(_block(recipe), stress_rate=Unturned()))
    yield at_most(
        f"grid, jaumann off, {TURN} rad in a step: change of the stress in space (of its size)",
        limit=ROUND_OFF * 1e2,
        got=_farthest(got, np.array(STRESS)),
    )
    yield reported(
        "grid, jaumann off: distance from the stress of the matter that has turned (of its size)",
        _farthest(got, turned),
    )


def _after_a_turn(problem: Problem) -> np.ndarray:
    """Deviators (n, 6) of the inner particles after a step that began with ``STRESS`` everywhere, Pa."""
    simulation = start(problem, threads=1)
    simulation.particles.deviator[:] = STRESS
    before = simulation.particles.position.copy()
    simulation.advance()
    middle = 0.5 * CELLS * SPACING
    inside = np.abs(before - middle).max(axis=1) < (0.5 * CELLS - INSIDE) * SPACING
    deviators: np.ndarray = simulation.particles.deviator[inside]
    return deviators


def _farthest(stress: np.ndarray, expected: np.ndarray) -> float:
    """Largest difference of any component, over the size of ``STRESS``."""
    return float(np.abs(stress - expected).max()) / _mises(STRESS)


def rotated(stress: tuple[float, ...], angle: float) -> np.ndarray:
    """R s R^T about ``AXIS`` (Rodrigues), six components."""
    xx, yy, zz, xy, yz, zx = stress
    full = np.array([[xx, xy, zx], [xy, yy, yz], [zx, yz, zz]])
    k = spin(list(AXIS))
    turn = np.eye(3) + math.sin(angle) * k + (1.0 - math.cos(angle)) * k @ k
    s = turn @ full @ turn.T
    return np.array([s[0, 0], s[1, 1], s[2, 2], s[0, 1], s[1, 2], s[2, 0]])


def _block(recipe: Recipe) -> Problem:
    """A cube in the middle of a larger grid; one fixed step turns it by ``TURN``."""
    per_cell = recipe.particles_per_cell
    line = SPACING / per_cell * (np.arange(CELLS * per_cell) + 0.5)
    position = lattice(line, line, line)
    dt = 1e-9
    turning = spin([part * TURN / dt for part in AXIS])
    body = Body(
        name="block",
        matter=elastic(MATTER),
        position=position,
        velocity=(position - 0.5 * CELLS * SPACING) @ turning.T,
        mass=np.full(len(position), MATTER.density * (SPACING / per_cell) ** 3),
        density=MATTER.density,
        spacing=(SPACING / per_cell,) * 3,
    )
    free = (Face.FREE, Face.FREE)
    geometry = grid(Cartesian3D, lower=(-2.0 * SPACING,) * 3, cells=(CELLS + 4,) * 3, spacing=SPACING)
    return Problem(
        geometry=geometry,
        bodies=(body,),
        faces=(free, free, free),
        end_time=dt,
        **{**solver_numerics(replace(recipe, damping_rate=0.0)), "fixed_dt": dt},
    )


CASE = Case(
    name="rotation",
    says="rigid rotation turns stress and keeps its size; with jaumann off the stress stays as it is in space",
    source="objectivity: Jaumann's rate by the midpoint rotation of Hughes and Winget (1980); Ma (2005), section 2.2.1",
    run=_run,
)
