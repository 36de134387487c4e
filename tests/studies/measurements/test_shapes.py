"""States of the solver as measurements see them in every geometry, and shapes in three dimensions of known sizes."""

import math
from collections.abc import Callable, Mapping
from functools import partial
from typing import Any

import numpy as np
import pytest

from solver.problem.geometry import Cartesian3D, grid
from solver.state import Particles, Snapshot, empty_table, views
from studies.measurements.impact.opening import azimuthal_spread
from studies.measurements.impact.view import ImpactView, view
from tests import samples
from tests.claims.rows import Row, absolute, relative
from tests.studies.measurements.states import (
    BREADTH,
    CELL,
    CRATER,
    DENSITY,
    DEPTH,
    DIAMETER,
    HOLE,
    OPENINGS,
    PARTICLE,
    RADIUS,
    TENTH,
    THICKNESS,
    body_of,
    lattice,
    line,
    read,
    reordered,
    scooped_half_space,
    setting_of_plate,
    snapshot_of,
    value,
)

SCOOP = 8e-3  # radius, m
# Half axes of the ellipse, m: 20 x 12 mm, whose mean root is 15.49 mm.
ELLIPSE = 10e-3, 6e-3
OFF_AXIS = 3.3e-3  # m
BOWL, SLIP = 8e-3, 2e-3  # depth, and the way of its deepest place from the middle of its mouth, m
SAME = 1e-10  # relative: sums run in another order

Inside = Callable[[np.ndarray, np.ndarray, np.ndarray], np.ndarray]


def half_block(inside: Inside, *, radius: float, thickness: float, per_cell: int = 4) -> ImpactView:
    """A target in a half model after an oblique shot, without the particles that ``inside`` (x, y, z) takes.

    A fine lattice makes the staircase of a curved wall small.
    """
    step = CELL / per_cell
    wide, across, along = (
        step * (np.arange(round((high - low) / step)) + 0.5) + low
        for low, high in ((-radius, radius), (0.0, radius), (0.0, thickness))
    )
    position = np.stack(lattice(wide, across, along), axis=-1)
    position = position[~inside(*position.T)]
    particles = views(empty_table(len(position)))
    particles.position[:], particles.mass[:] = position, DENSITY * step**3
    setting = setting_of_plate("half", radius=radius, thickness=thickness)
    target = body_of("target", DENSITY)
    target.spacing = (step,) * 3
    setting.problem.bodies = (target, body_of("projectile", DENSITY, (1.0, 0.0, 1.0)))
    setting.problem.geometry = grid(
        Cartesian3D,
        lower=(-radius, 0.0, -8.0 * CELL),
        cells=(round(2.0 * radius / CELL), round(radius / CELL), round(thickness / CELL) + 16),
        spacing=CELL,
    )
    return view(setting, snapshot_of(particles))


def _drill(x: np.ndarray, y: np.ndarray, z: np.ndarray) -> np.ndarray:
    a, b = ELLIPSE
    return ((x - OFF_AXIS) / a) ** 2 + (y / b) ** 2 < 1.0


def _tilted(x: np.ndarray, y: np.ndarray, z: np.ndarray) -> np.ndarray:
    """A bowl whose mouth is an ellipse off the axis, and whose deepest place is off the middle of its mouth."""
    (a, b), level = ELLIPSE, z / BOWL
    return ((x - OFF_AXIS - SLIP * level) / a) ** 2 + (y / b) ** 2 < 1.0 - level


def _floor(curvature: float) -> float:
    """Half of the rise of a round floor, by its curvature in 1/m, within the column in which it is looked for."""
    return 0.25 * (0.25 * DIAMETER) ** 2 * curvature


def _axes(quantity: str) -> dict[str, tuple[float, float]]:
    sizes = {"largest": 20e-3, "smallest": 12e-3, "mean_root": 15.49e-3}
    return {f"{quantity}_{axis}": (size, TENTH) for axis, size in sizes.items()}


A, B = ELLIPSE
BLOCK: dict[str, Any] = {"radius": 16e-3, "thickness": 12e-3}
# State of four particles a cell (with three, a tilted crater would pass without walls at the circle that halves a
# window's area) or of one, and by measurement: the size, and how far off the reading may be.
SHAPES: Mapping[str, tuple[Callable[..., Any], Mapping[str, tuple[float, float]]]] = {
    "scooped half space": (
        partial(half_block, lambda x, y, z: x**2 + y**2 + z**2 < SCOOP**2, **BLOCK),
        {
            "crater_depth": (SCOOP - _floor(1.0 / SCOOP), TENTH),
            "crater_diameter_mean_root": (2.0 * SCOOP, TENTH),
            "crater_volume": (2.0 / 3.0 * math.pi * SCOOP**3, 2.0 * math.pi * SCOOP**2 * TENTH),
        },
    ),
    "drilled ellipse of 20 x 12 mm": (
        partial(half_block, _drill, radius=20e-3, thickness=2e-3),
        _axes("hole_diameter"),
    ),
    "crater of a tilted shot": (
        partial(half_block, _tilted, **BLOCK),
        {
            # At the deepest place, and not below the middle of the mouth.
            "crater_depth": (BOWL - _floor(BOWL * (A**-2 + B**-2)), TENTH),
            **_axes("crater_diameter"),
            # The surface of the bowl is larger than that of its mouth.
            "crater_volume": (0.5 * math.pi * A * B * BOWL, math.pi * A * B * TENTH),
        },
    ),
    **samples.joined("SHAPES", {}),
}


QUICK = pytest.mark.claim("shapes", "known-shapes")
# Of seconds; craters are read about the axis in ``test_known_answers``, and in the half model in the contracts.
LONG = pytest.mark.claim("shapes", "known-shapes", minutes=0.1)


@pytest.mark.parametrize(
    "shape", [pytest.param(name, marks=LONG if "_depth" in str(SHAPES[name][1]) else QUICK) for name in SHAPES]
)
def test_shape__has_its_known_sizes(shape: str, compared: Callable[[Row], None]) -> None:
    """Craters, holes and spheres of known sizes are read to a tenth of a cell, whatever the order of particles."""
    build, sizes = SHAPES[shape]
    fine, coarse = build(), build(per_cell=1)
    shuffled = reordered(coarse)
    for name, (size, off) in sizes.items():
        compared(absolute(f"{shape}: {name} (SI)", expected=size, got=read(name, fine).value, within=off))
        expected, got = (read(name, each).value for each in (coarse, shuffled))
        compared(relative(f"{shape}: {name}, particles in another order", expected=expected, got=got, within=SAME))


# ---- views in every geometry ----------------------------------------------------------------------


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
WIDE, NARROW, ASIDE = 10e-3, 7e-3, 5e-3
AREA_DIAMETER = 2.0 * math.sqrt(WIDE * NARROW)


def test_oblique_hole__is_that_of_its_area_and_its_shape_is_no_uncertainty() -> None:
    setting, particles = plate_of_particles("half", hole=WIDE, middle=ASIDE, oval=WIDE / NARROW)
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
