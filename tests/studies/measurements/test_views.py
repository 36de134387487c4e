"""Views turn the arrays of the solver into the states that measurements read, in every geometry."""

import math
from typing import Any

import numpy as np
import pytest

from solver.state import Particles, Snapshot, empty_table, views
from studies.measurements.impact.opening import azimuthal_spread
from studies.measurements.impact.view import ImpactView, view
from tests.studies.measurements.states import (
    BREADTH,
    CELL,
    CRATER,
    DENSITY,
    DEPTH,
    HOLE,
    OPENINGS,
    PARTICLE,
    RADIUS,
    THICKNESS,
    body_of,
    lattice,
    line,
    read,
    scooped_half_space,
    setting_of_plate,
    snapshot_of,
    value,
)


def plate(kind: str, *, hole: float = HOLE, slug: float = 0.0) -> ImpactView:
    """A drilled plate, with a free slug within a radius, as a geometry shows it."""
    setting, particles = plate_of_particles(kind, hole=hole, slug=slug)
    return view(setting, snapshot_of(particles))


def plate_of_particles(
    kind: str, *, hole: float = HOLE, slug: float = 0.0, middle: float = 0.0, oval: float = 1.0
) -> tuple[Any, Particles]:
    """What ``view`` asks a setting for, and the particles; the hole may be an oval, its middle off the axis."""
    flat = kind == "axisymmetric"
    across, along = line(0.0, RADIUS), line(0.0, THICKNESS)
    wide = np.concatenate([-across[::-1], across]) if kind == "half" else across
    lines = (across, along, np.zeros(1)) if flat else (wide, across, along)
    position = np.stack(lattice(*lines), axis=-1)
    aside = 0.0 if flat else oval * position[:, 1]
    from_axis = np.hypot(position[:, 0] - middle, aside)
    position = position[(from_axis > hole) | (from_axis < slug)]
    return setting_of_plate(kind), particles_at(kind, position)


def particles_at(kind: str, position: np.ndarray) -> Particles:
    particles = views(empty_table(len(position)))
    particles.position[:] = position
    measure = position[:, 0] * PARTICLE**2 if kind == "axisymmetric" else PARTICLE**3
    particles.mass[:] = DENSITY * measure
    return particles


@pytest.mark.parametrize("opening", OPENINGS)
def test_opening__is_the_same_in_a_quarter_and_about_the_axis(opening: str) -> None:
    flat, quarter = (value(opening, plate(kind)) for kind in ("axisymmetric", "quarter"))
    assert abs(flat - quarter) < 0.5 * CELL
    assert abs(flat - 2.0 * HOLE) < 2.0 * PARTICLE


@pytest.mark.parametrize(("free_cells", "touching"), [(0, True), (1, False)])
def test_view__takes_neighbouring_cells_for_contact_and_no_others(free_cells: int, touching: bool) -> None:
    edge = (math.floor(HOLE / CELL) - free_cells) * CELL  # where the last cell of the slug ends
    state = plate("axisymmetric", slug=edge)
    assert state.attached_target.all() == touching


@pytest.mark.parametrize("failed", [False, True])
def test_view__takes_neither_projectile_nor_failed_matter_for_plate(failed: bool) -> None:
    """What fills the hole and is no plate, or has failed, joins the matter, but not the plate, to the rim."""
    setting, particles = plate_of_particles("axisymmetric", slug=HOLE)
    outside = particles.position[:, 0] > HOLE
    setting.problem.bodies = (body_of("projectile", DENSITY), *setting.problem.bodies)
    particles.damage[:] = failed & ~outside
    state = view(setting, Snapshot(0.0, 0, particles, (outside | failed).astype(np.int64)))
    assert state.attached.all()
    assert np.array_equal(state.attached_target, outside)
    assert value("hole_diameter", state) == value("hole_diameter", plate("axisymmetric"))


def lined_crater(density: float, *, thick: float, thin: bool) -> ImpactView:
    """A crater whose wall a projectile lines, as a solid or with a quarter of its particles."""
    block = scooped_half_space(CRATER - thick)
    lining = np.hypot(block.radius, block.depth) < CRATER
    even = (np.floor(block.radius / PARTICLE) + np.floor(block.depth / PARTICLE)) % 4.0 == 0.0
    left = ~lining | even if thin else np.ones_like(lining)
    places = (block.radius[left], block.depth[left], np.zeros(left.sum()))
    particles = particles_at("axisymmetric", np.stack(places, axis=-1))
    body = lining[left].astype(np.int64)
    particles.mass[body == 1] *= density / DENSITY
    setting = setting_of_plate("axisymmetric", thickness=DEPTH, radius=BREADTH)
    setting.problem.bodies = (*setting.problem.bodies, body_of("projectile", density))
    return view(setting, Snapshot(0.0, 0, particles, body))


@pytest.mark.parametrize("density", [DENSITY, 2700.0, 19300.0])
@pytest.mark.parametrize("thin", [False, True])
@pytest.mark.parametrize("crater", ["crater_depth", "crater_diameter"])
def test_crater__ends_where_half_of_the_space_is_filled_by_whatever_metal(
    crater: str, thin: bool, density: float
) -> None:
    thick = 4.0 * CELL
    reading = value(crater, lined_crater(density, thick=thick, thin=thin))
    wanted = value(crater, scooped_half_space(CRATER if thin else CRATER - thick))
    assert abs(reading - wanted) < 2.0 * PARTICLE


# An oval hole beside the first touch, as an oblique shot makes it: half axes and shift
LONG, SHORT, ASIDE = 10e-3, 7e-3, 5e-3
AREA_DIAMETER = 2.0 * math.sqrt(LONG * SHORT)


def test_oblique_hole__is_that_of_its_area_and_its_shape_is_no_uncertainty() -> None:
    setting, particles = plate_of_particles("half", hole=LONG, middle=ASIDE, oval=LONG / SHORT)
    setting.problem.bodies = (*setting.problem.bodies, body_of("projectile", DENSITY, (1.0, 0.0, 1.0)))
    state = view(setting, snapshot_of(particles))
    assert abs(state.target_radius - (RADIUS - ASIDE)) < 0.1 * CELL
    # The innermost edge of a sector of an oval lies a little inside its mean.
    for opening, off in zip(OPENINGS, (CELL, 0.1 * CELL, CELL), strict=True):
        reading = read(opening, state)
        assert abs(reading.value - AREA_DIAMETER) < off
        assert reading.parts["azimuth"] < 0.2 * CELL


def test_azimuthal_spread__of_independent_sectors_is_the_standard_error_of_their_mean() -> None:
    scatter, sectors = 0.1e-3, 20000
    radii = HOLE + np.random.default_rng(0).normal(0.0, scatter, sectors)
    expected = 2.0 * scatter / math.sqrt(sectors)
    assert math.isclose(azimuthal_spread(radii), expected, rel_tol=0.03)
