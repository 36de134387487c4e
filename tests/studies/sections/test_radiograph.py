"""Radiographs of bodies with a known areal density, from rings and from points, and over a file."""

import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from solver.problem import Problem
from solver.problem.geometry import Axisymmetric, Cartesian3D, grid, impact_axis
from solver.simulation import start
from solver.state import Particles, Snapshot
from studies.sections.radiograph import Radiograph, radiograph
from tests.solver.bodies import ABOUT_AXIS, DENSITY, FREE, SYMMETRIC, real_copper
from tests.solver.bodies import block as block_of

SPACING = 1e-3
RADIUS, MIDDLE = 8e-3, 12e-3
PIXEL = 1e-3
ROUND_OFF = 1e-12


def ball(kind: str) -> tuple[Problem, Snapshot, float]:
    """A ball at rest about the axis: a body of revolution, or a quarter; and whole bodies over the model."""
    flat = kind == "axisymmetric"
    record, cells = (Axisymmetric, (10, 24, 0)) if flat else (Cartesian3D, (10, 10, 24))
    geometry: Any = grid(record, lower=(0.0, 0.0, 0.0), cells=cells, spacing=SPACING)
    low, high = ((0.0, 2.0), (9.0, 22.0)) if flat else ((0.0, 0.0, 2.0), (9.0, 9.0, 22.0))
    body = block_of(geometry, low, high, matter=real_copper(), name="ball")
    axis = impact_axis(geometry)
    away = (body.position[:, axis] - MIDDLE) ** 2 + (body.position[:, :axis] ** 2).sum(axis=1)
    kept = away < RADIUS**2
    body = replace(body, position=body.position[kept], mass=body.mass[kept])
    faces = ABOUT_AXIS if flat else ((SYMMETRIC[0], FREE[1]), (SYMMETRIC[0], FREE[1]), FREE)
    problem = Problem(geometry, (body,), faces, end_time=1.0)
    return problem, start(problem).snapshot(), 2.0 * math.pi if flat else 4.0


@pytest.fixture(params=["axisymmetric", "quarter"])
def taken(request: pytest.FixtureRequest) -> tuple[Radiograph, float]:
    problem, snapshot, whole = ball(request.param)
    mass = whole * float(problem.bodies[0].mass.sum())
    return radiograph(problem, snapshot, pixel=PIXEL, whole=whole), mass


def test_radiograph__has_the_whole_mass(taken: tuple[Radiograph, float]) -> None:
    shown, mass = taken
    assert 2.0 * shown.density.sum() * PIXEL**2 == pytest.approx(mass, rel=ROUND_OFF)


def test_radiograph__of_a_ball_is_the_chord_through_it(taken: tuple[Radiograph, float]) -> None:
    """Inside of seven tenths of the radius, where a pixel does not see the edge."""
    shown, _ = taken
    rows, columns = shown.density.shape
    along = shown.origin + (np.arange(rows)[:, None] + 0.5) * PIXEL - MIDDLE
    across = (np.arange(columns) + 0.5) * PIXEL
    away = np.hypot(along, across)
    inside = away < 0.7 * RADIUS
    chord = 2.0 * DENSITY * np.sqrt(np.maximum(RADIUS**2 - away**2, 0.0))
    np.testing.assert_allclose(shown.density[inside], chord[inside], rtol=0.08)
    assert shown.density[inside].mean() == pytest.approx(chord[inside].mean(), rel=0.01)


def test_radiograph__of_stretched_matter_has_no_stripes() -> None:
    """Rings of one radius that lie three pixels apart are grey between them, and keep their mass."""
    problem, snapshot, whole = ball("axisymmetric")
    position = snapshot.particles.position.copy()
    position[:, 0], position[:, 1] = 4.0 * PIXEL, MIDDLE + 3.0 * PIXEL * (np.arange(len(position)) % 3 - 1.0)
    few = slice(0, 3)
    state = Particles(*(column[few] if isinstance(column, np.ndarray) else column for column in snapshot.particles))
    shown = radiograph(
        problem, snapshot._replace(particles=state._replace(position=position[few])), pixel=PIXEL, whole=whole
    )
    middle = round((MIDDLE - shown.origin) / PIXEL)
    assert (shown.density[middle - 3 : middle + 3, 1] > 0.0).all()
    assert 2.0 * shown.density.sum() * PIXEL**2 == pytest.approx(whole * state.mass.sum(), rel=0.01)
