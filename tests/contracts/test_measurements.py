"""What every measurement must do: read a state with a known answer, and not care who stands where.

A drilled disc and a scooped half space for impacts, a stretched bar, two plates with a step of pressure; histories of
pushes and fronts for what no single state shows.
"""

import dataclasses
import math
from collections.abc import Callable
from types import SimpleNamespace
from typing import Any, get_type_hints

import numpy as np
import pytest

from solver.eos.linear_elastic import LinearElastic
from solver.geometry import grid
from solver.geometry.axisymmetric import Axisymmetric
from solver.geometry.cartesian3d import Cartesian3D
from solver.state import Particles, Snapshot, empty_table, views
from studies import measurements
from studies.measurements import RESOLUTION_IN_CELLS, History, Reading
from studies.measurements._bar import BarView
from studies.measurements._bar import view as view_of_bar
from studies.measurements._plates import FLYER, TARGET, PlateView
from studies.measurements._plates import view as view_of_plates
from studies.measurements._push import MOMENTUM
from studies.measurements._view import View, azimuthal_spread, view

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
UNITS = {"m", "s", "1", "Pa", "m s-1", "kg m-3"}


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
            "target_mass": float((DENSITY * radius * PARTICLE**2).sum()),
            "target_radius": breadth,
            "back_absorbs": False,
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


def cratered(wall: Callable[[float], float], floor: float) -> View:
    """A deep block without a crater: each layer of particles begins exactly at the wall of its depth."""
    depths = line(0.0, DEPTH)
    rows = [line(wall(z) if z < floor else 0.0, BREADTH) for z in depths]
    depth = np.concatenate([np.full(row.size, z) for row, z in zip(rows, depths, strict=True)])
    return seen(np.concatenate(rows), depth, thickness=DEPTH, breadth=BREADTH)


def bored_half_space() -> View:
    """A deep block with a hole right through it, wider than the column about the axis."""
    points = np.meshgrid(line(HOLE, BREADTH), line(0.0, DEPTH), indexing="ij")
    return seen(*(axis.ravel() for axis in points), thickness=DEPTH, breadth=BREADTH)


def dented_disc(left: float, *, stretch: float = 1.0) -> View:
    """A plate of which a share is left where the hole would be, on its exit side and drawn out in both directions."""
    disc = drilled_disc(HOLE)
    gone = (1.0 - left) * THICKNESS
    floor = np.meshgrid(line(0.0, HOLE / stretch), line(gone, THICKNESS), indexing="ij")
    radius, depth = (axis.ravel() for axis in floor)
    state = seen(
        np.append(disc.radius, stretch * radius),
        np.append(disc.depth, depth),
        thickness=THICKNESS,
        breadth=RADIUS,
    )
    mass = np.append(disc.mass, DENSITY * radius * PARTICLE**2)
    return dataclasses.replace(state, mass=mass)


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


def reordered(state: Any) -> Any:
    """The same particles in another order."""
    order = np.random.default_rng(0).permutation(state.mass.size)
    arrays: dict[str, Any] = {
        field.name: getattr(state, field.name)[order]
        for field in dataclasses.fields(state)
        if isinstance(getattr(state, field.name), np.ndarray)
    }
    return dataclasses.replace(state, **arrays)


def hollowed_half_space(crater: float, *, roof: float, height: float) -> View:
    """A scooped half space with a void, as spall leaves it, a ``roof`` below the floor."""
    block = scooped_half_space(crater)
    void = (block.radius < 2.0 * DIAMETER) & (block.depth > crater + roof)
    return without(block, void & (block.depth < crater + roof + height))


def without(state: Any, gone: np.ndarray) -> Any:
    """The particles that are not gone."""
    arrays: dict[str, Any] = {
        field.name: getattr(state, field.name)[~gone]
        for field in dataclasses.fields(state)
        if isinstance(getattr(state, field.name), np.ndarray)
    }
    return dataclasses.replace(state, **arrays)


# Bars

BAR_LENGTH, BAR_DIAMETER, BAR_SPEED = 20e-3, 8e-3, 100.0
BULK, SHEAR = 130e9, 40e9  # Pa
Shape = Callable[[np.ndarray], np.ndarray]


def straight(points: np.ndarray) -> np.ndarray:
    return points


def stretched(points: np.ndarray) -> np.ndarray:
    """Shorter by a third, thicker by a fifth, a tenth of a cell above the wall."""
    return points * (1.2, 1.2, 2.0 / 3.0) + (0.0, 0.0, 0.1 * CELL)


def flared(points: np.ndarray) -> np.ndarray:
    """Wider by half at the wall, as it was at the rear, straight in between."""
    widening = 1.0 + 0.5 * (1.0 - points[:, 2:] / BAR_LENGTH)
    return points * np.concatenate([widening, widening, np.ones_like(widening)], axis=1)


def bar(
    shape: Shape = straight,
    *,
    round_model: bool = False,
    velocity: tuple[float, float, float] = (0.0, 0.0, -BAR_SPEED),
    **changes: Any,
) -> BarView:
    """A round bar, deformed; a quarter in three dimensions, or a body of revolution."""
    across, along = line(0.0, 0.5 * BAR_DIAMETER), line(0.0, BAR_LENGTH)
    lines = (across, np.zeros(1) if round_model else across, along)
    places = [np.arange(axis.size) for axis in lines]
    place, points = (
        np.stack([axis.ravel() for axis in np.meshgrid(*grid, indexing="ij")], axis=-1)
        for grid in (places, lines)
    )
    inside = np.hypot(points[:, 0], points[:, 1]) < 0.5 * BAR_DIAMETER
    points, place = points[inside], place[inside]
    mass = DENSITY * (
        points[:, 0] * PARTICLE**2 if round_model else np.full(len(points), PARTICLE**3)
    )
    return BarView(
        **{
            "place": place,
            "position": shape(points),
            "velocity": np.tile(velocity, (len(points), 1)),
            "mass": mass,
            "strain_energy": np.zeros(len(points)),
            "width": PARTICLE,
            "cell": CELL,
            "length": BAR_LENGTH,
            "diameter": BAR_DIAMETER,
            "speed": BAR_SPEED,
            "references": (BAR_LENGTH, BAR_DIAMETER, BAR_DIAMETER),
            **changes,
        }
    )


def bar_of_arrays(kind: str) -> tuple[Any, Particles]:
    """What ``view`` asks a setting of a bar for, and the particles in their first places."""
    flat = kind == "round"
    seen = bar(round_model=flat)
    order = [0, 2, 1] if flat else [0, 1, 2]
    particles = views(empty_table(len(seen.mass)))
    particles.position[:] = seen.position[:, order]
    particles.velocity[:, order.index(2)] = -BAR_SPEED
    particles.mass[:] = seen.mass
    particles.density[:] = DENSITY
    matter = SimpleNamespace(
        eos=LinearElastic(density=DENSITY, bulk_modulus=BULK, temperature=293.0),
        shear_modulus=SHEAR,
    )
    body = SimpleNamespace(
        name="bar", density=DENSITY, spacing=(PARTICLE,) * 3, mass=seen.mass, matter=matter
    )
    record = Axisymmetric if flat else Cartesian3D
    cells = (10, 50, 0) if flat else (10, 10, 50)
    setting = SimpleNamespace(
        problem=SimpleNamespace(
            geometry=grid(record, lower=(0.0,) * 3, cells=cells, spacing=CELL), bodies=(body,)
        ),
        length=BAR_LENGTH,
        diameter=BAR_DIAMETER,
        speed=BAR_SPEED,
        place=seen.place,
        references=(None, None, None),
    )
    return setting, particles


def short_bar() -> BarView:
    """What is left of a bar that lost the rows on which its edges are read."""
    whole = bar()
    return without(whole, whole.place[:, 0] == whole.place[:, 0].max())


# Plates

PLATE = 40.0 * CELL  # thickness
PLATE_SPEED, PRESSURE, SHOCKED = 2000.0, 48e9, 1.25  # m/s, Pa, compression behind the shock
SHOCK = (
    5.0 * 0.5 * PLATE_SPEED
)  # m/s: mass behind a shock that stops at half the speed and compresses so


def plates(time: float, *, scatter: float = 0.0) -> PlateView:
    """Two plates of one material at a time after they met: steps of pressure, velocity and density, no smear.

    ``scatter`` is the relative standard deviation of pressure that neighbours share out evenly.
    """
    layers = line(0.0, PLATE)
    half = 0.5 * PLATE_SPEED
    reach = SHOCK * time  # of undisturbed matter, from the impact face
    behind = layers < reach
    # From the interface, which moves on at half the speed: compressed behind the front, undisturbed before it.
    distance = np.where(behind, layers / SHOCKED, layers - half * time)
    sign = np.where(np.arange(layers.size) % 2, 1.0, -1.0)
    pressure = np.where(behind, PRESSURE * (1.0 + scatter * sign), 0.0)
    count = layers.size
    velocity = np.where(behind, half, 0.0)
    return PlateView(
        body=np.repeat([FLYER, TARGET], count),
        layer=np.tile(np.arange(count), 2),
        place=half * time + np.concatenate([-distance, distance]),
        velocity=np.concatenate([np.where(behind, half, PLATE_SPEED), velocity]),
        mass=np.full(2 * count, DENSITY * CELL**2 * PARTICLE),
        density=np.tile(np.where(behind, SHOCKED * DENSITY, DENSITY), 2),
        pressure=np.tile(pressure, 2),
        section=CELL**2,
        cell=CELL,
        time=time,
        speed=PLATE_SPEED,
    )


LATE = 0.8 * PLATE / SHOCK  # the shock has run through 0.8 of each plate

# Histories


def pushed(rates: np.ndarray, interval: float = 1e-8) -> History:
    """A bar that is pushed at some rates (shares of its momentum per second), one in each interval."""
    times = interval * np.arange(rates.size + 1)
    momentum = -1.0 + np.concatenate([[0.0], np.cumsum(rates * interval)])
    return History(times, {MOMENTUM: momentum})


def rectangle(contact: float, end: float = 2e-6, interval: float = 1e-8) -> np.ndarray:
    """A constant push that turns the momentum round within a contact time, and then none."""
    times = interval * np.arange(round(end / interval) + 1)
    return np.diff(np.clip(times / contact, 0.0, 1.0)) * 2.0 / interval


def running(name: str, speed: float, *, known: int = 21) -> History:
    """A front that runs evenly, of which the last ``known`` of 21 observations have a place."""
    times = 1e-7 * np.arange(21.0)
    path = np.where(np.arange(21) >= 21 - known, speed * times, math.nan)
    return History(times, {f"{plate}_shock_front": path for plate in ("flyer", "target")})


def smeared(rates: np.ndarray) -> np.ndarray:
    """The same push from the first touch on, its end smeared evenly over 20 intervals."""
    return np.convolve(np.pad(rates, 10, mode="edge"), np.full(21, 1.0 / 21.0), mode="valid")


# By what a measurement looks at.
STATES: dict[type, dict[str, Callable[[], Any]]] = {
    View: {
        "drilled": lambda: drilled_disc(HOLE),
        "undrilled": lambda: drilled_disc(0.0),
        "drilled to the rim": lambda: drilled_disc(RADIUS - 2.0 * CELL),
        "lipped": lambda: lipped_disc(HOLE, HOLE + 3.3e-3),
        "lipped far out": lambda: lipped_disc(HOLE, HOLE + DIAMETER - 0.5 * CELL),
        "dented": lambda: dented_disc(0.375),
        "filmed": lambda: dented_disc(0.125),
        "scooped": lambda: scooped_half_space(CRATER),
        "unscooped": lambda: scooped_half_space(0.0),
        "scooped to the rim": lambda: scooped_half_space(BREADTH - 2.0 * CELL),
        "bored": bored_half_space,
        "spalled": lambda: hollowed_half_space(CRATER, roof=2e-3, height=2e-3),
    },
    BarView: {
        "straight": bar,
        "stretched": lambda: bar(stretched),
        "flared": lambda: bar(flared),
        "round": lambda: bar(flared, round_model=True),
        "short of rows": short_bar,
        "without references": lambda: bar(references=(None, None, None)),
    },
    PlateView: {
        "before the touch": lambda: plates(0.0),
        "just met": lambda: plates(0.1 * LATE),
        "shocked": lambda: plates(LATE),
        "scattered": lambda: plates(LATE, scatter=0.05),
        "through": lambda: plates(1.3 * PLATE / SHOCK),
    },
    History: {
        "nothing yet": lambda: joined(pushed(np.zeros(0)), running("", 0.0, known=0)),
        "rebound": lambda: joined(pushed(rectangle(1.2e-6)), running("", SHOCK)),
        "in contact": lambda: joined(pushed(rectangle(4e-6)), running("", SHOCK, known=2)),
        "never touched": lambda: joined(pushed(np.zeros(200)), running("", SHOCK)),
    },
}


def joined(push: History, front: History) -> History:
    """Everything that any measurement follows; the two do not belong to one run, so neither do their lengths."""
    size = min(push.times.size, front.times.size)
    values = {**push.values, **front.values}
    return History(front.times[:size], {name: one[:size] for name, one in values.items()})


def looks_at(name: str) -> type:
    """What the reading function of a measurement takes."""
    hints = get_type_hints(measurements.load(name).read)
    (kind,) = (hint for argument, hint in hints.items() if argument != "return")
    chosen: type = kind
    return chosen


def read(name: str, state: Any) -> Reading:
    return measurements.load(name).read(state)


def value(name: str, state: Any) -> float:
    reading = read(name, state)
    assert reading.flags == ()
    return reading.value


@pytest.fixture(params=measurements.names())
def name(request: pytest.FixtureRequest) -> str:
    chosen: str = request.param
    return chosen


PAIRS = [(name, state) for name in measurements.names() for state in STATES[looks_at(name)]]


@pytest.fixture(params=PAIRS, ids=lambda pair: "-".join(pair))
def pair(request: pytest.FixtureRequest) -> tuple[str, Any]:
    name, state = request.param
    return name, STATES[looks_at(name)][state]()


def test_measurement__states_what_it_is(name: str) -> None:
    measurement = measurements.load(name)
    assert measurement.unit in UNITS
    assert len(measurement.meaning) > 10
    assert measurement.version >= 1


def test_measurement__looks_at_a_history_where_it_follows_others(name: str) -> None:
    measurement = measurements.load(name)
    assert (looks_at(name) is History) == bool(measurement.follows)
    assert not any(measurements.load(one).follows for one in measurement.follows)


def test_measurement__has_a_value_or_a_reason(pair: tuple[str, Any]) -> None:
    """Or both: a value may be in doubt."""
    reading = read(*pair)
    assert math.isfinite(reading.value) or reading.flags


def test_measurement__has_parts_of_uncertainty_that_are_numbers(pair: tuple[str, Any]) -> None:
    reading = read(*pair)
    if math.isfinite(reading.value):
        assert all(math.isfinite(part) and part >= 0.0 for part in reading.parts.values())


def test_measurement__of_a_length_is_uncertain_by_its_cell(pair: tuple[str, Any]) -> None:
    reading = read(*pair)
    if math.isfinite(reading.value) and measurements.load(pair[0]).unit == "m":
        assert reading.parts["resolution"] == RESOLUTION_IN_CELLS * CELL


def test_measurement__does_not_depend_on_the_order_of_particles(pair: tuple[str, Any]) -> None:
    name, state = pair
    if isinstance(state, History):
        return
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
@pytest.mark.parametrize("left", [0.375, 0.5, 0.875])
def test_opening__of_a_dented_disc_is_not_perforated(opening: str, left: float) -> None:
    reading = read(opening, dented_disc(left))
    assert math.isnan(reading.value)
    assert reading.flags == ("not_perforated",)


@pytest.mark.parametrize("opening", ["hole_diameter", "hole_diameter_midplane"])
def test_opening__behind_a_film_keeps_its_value_and_says_so(opening: str) -> None:
    reading = read(opening, dented_disc(0.125))
    assert reading.flags == ("closed_on_axis",)
    assert abs(reading.value - 2.0 * HOLE) < 2.0 * EDGE
    assert read("hole_diameter_clear", dented_disc(0.125)).flags == ("not_perforated",)


@pytest.mark.parametrize(
    ("stretch", "flag"), [(1.9, "not_perforated"), (2.1, "closed_on_axis"), (2.9, "closed_on_axis")]
)
def test_opening__is_a_hole_once_the_plate_has_been_drawn_to_a_quarter(
    stretch: float, flag: str
) -> None:
    assert read("hole_diameter", dented_disc(1.0, stretch=stretch)).flags == (flag,)


@pytest.mark.parametrize("opening", OPENINGS)
def test_opening__that_reaches_the_rim_is_not_contained(opening: str) -> None:
    assert read(opening, drilled_disc(RADIUS - 2.0 * CELL)).flags == ("not_contained",)


@pytest.mark.parametrize("opening", OPENINGS)
@pytest.mark.parametrize(("share", "flags"), [(0.49, ()), (0.51, ("near_rim",))])
def test_opening__wider_than_half_of_its_plate_says_so(
    opening: str, share: float, flags: tuple[str, ...]
) -> None:
    assert read(opening, drilled_disc(share * RADIUS)).flags == flags


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
    far = HOLE + 1.1 * DIAMETER
    assert read("hole_diameter_lip", lipped_disc(HOLE, far)).flags == ("no_lip",)


@pytest.mark.parametrize(("before_end", "flags"), [(0.5, ("lip_at_window",)), (1.5, ())])
def test_lip__at_the_end_of_the_window_says_so(before_end: float, flags: tuple[str, ...]) -> None:
    crest = HOLE + DIAMETER - before_end * CELL
    reading = read("hole_diameter_lip", lipped_disc(HOLE, crest))
    assert math.isclose(reading.value, 2.0 * crest, rel_tol=ROUND_OFF)
    assert reading.flags == flags


def test_crater_depth__of_a_hemisphere_is_its_radius() -> None:
    depth = value("crater_depth", scooped_half_space(CRATER))
    # The floor of the column is a cap: half of its area lies above a - c^2 / 4 a.
    cap = (0.25 * DIAMETER) ** 2 / (4.0 * CRATER)
    assert abs(depth - (CRATER - cap)) < PARTICLE


def test_crater_diameter__of_a_hemisphere_is_twice_its_radius() -> None:
    diameter = value("crater_diameter", scooped_half_space(CRATER))
    assert abs(diameter - 2.0 * CRATER) < 2.0 * PARTICLE


# Walls by depth: radius at the surface and depth of the floor are those of the scoop.
WALLS: dict[str, Callable[[float], float]] = {
    "cylinder": lambda z: CRATER,
    "hemisphere": lambda z: math.sqrt(CRATER**2 - z**2),
    "paraboloid": lambda z: CRATER * math.sqrt(1.0 - z / CRATER),
    "cone": lambda z: CRATER - 0.5 * z,
    "undercut": lambda z: CRATER + 0.3 * z,
}
TENTH = 0.1 * CELL


@pytest.mark.parametrize("shape", WALLS)
def test_crater_diameter__is_that_of_the_wall_at_the_surface_to_a_tenth_of_a_cell(
    shape: str,
) -> None:
    diameter = value("crater_diameter", cratered(WALLS[shape], CRATER))
    assert abs(diameter - 2.0 * CRATER) < 2.0 * TENTH


@pytest.mark.parametrize("share", [0.3, 0.5, 0.8])  # depth over radius
def test_crater_diameter__of_a_spherical_cap_is_that_at_the_surface(share: float) -> None:
    depth = share * CRATER
    sphere = (CRATER**2 + depth**2) / (2.0 * depth)

    def wall(z: float) -> float:
        return math.sqrt(sphere**2 - (z + sphere - depth) ** 2)

    assert abs(value("crater_diameter", cratered(wall, depth)) - 2.0 * CRATER) < 2.0 * TENTH


@pytest.mark.parametrize("cells", [3.0, 5.0, 7.0])
def test_crater_diameter__of_a_shallow_crater_does_not_see_its_floor(cells: float) -> None:
    shallow = cratered(WALLS["cylinder"], cells * CELL)
    assert abs(value("crater_diameter", shallow) - 2.0 * CRATER) < 2.0 * TENTH


def without_ring(block: View, begin: float, *, below: float) -> View:
    """The block without a ring of one cell, from the surface to a depth."""
    ring = (block.radius > begin) & (block.radius < begin + CELL) & (block.depth < below)
    return without(block, ring)


@pytest.mark.parametrize("skin", [1.5, 2.0, 4.0])  # cells of wall before the gap
@pytest.mark.parametrize("below", [1.0, 2.0, 4.0])  # cells
def test_crater_diameter__is_not_moved_by_a_gap_of_a_cell_in_the_wall(
    skin: float, below: float
) -> None:
    block = cratered(WALLS["cylinder"], CRATER)
    torn = without_ring(block, CRATER + skin * CELL, below=below * CELL)
    assert abs(value("crater_diameter", torn) - 2.0 * CRATER) < 2.0 * TENTH


@pytest.mark.parametrize("lean", [-1.0, 0.0, 1.0])  # of the lip's height, outwards
def test_crater_diameter__is_not_moved_by_a_lip(lean: float) -> None:
    block = cratered(WALLS["hemisphere"], CRATER)
    lipped = block
    for height in PARTICLE * (np.arange(8) + 0.5):
        for radius in line(CRATER + lean * height, CRATER + lean * height + 4.0 * PARTICLE):
            lipped = with_particle(lipped, float(radius), -float(height))
    assert value("crater_diameter", lipped) == value("crater_diameter", block)


def test_crater_diameter__is_not_moved_by_loose_matter_in_the_crater() -> None:
    """A fifth of the crater's room is filled with single particles that still touch the wall."""
    block = cratered(WALLS["hemisphere"], CRATER)
    random = np.random.default_rng(1)
    loose = block
    for radius in line(PARTICLE, CRATER - 2.0 * CELL):
        for depth in line(0.0, 4.0 * CELL):
            if random.random() < 0.2:
                loose = with_particle(loose, float(radius), float(depth))
    moved = value("crater_diameter", loose) - value("crater_diameter", block)
    assert abs(moved) < 2.0 * TENTH


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


@pytest.mark.parametrize(
    ("crater", "absorbs", "flags"),
    [(0.30, False, ()), (0.37, False, ("near_back",)), (0.37, True, ())],
)
def test_crater_depth__near_a_back_that_reflects_says_so(
    crater: float, absorbs: bool, flags: tuple[str, ...]
) -> None:
    block = dataclasses.replace(scooped_half_space(crater * DEPTH), back_absorbs=absorbs)
    reading = read("crater_depth", block)
    assert math.isfinite(reading.value)
    assert reading.flags == flags
    assert read("crater_depth_over_diameter", block).flags == flags


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


def test_crater_depth__ends_at_the_floor_and_not_at_a_void_below_it() -> None:
    whole = value("crater_depth", scooped_half_space(CRATER))
    spalled = value("crater_depth", hollowed_half_space(CRATER, roof=2e-3, height=2e-3))
    assert math.isclose(spalled, whole, rel_tol=ROUND_OFF)


def test_crater_depth__is_not_moved_by_a_thin_veil_in_front_of_the_floor() -> None:
    """A layer of a quarter of the nominal density."""
    block = scooped_half_space(CRATER)
    depth = 0.5 * CRATER + PARTICLE * np.arange(2)
    veil = block
    for radius in line(0.0, 0.25 * DIAMETER)[::4]:
        for place in depth:
            veil = with_particle(veil, float(radius), float(place))
    assert math.isclose(
        value("crater_depth", veil), value("crater_depth", block), rel_tol=ROUND_OFF
    )


@pytest.mark.parametrize("crater", ["crater_depth", "crater_diameter"])
def test_crater__is_not_moved_by_a_stray_particle(crater: str) -> None:
    block = scooped_half_space(CRATER)
    strayed = with_particle(block, 0.1 * CRATER, 0.4 * CRATER)
    assert math.isclose(value(crater, strayed), value(crater, block), rel_tol=ROUND_OFF)


# Bars


@pytest.mark.parametrize("round_model", [False, True])
@pytest.mark.parametrize(
    ("shape", "length", "mushroom"),
    [(straight, 1.0, 1.0), (stretched, 2.0 / 3.0, 1.2), (flared, 1.0, None)],
)
def test_bar__has_the_length_and_diameter_that_it_was_stretched_to(
    shape: Shape, length: float, mushroom: float | None, round_model: bool
) -> None:
    """Exactly: an edge is half of the stretched particle beyond its centre."""
    seen = bar(shape, round_model=round_model)
    assert math.isclose(value("final_length", seen), length * BAR_LENGTH, rel_tol=ROUND_OFF)
    # The lowest layer of the flared bar stands half a particle above its foot.
    widest = mushroom or 1.5 - 0.25 * PARTICLE / BAR_LENGTH
    assert math.isclose(value("mushroom_diameter", seen), widest * BAR_DIAMETER, rel_tol=ROUND_OFF)


@pytest.mark.parametrize("round_model", [False, True])
def test_bar__is_as_wide_at_a_fifth_of_its_length_as_the_cone_is_there(round_model: bool) -> None:
    expected = (1.0 + 0.5 * (1.0 - 0.2)) * BAR_DIAMETER
    seen = bar(flared, round_model=round_model)
    assert math.isclose(value("width_at_fifth", seen), expected, rel_tol=ROUND_OFF)


def test_bar__that_is_shorter_than_a_fifth_has_no_width_there() -> None:
    squashed = bar(lambda points: points * (1.0, 1.0, 0.15))
    assert read("width_at_fifth", squashed).flags == ("too_short",)


@pytest.mark.parametrize("name", ["final_length", "mushroom_diameter", "width_at_fifth"])
def test_bar__that_lost_particles_of_its_edges_says_so(name: str) -> None:
    whole = bar()
    last = whole.place.max(axis=0)
    lost = without(whole, (whole.place[:, 1] == 0) & (whole.place[:, 2] == last[2]))
    assert read(name, lost).flags == ("lost_particles",)


def test_taylor_error__is_the_mean_of_three_relative_errors() -> None:
    seen = bar(references=(0.9 * BAR_LENGTH, 1.25 * BAR_DIAMETER, 0.8 * BAR_DIAMETER))
    expected = (0.1 / 0.9 + 0.25 / 1.25 + 0.2 / 0.8) / 3.0
    assert math.isclose(value("taylor_error", seen), expected, rel_tol=1e-9)


def test_taylor_error__reproduces_what_the_thesis_prints() -> None:
    """Ma (2005), Table 2.2, finite elements: 16.3, 13.4 and 10.0 mm against 16.2, 13.5 and 10.1 mm are 0.008."""
    ratios = (16.2 / 16.3, 13.5 / 13.4, 10.1 / 10.0)
    sizes = (BAR_LENGTH, BAR_DIAMETER, BAR_DIAMETER)
    seen = bar(references=tuple(s * r for s, r in zip(sizes, ratios, strict=True)))
    assert round(value("taylor_error", seen), 3) == 0.008


def test_taylor_error__without_a_reference_is_none() -> None:
    seen = bar(references=(BAR_LENGTH, None, BAR_DIAMETER))
    assert read("taylor_error", seen).flags == ("no_reference",)


def test_energy__of_a_bar_in_flight_is_that_of_rigid_motion() -> None:
    assert math.isclose(value("rigid_energy", bar()), 1.0, rel_tol=ROUND_OFF)
    assert abs(value("vibration_energy", bar())) < ROUND_OFF
    assert value("strain_energy", bar()) == 0.0
    assert abs(value("lost_energy", bar())) < ROUND_OFF
    assert math.isclose(value("rebound_momentum", bar()), -1.0, rel_tol=ROUND_OFF)


def test_energy__of_halves_that_part_is_that_of_vibration() -> None:
    seen = bar()
    seen.velocity[seen.place[:, 2] >= seen.place[:, 2].max() / 2.0, 2] *= -1.0
    assert abs(value("rigid_energy", seen)) < ROUND_OFF
    assert math.isclose(value("vibration_energy", seen), 1.0, rel_tol=ROUND_OFF)


def test_energy__of_a_bar_that_swells_is_that_of_vibration() -> None:
    seen = bar(velocity=(30.0, 40.0, 0.0))
    assert value("rigid_energy", seen) == 0.0
    assert math.isclose(value("vibration_energy", seen), 0.25, rel_tol=ROUND_OFF)


def test_energy__that_is_neither_motion_nor_strain_is_lost() -> None:
    half = bar(velocity=(0.0, 0.0, 0.5 * BAR_SPEED))
    half.strain_energy[:] = 0.1 * BAR_SPEED**2
    assert math.isclose(value("strain_energy", half), 0.2, rel_tol=ROUND_OFF)
    assert math.isclose(value("lost_energy", half), 1.0 - 0.25 - 0.2, rel_tol=1e-9)
    assert math.isclose(value("rebound_momentum", half), 0.5, rel_tol=ROUND_OFF)


@pytest.mark.parametrize("contact", [0.5e-6, 1.234e-6])
def test_contact_time__of_a_constant_push_is_its_length(contact: float) -> None:
    found = value("contact_time", pushed(rectangle(contact)))
    assert abs(found - contact) <= 0.5e-8  # half of the time between observations


def test_contact_time__is_not_moved_by_a_push_whose_end_is_smeared() -> None:
    found = value("contact_time", pushed(smeared(rectangle(1.2e-6))))
    assert abs(found - 1.2e-6) <= 1e-8


def test_contact_time__is_not_moved_by_noise_on_the_push() -> None:
    rates = rectangle(1.2e-6)
    noise = np.where(np.arange(rates.size) % 2, 1.9, 0.1)
    assert abs(value("contact_time", pushed(rates * noise)) - 1.2e-6) <= 2e-8


@pytest.mark.parametrize("end", [0.6e-6, 1.1e-6])
def test_contact_time__of_a_bar_at_the_wall_is_none(end: float) -> None:
    assert read("contact_time", pushed(rectangle(1.2e-6, end))).flags == ("in_contact",)


def test_wall_pull__is_the_share_of_the_largest_push() -> None:
    rates = rectangle(1.2e-6)
    rates[150:152] = -0.03 * rates.max()
    assert math.isclose(value("wall_pull", pushed(rates)), 0.03, rel_tol=1e-6)


def test_wall_pull__of_a_wall_that_only_pushes_is_nothing() -> None:
    assert value("wall_pull", pushed(rectangle(1.2e-6))) < 1e-9  # of differences of momenta


# Plates


def test_plateau__is_the_state_behind_the_shocks() -> None:
    seen = plates(LATE)
    assert math.isclose(value("plateau_pressure", seen), PRESSURE, rel_tol=ROUND_OFF)
    assert math.isclose(value("plateau_velocity", seen), 0.5 * PLATE_SPEED, rel_tol=ROUND_OFF)
    assert abs(value("plateau_scatter", seen)) < ROUND_OFF
    for plate in ("flyer", "target"):
        expected = SHOCKED * DENSITY
        assert math.isclose(value(f"{plate}_density", seen), expected, rel_tol=ROUND_OFF)
        spacing = value(f"{plate}_density_from_spacing", seen)
        assert math.isclose(spacing, expected, rel_tol=1e-9)


def test_plateau__scatter_is_the_standard_deviation_of_its_pressure() -> None:
    seen = plates(LATE, scatter=0.05)
    assert math.isclose(value("plateau_scatter", seen), 0.05, rel_tol=0.01)  # layers may be odd
    part = read("plateau_pressure", seen).parts["scatter"]
    assert math.isclose(part, 0.05 * PRESSURE, rel_tol=0.01)


def test_plateau__leaves_out_what_lies_at_the_interface_and_behind_the_front() -> None:
    """Wild values there change nothing."""
    seen = plates(LATE)
    wild = dataclasses.replace(seen, pressure=seen.pressure.copy(), density=seen.density.copy())
    near = np.abs(seen.place - 0.5 * PLATE_SPEED * LATE) < 2.9 * CELL
    wild.pressure[near] *= 1.3
    wild.density[near] *= 0.7
    for name in ("plateau_pressure", "target_density", "flyer_density"):
        assert math.isclose(value(name, wild), value(name, seen), rel_tol=ROUND_OFF)


def test_density__that_particles_carry_is_not_the_one_that_they_stand_in() -> None:
    seen = plates(LATE)
    drifted = dataclasses.replace(seen, density=0.9 * seen.density)
    assert math.isclose(
        value("target_density", drifted), 0.9 * SHOCKED * DENSITY, rel_tol=ROUND_OFF
    )
    spacing = value("target_density_from_spacing", drifted)
    assert math.isclose(spacing, SHOCKED * DENSITY, rel_tol=1e-9)


@pytest.mark.parametrize("plate", ["flyer", "target"])
def test_front__is_where_the_step_is(plate: str) -> None:
    assert abs(value(f"{plate}_shock_front", plates(LATE)) - SHOCK * LATE) < PARTICLE


@pytest.mark.parametrize(
    ("time", "flag"),
    [(0.0, "no_shock"), (0.1 * LATE, "no_plateau"), (1.3 * PLATE / SHOCK, "reflected")],
)
def test_plateau__that_is_not_there_says_why(time: float, flag: str) -> None:
    assert read("plateau_pressure", plates(time)).flags == (flag,)


@pytest.mark.parametrize("plate", ["flyer", "target"])
def test_shock_speed__is_the_slope_of_the_front(plate: str) -> None:
    found = value(f"{plate}_shock_speed", running(plate, 5432.1))
    assert math.isclose(found, 5432.1, rel_tol=1e-9)


def test_shock_speed__does_not_see_how_the_shock_began() -> None:
    late = running("target", 5000.0)
    path = late.values["target_shock_front"]
    path[:8] *= 0.3
    assert math.isclose(value("target_shock_speed", late), 5000.0, rel_tol=1e-9)


def test_shock_speed__of_three_fronts_is_none() -> None:
    found = read("target_shock_speed", running("target", 5000.0, known=3))
    assert found.flags == ("no_plateau",)


# From arrays of the solver, through ``view``


def plate(kind: str, *, hole: float = HOLE, slug: float = 0.0) -> View:
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
    position = np.stack([axis.ravel() for axis in np.meshgrid(*lines, indexing="ij")], axis=-1)
    aside = 0.0 if flat else oval * position[:, 1]
    from_axis = np.hypot(position[:, 0] - middle, aside)
    position = position[(from_axis > hole) | (from_axis < slug)]
    return setting_of_plate(kind), particles_at(kind, position)


def particles_at(kind: str, position: np.ndarray) -> Particles:
    """Particles of the target at some places."""
    particles = views(empty_table(len(position)))
    particles.position[:] = position
    measure = position[:, 0] * PARTICLE**2 if kind == "axisymmetric" else PARTICLE**3
    particles.mass[:] = DENSITY * measure
    return particles


def setting_of_plate(kind: str, **changes: Any) -> Any:
    """What ``view`` asks a setting for."""
    flat = kind == "axisymmetric"
    cells = round(changes.get("radius", RADIUS) / CELL)
    deep = round(changes.get("thickness", THICKNESS) / CELL) + 16
    left, wide = (-RADIUS, 2 * cells) if kind == "half" else (0.0, cells)
    lower = (0.0, -8.0 * CELL, 0.0) if flat else (left, 0.0, -8.0 * CELL)
    record = Axisymmetric if flat else Cartesian3D
    extent = (cells, deep, 0) if flat else (wide, cells, deep)
    return SimpleNamespace(
        **{
            "problem": SimpleNamespace(
                geometry=grid(record, lower=lower, cells=extent, spacing=CELL),
                bodies=(body_of("target", DENSITY),),
                absorbers=(),
            ),
            "target": "target",
            "projectile_diameter": DIAMETER,
            "thickness": THICKNESS,
            "radius": RADIUS,
            "sector": {"axisymmetric": 1.0, "quarter": 0.5 * math.pi, "half": math.pi}[kind],
            **changes,
        }
    )


def body_of(
    name: str, density: float, velocity: tuple[float, float, float] = (0.0, 0.0, 0.0)
) -> Any:
    """What ``view`` asks a body for."""
    return SimpleNamespace(
        name=name,
        density=density,
        spacing=(PARTICLE,) * 3,
        velocity=np.array(velocity),
        mass=np.ones(1),
    )


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
    setting.problem.bodies = (body_of("projectile", DENSITY), *setting.problem.bodies)
    body = (particles.position[:, 0] > HOLE).astype(np.int64)
    state = view(setting, Snapshot(0.0, 0, particles, body))
    assert state.attached.all()
    assert np.array_equal(state.attached_target, body == 1)
    assert value("hole_diameter", state) == value("hole_diameter", plate("axisymmetric"))


@pytest.mark.parametrize("kind", ["axisymmetric", "quarter"])
def test_view__takes_no_debris_that_flies_past_the_rim_for_plate(kind: str) -> None:
    """A jet from a slug in the hole to beyond the rim, six cells behind the plate."""
    setting, particles = plate_of_particles(kind, slug=0.5 * HOLE)
    behind = THICKNESS + 6.0 * CELL
    rise, out = line(THICKNESS, behind), line(0.0, RADIUS)
    across = np.concatenate([np.full_like(rise, 0.5 * PARTICLE), out])
    depth = np.concatenate([rise, np.full_like(out, behind)])
    nothing = np.zeros_like(across)
    places = (across, depth, nothing) if kind == "axisymmetric" else (across, nothing, depth)
    position = np.concatenate([particles.position, np.stack(places, axis=-1)])
    state = view(setting, snapshot_of(particles_at(kind, position)))
    whole = (state.radius > HOLE) & (state.depth < THICKNESS)
    assert state.attached_target.tolist() == whole.tolist()


@pytest.mark.parametrize("drift", [-5.5, 5.5])
def test_view__finds_a_rim_that_has_drifted(drift: float) -> None:
    """As one does that nothing holds."""
    setting, particles = plate_of_particles("axisymmetric", slug=2e-3)
    particles.position[:, 1] += drift * CELL
    state = view(setting, snapshot_of(particles))
    assert state.attached_target.tolist() == (state.radius > HOLE).tolist()


@pytest.mark.parametrize(("side", "absorbs"), [(0, False), (1, True)])
@pytest.mark.parametrize("kind", ["axisymmetric", "quarter"])
def test_view__knows_a_back_that_absorbs(kind: str, side: int, absorbs: bool) -> None:
    setting, particles = plate_of_particles(kind)
    rim = SimpleNamespace(body=0, axis=0, side=1)
    face = SimpleNamespace(body=0, axis=1 if kind == "axisymmetric" else 2, side=side)
    setting.problem.absorbers = (rim, face)
    assert view(setting, snapshot_of(particles)).back_absorbs == absorbs


# Metals of a projectile in a target of ``DENSITY``: the same, aluminium and tungsten.
METALS = [DENSITY, 2700.0, 19300.0]


def lined_crater(density: float, *, thick: float, thin: bool) -> View:
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


@pytest.mark.parametrize("density", METALS)
@pytest.mark.parametrize("thin", [False, True])
@pytest.mark.parametrize("crater", ["crater_depth", "crater_diameter"])
def test_crater__ends_where_half_of_the_space_is_filled_by_whatever_metal(
    crater: str, thin: bool, density: float
) -> None:
    thick = 4.0 * CELL
    found = value(crater, lined_crater(density, thick=thick, thin=thin))
    wanted = value(crater, scooped_half_space(CRATER if thin else CRATER - thick))
    assert abs(found - wanted) < 2.0 * PARTICLE


def test_view__of_one_metal_keeps_the_bits_of_every_mass() -> None:
    setting, particles = plate_of_particles("axisymmetric", slug=2e-3)
    setting.problem.bodies = (*setting.problem.bodies, body_of("projectile", DENSITY))
    body = (particles.position[:, 0] < HOLE).astype(np.int64)
    assert np.array_equal(view(setting, Snapshot(0.0, 0, particles, body)).mass, particles.mass)


# An oval hole beside the first touch, as an oblique shot makes it: half axes and shift
LONG, SHORT, ASIDE = 10e-3, 7e-3, 5e-3
AREA_DIAMETER = 2.0 * math.sqrt(LONG * SHORT)


def oval_hole(*, aside: float = ASIDE, oblique: bool = True) -> View:
    """The half of a plate that a shot has left."""
    setting, particles = plate_of_particles("half", hole=LONG, middle=aside, oval=LONG / SHORT)
    flight = (1.0 if oblique else 0.0, 0.0, 1.0)
    setting.problem.bodies = (*setting.problem.bodies, body_of("projectile", DENSITY, flight))
    return view(setting, snapshot_of(particles))


def test_oblique_hole__has_the_diameter_of_its_area() -> None:
    assert abs(value("hole_diameter", oval_hole()) - AREA_DIAMETER) < 0.1 * CELL


def test_oblique_hole__is_as_clear_as_its_area_to_a_cell() -> None:
    """The innermost edge of a sector of an oval lies a little inside its mean."""
    assert abs(value("hole_diameter_clear", oval_hole()) - AREA_DIAMETER) < CELL


@pytest.mark.parametrize("opening", OPENINGS)
def test_oblique_hole__does_not_take_its_shape_for_an_uncertainty(opening: str) -> None:
    assert read(opening, oval_hole()).parts["azimuth"] < 0.2 * CELL


@pytest.mark.parametrize("opening", OPENINGS)
def test_oblique_hole__is_the_same_wherever_it_lies(opening: str) -> None:
    """The walk in from the rim begins elsewhere, and so its samples lie elsewhere."""
    one, other = (value(opening, oval_hole(aside=cells * CELL)) for cells in (0.0, 10.0))
    assert abs(one - other) < 0.01 * CELL


def test_oblique_hole__leaves_its_rim_where_it_is() -> None:
    state = oval_hole()
    assert abs(state.target_radius - (RADIUS - ASIDE)) < 0.1 * CELL


def test_normal_hole__is_seen_from_the_first_touch() -> None:
    """Whatever scatter has done to it: nothing but an oblique flight moves a hole."""
    state = oval_hole(oblique=False)
    assert state.target_radius == RADIUS
    assert abs(state.radius.min() - (LONG - ASIDE)) < PARTICLE


@pytest.mark.parametrize("hole", [0.0, RADIUS - ASIDE])
def test_oblique_shot__without_a_hole_within_the_rim_is_seen_from_the_first_touch(
    hole: float,
) -> None:
    setting, particles = plate_of_particles("half", hole=hole, middle=ASIDE)
    setting.problem.bodies[0].velocity[0] = 1.0
    assert view(setting, snapshot_of(particles)).target_radius == RADIUS


@pytest.mark.parametrize(("left", "flag"), [(0.375, "not_perforated"), (0.125, "closed_on_axis")])
@pytest.mark.parametrize(
    ("kind", "middle"), [("axisymmetric", 0.0), ("quarter", 0.0), ("half", 0.0), ("half", ASIDE)]
)
def test_dent__is_no_hole_in_any_geometry_and_wherever_it_lies(
    kind: str, middle: float, left: float, flag: str
) -> None:
    setting, particles = plate_of_particles(kind, hole=0.0)
    setting.problem.bodies[0].velocity[0] = middle
    axis = 1 if kind == "axisymmetric" else 2
    across = np.delete(particles.position, axis, axis=1) - (middle, 0.0)
    depth = particles.position[:, axis]
    stays = (np.hypot(*across.T) > HOLE) | (depth > (1.0 - left) * THICKNESS)
    dented = Particles(*(field[stays] for field in particles))
    assert read("hole_diameter", view(setting, snapshot_of(dented))).flags == (flag,)


def test_azimuthal_spread__of_independent_sectors_is_the_standard_error_of_their_mean() -> None:
    scatter, sectors = 0.1e-3, 20000
    radii = HOLE + np.random.default_rng(0).normal(0.0, scatter, sectors)
    expected = 2.0 * scatter / math.sqrt(sectors)
    assert math.isclose(azimuthal_spread(radii), expected, rel_tol=0.03)


def test_azimuthal_spread__of_a_smooth_shape_is_nothing() -> None:
    assert azimuthal_spread(HOLE + 0.1 * CELL * np.arange(18.0)) < ROUND_OFF * HOLE


@pytest.mark.parametrize("kind", ["round", "quarter"])
def test_view_of_a_bar__knows_each_particle_by_its_number(kind: str) -> None:
    setting, particles = bar_of_arrays(kind)
    order = np.random.default_rng(0).permutation(particles.mass.size)
    shuffled = Particles(*(field[order] for field in particles))
    seen = view_of_bar(setting, snapshot_of(shuffled))
    assert math.isclose(value("final_length", seen), BAR_LENGTH, rel_tol=ROUND_OFF)
    assert math.isclose(value("mushroom_diameter", seen), BAR_DIAMETER, rel_tol=ROUND_OFF)
    assert math.isclose(value("rebound_momentum", seen), -1.0, rel_tol=ROUND_OFF)


@pytest.mark.parametrize("kind", ["round", "quarter"])
def test_view_of_a_bar__leaves_out_what_has_left_the_grid(kind: str) -> None:
    setting, particles = bar_of_arrays(kind)
    particles.alive[-1] = 0
    seen = view_of_bar(setting, snapshot_of(particles))
    assert seen.mass.size == particles.mass.size - 1
    assert read("final_length", seen).flags == ("lost_particles",)


def test_view_of_a_bar__has_the_elastic_energy_of_uniaxial_stress() -> None:
    """sigma^2 / 2 E per volume, where strain is small: the terms left out are of the order of the strain."""
    setting, particles = bar_of_arrays("quarter")
    young = 9.0 * BULK * SHEAR / (3.0 * BULK + SHEAR)
    stress = 1e-5 * young
    particles.density[:] = DENSITY * (1.0 - stress / 3.0 / BULK)
    particles.deviator[:, 2] = 2.0 / 3.0 * stress
    particles.deviator[:, :2] = -stress / 3.0
    seen = view_of_bar(setting, snapshot_of(particles))
    expected = 0.5 * stress**2 / young / DENSITY
    assert np.allclose(seen.strain_energy, expected, rtol=1e-4, atol=0.0)


@pytest.mark.parametrize("kind", ["round", "quarter"])
def test_view_of_plates__knows_each_particle_by_its_number(kind: str) -> None:
    flat = kind == "round"
    state = plates(LATE)
    axis = 1 if flat else 2
    particles = views(empty_table(state.mass.size))
    particles.position[:, axis] = state.place
    particles.velocity[:, axis] = state.velocity
    for name in ("mass", "density", "pressure"):
        getattr(particles, name)[:] = getattr(state, name)
    record, cells = (Axisymmetric, (1, 90, 0)) if flat else (Cartesian3D, (1, 1, 90))
    geometry = grid(record, lower=(0.0,) * 3, cells=cells, spacing=CELL)
    setting = SimpleNamespace(
        problem=SimpleNamespace(geometry=geometry),
        layer=state.layer,
        section=state.section,
        speed=state.speed,
    )
    order = np.random.default_rng(0).permutation(state.mass.size)
    shuffled = Particles(*(field[order] for field in particles))
    seen = view_of_plates(setting, Snapshot(LATE, 0, shuffled, state.body[order]))
    for name in ("plateau_pressure", "target_density_from_spacing", "flyer_shock_front"):
        assert math.isclose(value(name, seen), value(name, state), rel_tol=1e-9)
