"""What every measurement must do: read a drilled disc and a scooped half space, and not care who stands where."""

import dataclasses
import math
from collections.abc import Callable
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from solver.geometry import grid
from solver.geometry.axisymmetric import Axisymmetric
from solver.geometry.cartesian3d import Cartesian3D
from solver.state import Particles, Snapshot, empty_particles
from studies import measurements
from studies.measurements import RESOLUTION_IN_CELLS, Reading
from studies.measurements._view import View, view

DENSITY = 8930.0
DIAMETER = 8e-3
CELL = 0.5e-3
PARTICLE = 0.5 * CELL  # spacing
THICKNESS, RADIUS = 2e-3, 24e-3
DEPTH, BREADTH = 40e-3, 40e-3  # of the half space
HOLE = 7.3e-3  # radius of the drill, on no lattice plane
CRATER = 11.3e-3  # radius of the scoop

# An edge on a lattice is known to half a particle; a diameter has two of them.
EDGE = 0.5 * PARTICLE
ROUND_OFF = 1e-12

OPENINGS = ("hole_diameter", "hole_diameter_clear", "hole_diameter_midplane")
LENGTHS = {"m"}
RATIOS = {"1"}


def line(begin: float, end: float) -> np.ndarray:
    """Places of particles that fill begin..end from its end, so that the edge stands exactly at ``begin``."""
    count = round((end - begin) / PARTICLE)
    return begin + PARTICLE * (np.arange(count) + 0.5)


def seen(
    radius: np.ndarray, depth: np.ndarray, *, thickness: float, breadth: float, **changes: Any
) -> View:
    """A body of revolution of particles, all of it target and in one piece."""
    whole = np.ones(radius.size, bool)
    return View(
        **{
            "radius": radius,
            "depth": depth,
            "mass": DENSITY * radius * PARTICLE**2,
            "speed": np.zeros(radius.size),
            "sector": np.zeros(radius.size, np.int64),
            "sectors": 1,
            "target": whole,
            "attached": whole,
            "attached_target": whole,
            "cell": CELL,
            "radial_width": PARTICLE,
            "axial_width": PARTICLE,
            "density": DENSITY,
            "thickness": thickness,
            "target_radius": breadth,
            "projectile_diameter": DIAMETER,
            **changes,
        }
    )


def drilled_disc(hole: float) -> View:
    """A plate with a round hole: its matter begins exactly at the drill's radius."""
    points = np.meshgrid(line(hole, RADIUS), line(0.0, THICKNESS), indexing="ij")
    return seen(*(axis.ravel() for axis in points), thickness=THICKNESS, breadth=RADIUS)


def scooped_half_space(crater: float) -> View:
    """A deep block without a ball about the origin."""
    points = np.meshgrid(line(0.0, BREADTH), line(0.0, DEPTH), indexing="ij")
    radius, depth = (axis.ravel() for axis in points)
    left = np.hypot(radius, depth) > crater
    return seen(radius[left], depth[left], thickness=DEPTH, breadth=BREADTH)


def bored_half_space() -> View:
    """A deep block with a hole right through it, wider than the column about the axis."""
    points = np.meshgrid(line(HOLE, BREADTH), line(0.0, DEPTH), indexing="ij")
    return seen(*(axis.ravel() for axis in points), thickness=DEPTH, breadth=BREADTH)


def lipped_disc(hole: float, crest: float) -> View:
    """A drilled disc whose entry side carries one ring of particles, two particles above the face."""
    disc = drilled_disc(hole)
    return with_particle(disc, crest, -2.0 * PARTICLE)


def with_particle(state: View, radius: float, depth: float) -> View:
    """One more particle of the target, which touches the rest."""
    added = {
        "radius": radius,
        "depth": depth,
        "mass": DENSITY * radius * PARTICLE**2,
        "speed": 0.0,
        "sector": 0,
        "target": True,
        "attached": True,
        "attached_target": True,
    }
    arrays: dict[str, Any] = {
        name: np.append(getattr(state, name), value) for name, value in added.items()
    }
    return dataclasses.replace(state, **arrays)


def reordered(state: View) -> View:
    """The same particles in another order."""
    order = np.random.default_rng(0).permutation(state.radius.size)
    arrays: dict[str, Any] = {
        field.name: getattr(state, field.name)[order]
        for field in dataclasses.fields(state)
        if isinstance(getattr(state, field.name), np.ndarray)
    }
    return dataclasses.replace(state, **arrays)


STATES: dict[str, Callable[[], View]] = {
    "drilled": lambda: drilled_disc(HOLE),
    "undrilled": lambda: drilled_disc(0.0),
    "drilled to the rim": lambda: drilled_disc(RADIUS - 2.0 * CELL),
    "lipped": lambda: lipped_disc(HOLE, HOLE + 3.3e-3),
    "scooped": lambda: scooped_half_space(CRATER),
    "unscooped": lambda: scooped_half_space(0.0),
    "scooped to the rim": lambda: scooped_half_space(BREADTH - 2.0 * CELL),
    "bored": bored_half_space,
}


def read(name: str, state: View) -> Reading:
    return measurements.load(name).read(state)


def value(name: str, state: View) -> float:
    reading = read(name, state)
    assert reading.flags == ()
    return reading.value


@pytest.fixture(params=measurements.names())
def name(request: pytest.FixtureRequest) -> str:
    chosen: str = request.param
    return chosen


@pytest.fixture(params=list(STATES))
def state(request: pytest.FixtureRequest) -> View:
    return STATES[request.param]()


def test_measurement__states_what_it_is(name: str) -> None:
    measurement = measurements.load(name)
    assert measurement.unit in LENGTHS | RATIOS
    assert len(measurement.meaning) > 10
    assert measurement.version >= 1


def test_measurement__has_a_value_or_a_reason(name: str, state: View) -> None:
    reading = read(name, state)
    assert math.isnan(reading.value) == bool(reading.flags)


def test_measurement__has_an_uncertainty_wherever_it_has_a_value(name: str, state: View) -> None:
    reading = read(name, state)
    if not reading.flags:
        assert reading.parts["resolution"] > 0.0
        assert all(math.isfinite(part) and part >= 0.0 for part in reading.parts.values())


def test_measurement__of_a_length_is_uncertain_by_its_cell(name: str, state: View) -> None:
    reading = read(name, state)
    if not reading.flags and measurements.load(name).unit == "m":
        assert reading.parts["resolution"] == RESOLUTION_IN_CELLS * CELL


def test_measurement__does_not_depend_on_the_order_of_particles(name: str, state: View) -> None:
    one, other = read(name, state), read(name, reordered(state))
    assert one.flags == other.flags
    # Sums run in another order.
    assert math.isnan(one.value) or math.isclose(
        one.value, other.value, rel_tol=1e-10, abs_tol=1e-10 * CELL
    )


@pytest.mark.parametrize("opening", OPENINGS)
def test_opening__of_a_drilled_disc_is_the_drill(opening: str) -> None:
    assert abs(value(opening, drilled_disc(HOLE)) - 2.0 * HOLE) < 2.0 * EDGE


def test_hole_diameter__follows_the_drill_by_a_tenth_of_a_cell() -> None:
    shifts = 0.1 * CELL * np.arange(11)
    diameters = [value("hole_diameter", drilled_disc(HOLE + shift)) for shift in shifts]
    errors = np.array(diameters) - 2.0 * (HOLE + shifts)
    assert np.abs(errors).max() < 2.0 * EDGE
    # No jumps: each step of the drill is seen, to a quarter of it.
    assert np.allclose(np.diff(diameters), 0.2 * CELL, atol=0.05 * CELL)


def test_hole_diameter__is_seen_along_the_flight_through_a_conical_hole() -> None:
    """Half of the nominal areal density stands where the cone passes the middle of the plate."""
    radius, depth = (
        axis.ravel() for axis in np.meshgrid(line(0.0, RADIUS), line(0.0, THICKNESS), indexing="ij")
    )
    left = radius > HOLE + (depth - 0.5 * THICKNESS)
    cone = seen(radius[left], depth[left], thickness=THICKNESS, breadth=RADIUS)
    assert abs(value("hole_diameter", cone) - 2.0 * HOLE) < 2.0 * EDGE
    assert abs(value("hole_diameter_clear", cone) - (2.0 * HOLE - THICKNESS)) < 2.0 * CELL
    assert abs(value("hole_diameter_midplane", cone) - 2.0 * HOLE) < 2.0 * CELL


@pytest.mark.parametrize("part", [0.3, 0.6, 0.9])
def test_hole_diameter__is_not_moved_by_a_stray_particle(part: float) -> None:
    disc = drilled_disc(HOLE)
    strayed = with_particle(disc, part * HOLE, 0.5 * THICKNESS)
    assert math.isclose(
        value("hole_diameter", strayed), value("hole_diameter", disc), rel_tol=ROUND_OFF
    )


def test_hole_diameter__is_hardly_moved_by_a_stray_particle_at_the_edge() -> None:
    disc = drilled_disc(HOLE)
    strayed = with_particle(disc, HOLE - 0.6 * PARTICLE, 0.5 * THICKNESS)
    # One of the eight particles through the thickness: an eighth of a particle on each side.
    moved = value("hole_diameter", strayed) - value("hole_diameter", disc)
    assert abs(moved) < 2.0 * PARTICLE / 8.0


def test_hole_diameter_clear__stops_at_the_innermost_particle() -> None:
    strayed = with_particle(drilled_disc(HOLE), 0.6 * HOLE, 0.5 * THICKNESS)
    clear = value("hole_diameter_clear", strayed)
    assert math.isclose(clear, 1.2 * HOLE - PARTICLE, rel_tol=ROUND_OFF)


def test_hole_diameter_midplane__does_not_see_what_hangs_in_front_of_the_plate() -> None:
    strayed = with_particle(drilled_disc(HOLE), 0.6 * HOLE, -THICKNESS)
    assert value("hole_diameter_midplane", strayed) == value(
        "hole_diameter_midplane", drilled_disc(HOLE)
    )


@pytest.mark.parametrize("opening", OPENINGS)
def test_opening__of_a_whole_disc_is_not_perforated(opening: str) -> None:
    assert read(opening, drilled_disc(0.0)).flags == ("not_perforated",)


@pytest.mark.parametrize("opening", OPENINGS)
def test_opening__that_reaches_the_rim_is_not_contained(opening: str) -> None:
    assert read(opening, drilled_disc(RADIUS - 2.0 * CELL)).flags == ("not_contained",)


@pytest.mark.parametrize("opening", OPENINGS)
def test_opening__of_a_plate_that_is_gone_is_not_contained(opening: str) -> None:
    disc = drilled_disc(HOLE)
    nothing = np.zeros_like(disc.target)
    gone = dataclasses.replace(disc, attached=nothing, attached_target=nothing)
    assert read(opening, gone).flags == ("not_contained",)


@pytest.mark.parametrize("opening", OPENINGS)
def test_opening__counts_connected_plate_only(opening: str) -> None:
    """A slug in the middle of the hole that touches nothing is no plate."""
    slug = with_particle(drilled_disc(HOLE), 0.2 * HOLE, 0.5 * THICKNESS)
    slug.attached_target[-1] = slug.attached[-1] = False
    assert value(opening, slug) == value(opening, drilled_disc(HOLE))


def test_lip__is_the_crest_on_the_entry_side() -> None:
    crest = HOLE + 3.3e-3
    lip = value("hole_diameter_lip", lipped_disc(HOLE, crest))
    assert math.isclose(lip, 2.0 * crest, rel_tol=ROUND_OFF)


def test_lip__of_a_flat_disc_is_none() -> None:
    assert read("hole_diameter_lip", drilled_disc(HOLE)).flags == ("no_lip",)


def test_lip__is_sought_near_the_hole_only() -> None:
    far = HOLE + 0.6 * DIAMETER
    assert read("hole_diameter_lip", lipped_disc(HOLE, far)).flags == ("no_lip",)


def test_crater_depth__of_a_hemisphere_is_its_radius() -> None:
    depth = value("crater_depth", scooped_half_space(CRATER))
    # The floor of the column is a cap: half of its area lies above a - c^2 / 4 a.
    cap = (0.25 * DIAMETER) ** 2 / (4.0 * CRATER)
    assert abs(depth - (CRATER - cap)) < PARTICLE


def test_crater_diameter__of_a_hemisphere_is_twice_its_radius() -> None:
    diameter = value("crater_diameter", scooped_half_space(CRATER))
    assert abs(diameter - 2.0 * CRATER) < 2.0 * PARTICLE


def test_crater_shape__of_a_hemisphere_is_one_half() -> None:
    ratio = value("crater_depth_over_diameter", scooped_half_space(CRATER))
    assert abs(ratio - 0.5) < PARTICLE / CRATER


@pytest.mark.parametrize("crater", ["crater_depth", "crater_diameter"])
def test_crater__grows_with_the_scoop(crater: str) -> None:
    """Lattice points leave one by one, so the reading follows a tenth of a cell to within a particle."""
    sizes = CRATER + 0.1 * CELL * np.arange(11)
    readings = [value(crater, scooped_half_space(float(size))) for size in sizes]
    factor = 2.0 if crater == "crater_diameter" else 1.0
    assert np.abs(np.array(readings) / factor - sizes).max() < 2.0 * PARTICLE
    assert readings[-1] > readings[0]


def test_crater_depth__of_an_untouched_block_is_nothing() -> None:
    assert abs(value("crater_depth", scooped_half_space(0.0))) < PARTICLE


def test_crater_depth__without_a_floor_is_perforated() -> None:
    assert read("crater_depth", bored_half_space()).flags == ("perforated",)


def test_crater_shape__without_a_floor_says_why() -> None:
    reading = read("crater_depth_over_diameter", bored_half_space())
    assert math.isnan(reading.value)
    assert reading.flags == ("perforated",)


def test_crater_diameter__of_an_untouched_block_is_no_crater() -> None:
    assert read("crater_diameter", scooped_half_space(0.0)).flags == ("no_crater",)


def test_crater_diameter__that_reaches_the_rim_is_not_contained() -> None:
    rim = scooped_half_space(BREADTH - 2.0 * CELL)
    assert read("crater_diameter", rim).flags == ("not_contained",)


@pytest.mark.parametrize("crater", ["crater_depth", "crater_diameter"])
def test_crater__is_not_moved_by_a_stray_particle(crater: str) -> None:
    block = scooped_half_space(CRATER)
    strayed = with_particle(block, 0.1 * CRATER, 0.4 * CRATER)
    assert math.isclose(value(crater, strayed), value(crater, block), rel_tol=ROUND_OFF)


# From arrays of the solver, through ``view``


def plate(kind: str, *, hole: float = HOLE, slug: float = 0.0) -> View:
    """A drilled plate, with a free slug within a radius, as a geometry shows it."""
    setting, particles = plate_of_particles(kind, hole=hole, slug=slug)
    return view(setting, snapshot_of(particles))


def plate_of_particles(
    kind: str, *, hole: float = HOLE, slug: float = 0.0
) -> tuple[Any, Particles]:
    """What ``view`` asks a setting for, and the particles."""
    flat = kind == "axisymmetric"
    cells = round(RADIUS / CELL)
    deep = round(THICKNESS / CELL) + 8
    across, along = line(0.0, RADIUS), line(0.0, THICKNESS)
    lines = (across, along, np.zeros(1)) if flat else (across, across, along)
    position = np.stack([axis.ravel() for axis in np.meshgrid(*lines, indexing="ij")], axis=-1)
    from_axis = position[:, 0] if flat else np.hypot(position[:, 0], position[:, 1])
    position = position[(from_axis > hole) | (from_axis < slug)]
    measure = position[:, 0] * PARTICLE**2 if flat else PARTICLE**3
    particles = empty_particles(len(position))
    particles.position[:] = position
    particles.mass[:] = DENSITY * measure
    lower = (0.0, -4.0 * CELL, 0.0) if flat else (0.0, 0.0, -4.0 * CELL)
    record = Axisymmetric if flat else Cartesian3D
    extent = (cells, deep, 0) if flat else (cells, cells, deep)
    width = (PARTICLE,) * 3
    body = SimpleNamespace(name="target", density=DENSITY, spacing=width)
    setting = SimpleNamespace(
        problem=SimpleNamespace(
            geometry=grid(record, lower=lower, cells=extent, spacing=CELL), bodies=(body,)
        ),
        target="target",
        projectile_diameter=DIAMETER,
        thickness=THICKNESS,
        radius=RADIUS,
        sector=1.0 if flat else 0.5 * math.pi,
    )
    return setting, particles


def snapshot_of(particles: Particles) -> Snapshot:
    return Snapshot(0.0, 0, particles, np.zeros(particles.mass.size, np.int64))


@pytest.mark.parametrize("opening", OPENINGS)
def test_opening__is_the_same_in_a_quarter_and_about_the_axis(opening: str) -> None:
    flat, quarter = (value(opening, plate(kind)) for kind in ("axisymmetric", "quarter"))
    assert abs(flat - quarter) < 0.5 * CELL
    assert abs(flat - 2.0 * HOLE) < 2.0 * PARTICLE


def test_quarter__is_measured_in_sectors_whose_scatter_is_a_part_of_the_uncertainty() -> None:
    quarter = plate("quarter")
    assert quarter.sectors == 9
    azimuth = read("hole_diameter", quarter).parts["azimuth"]
    assert 0.0 < azimuth < CELL
    assert read("hole_diameter", plate("axisymmetric")).parts["azimuth"] == 0.0


@pytest.mark.parametrize("kind", ["axisymmetric", "quarter"])
def test_view__weighs_each_sector_per_radian(kind: str) -> None:
    state = plate(kind, hole=0.0)
    # A square plate in three dimensions: only what lies within the round one compares.
    inside = state.radius < RADIUS - CELL
    sums = np.bincount(state.sector[inside], state.mass[inside])
    expected = 0.5 * DENSITY * THICKNESS * (RADIUS - CELL) ** 2
    assert sums.mean() == pytest.approx(expected, rel=0.02)


@pytest.mark.parametrize("kind", ["axisymmetric", "quarter"])
def test_view__tells_a_slug_in_the_hole_from_the_plate(kind: str) -> None:
    state = plate(kind, slug=2e-3)
    assert state.attached_target.tolist() == (state.radius > HOLE).tolist()
    assert value("hole_diameter", state) == value("hole_diameter", plate(kind))


@pytest.mark.parametrize(("free_cells", "touching"), [(0, True), (1, False)])
def test_view__takes_neighbouring_cells_for_contact_and_no_others(
    free_cells: int, touching: bool
) -> None:
    edge = (math.floor(HOLE / CELL) - free_cells) * CELL  # where the last cell of the slug ends
    state = plate("axisymmetric", slug=edge)
    assert state.attached_target.all() == touching


def test_view__leaves_out_what_has_left_the_grid() -> None:
    setting, particles = plate_of_particles("axisymmetric")
    particles.alive[:7] = 0
    state = view(setting, snapshot_of(particles))
    assert state.radius.size == particles.mass.size - 7
    assert np.array_equal(state.depth, particles.position[7:, 1])


def test_view__tells_plate_from_projectile() -> None:
    """What fills the hole and is no plate joins the matter, but not the plate, to the rim."""
    setting, particles = plate_of_particles("axisymmetric", slug=HOLE)
    projectile = SimpleNamespace(name="projectile", density=DENSITY, spacing=(PARTICLE,) * 3)
    setting.problem.bodies = (projectile, *setting.problem.bodies)
    body = (particles.position[:, 0] > HOLE).astype(np.int64)
    state = view(setting, Snapshot(0.0, 0, particles, body))
    assert state.attached.all()
    assert np.array_equal(state.attached_target, body == 1)
    assert value("hole_diameter", state) == value("hole_diameter", plate("axisymmetric"))
