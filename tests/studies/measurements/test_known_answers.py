"""What each measurement reads off states with a known answer, and what leaves its reading where it is."""

import dataclasses
import math
from collections.abc import Callable
from functools import partial
from itertools import chain
from typing import Any

import numpy as np
import pytest

from studies.measurements import History
from studies.measurements.bar import rear_face_place
from studies.quantities.measured import DEFINITION
from tests import samples
from tests.studies.measurements.states import (
    BAR_DIAMETER,
    BAR_LENGTH,
    BAR_SPEED,
    BREADTH,
    CELL,
    CRATER,
    DENSITY,
    DEPTH,
    DIAMETER,
    EDGE,
    HOLE,
    IMPEDANCE,
    LATE,
    OPENINGS,
    PARTICLE,
    PLATE,
    PLATE_SPEED,
    PRESSURE,
    RADIUS,
    ROUND_OFF,
    SHOCK,
    SHOCKED,
    TENTH,
    THICKNESS,
    WALLS,
    bar,
    bored_half_space,
    collared_disc,
    cratered,
    dented_disc,
    drilled_disc,
    flared,
    hollowed_half_space,
    impact,
    lattice,
    line,
    lipped_disc,
    plates,
    pushed,
    read,
    rectangle,
    released_plates,
    running,
    scooped_half_space,
    smeared,
    straight,
    stretched,
    surface,
    value,
    with_particle,
    without,
)

LAST_LAYER = BAR_LENGTH - 0.5 * PARTICLE
OF_THE_WALL_ALONE = ("rigid_energy", "vibration_energy", "strain_energy", "lost_energy", "rebound_momentum")
AXES = ("largest", "smallest", "mean_root")
Build = Callable[[], Any]


def conical_disc() -> Any:
    """A plate whose hole has the drill's radius in its middle plane."""
    radius, depth = lattice(line(0.0, RADIUS), line(0.0, THICKNESS))
    left = radius > HOLE + (depth - 0.5 * THICKNESS)
    return impact(radius[left], depth[left], thickness=THICKNESS, breadth=RADIUS)


def cap(share: float) -> Any:
    """A crater of the scoop's radius at the surface and a share of it deep, a part of a sphere."""
    depth = share * CRATER
    sphere = (CRATER**2 + depth**2) / (2.0 * depth)
    return cratered(lambda z: math.sqrt(sphere**2 - (z + sphere - depth) ** 2), depth)


def cap_volume(share: float) -> float:
    depth = share * CRATER
    return math.pi * depth * (3.0 * CRATER**2 + depth**2) / 6.0


def off_by_a_tenth(share: float) -> float:
    """The volume by which a cap with another surface differs, a tenth of a cell away everywhere."""
    return math.pi * CRATER**2 * (1.0 + share**2) * TENTH


def walled_crater(height: float) -> Any:
    """A crater with a lip as wide as eight particles and of a height (m), which ends exactly there."""
    block = cratered(WALLS["hemisphere"], CRATER)
    for place in line(-height, 0.0):
        for radius in line(CRATER + PARTICLE, CRATER + 9.0 * PARTICLE):
            block = with_particle(block, float(radius), float(place))
    return block


def depths(*depth: float) -> History:
    return History(np.arange(len(depth)) * 1e-6, {"crater_depth": np.array(depth)})


def rear_faces(*place: float) -> History:
    return History(np.arange(len(place)) * 1e-6, {rear_face_place.name: np.array(place)})


def split_bar() -> Any:
    """A bar whose halves part at the impact speed."""
    state = bar()
    state.velocity[state.place[:, 2] >= state.place[:, 2].max() / 2.0, 2] *= -1.0
    return state


def strained_bar() -> Any:
    """A bar that flies off at half of its speed and holds a fifth of its energy as strain."""
    state = bar(velocity=(0.0, 0.0, 0.5 * BAR_SPEED))
    state.strain_energy[:] = 0.1 * BAR_SPEED**2
    return state


def wild_plates() -> Any:
    """Plates with wild values next to the interface."""
    state = plates(LATE)
    wild = dataclasses.replace(state, pressure=state.pressure.copy(), density=state.density.copy())
    near = np.abs(state.place - 0.5 * PLATE_SPEED * LATE) < 2.9 * CELL
    wild.pressure[near] *= 1.3
    wild.density[near] *= 0.7
    return wild


def drifted_plates() -> Any:
    """Plates whose particles carry less density than they stand in."""
    state = plates(LATE)
    return dataclasses.replace(state, density=0.9 * state.density)


# Up with ripples below the recovery, down, up again; then a deeper minimum that is not the first.
SPALLED = (0.0, 20.0, 190.0, 200.0, 197.5, 201.0, 199.0, 170.0, 150.0, 152.0, 165.0, 180.0, 120.0, 160.0)


def waving_bar() -> Any:
    """Velocity and stress rise along the initial height, and across."""
    state = bar(stretched)
    heights = state.height + (state.place[:, :2] > 0).any(axis=1)
    velocity = np.stack([0.0 * heights, 0.0 * heights, heights], axis=1)
    return dataclasses.replace(state, velocity=velocity, stress=-2e9 * heights)


def middles(last: float = 3.0) -> History:
    values = np.array([0.0, 2.0, -5.0, last])
    return History(1e-6 * np.arange(values.size), {"middle_velocity": values, "middle_stress": values})


def pulled() -> History:
    rates = rectangle(1.2e-6)
    rates[150:152] = -0.03 * rates.max()
    return pushed(rates)


def noisy() -> History:
    rates = rectangle(1.2e-6)
    return pushed(rates * np.where(np.arange(rates.size) % 2, 1.9, 0.1))


def slow_start() -> History:
    """A front that ran slower in the first third of the time."""
    history = running("target", 5000.0)
    history.values["target_shock_front"][:8] *= 0.3
    return history


def thesis_bar() -> Any:
    """Ma (2005), Table 2.2, finite elements: 16.3, 13.4 and 10.0 mm against 16.2, 13.5 and 10.1 mm."""
    ratios = (16.2 / 16.3, 13.5 / 13.4, 10.1 / 10.0)
    sizes = (BAR_LENGTH, BAR_DIAMETER, BAR_DIAMETER)
    return bar(references=tuple(s * r for s, r in zip(sizes, ratios, strict=True)))


def bars(shape: Callable[[np.ndarray], np.ndarray]) -> list[Build]:
    return [partial(bar, shape, round_model=flat) for flat in (False, True)]


CAP = (0.25 * DIAMETER) ** 2 / (4.0 * CRATER)  # half of a flat column's floor lies below it
REFERENCES = (0.9 * BAR_LENGTH, 1.25 * BAR_DIAMETER, 0.8 * BAR_DIAMETER)
BEHIND = SHOCKED * DENSITY
SHIFTS = [0.1 * part for part in range(11)]  # cells

# Measurement, state, value, and how far off the reading may be.
KNOWN: list[tuple[str, Build, float, float]] = [
    # An edge on a lattice is known to half a particle, and a diameter has two of them.
    *(
        (name, lambda s=shift: drilled_disc(HOLE + s * CELL), 2.0 * (HOLE + shift * CELL), 2 * EDGE)
        for name in OPENINGS
        for shift in (SHIFTS if name == "hole_diameter" else [0.0])
    ),
    *(
        ("hole_diameter", lambda w=w, z=z: collared_disc(HOLE, inwards=w, depth=z), 2.0 * (HOLE - w), 0.05 * PARTICLE)
        for w in (CELL, 4.0 * CELL)
        for z in (-CELL, CELL, THICKNESS)
    ),
    # The narrowest bin of a cone is a cell high, and its wall a cell deep.
    ("hole_diameter", conical_disc, 2.0 * HOLE - THICKNESS, 2.0 * CELL),
    ("hole_diameter_areal", conical_disc, 2.0 * HOLE, 2.0 * EDGE),
    ("hole_diameter_midplane", conical_disc, 2.0 * HOLE, 2.0 * CELL),
    ("hole_diameter_lip", lambda: lipped_disc(HOLE, HOLE + 3.3e-3), 2 * HOLE + 6.6e-3, 1e-14),
    *(("crater_diameter", lambda s=share: cap(s), 2.0 * CRATER, 2.0 * TENTH) for share in (0.3, 0.5, 0.8)),
    *(
        ("crater_diameter", lambda c=c: cratered(WALLS["cylinder"], c * CELL), 2 * CRATER, 2 * TENTH)
        for c in (3.0, 5.0, 7.0)
    ),
    # Lattice points leave one by one, so the reading follows a tenth of a cell to within a particle.
    *(
        (name, lambda s=shift: scooped_half_space(CRATER + s * CELL), of(CRATER + shift * CELL), off)
        for name, of, off in (
            ("crater_depth", lambda r: r - CAP, 2.0 * PARTICLE),
            ("crater_diameter", lambda r: 2.0 * r, 4.0 * PARTICLE),
        )
        for shift in SHIFTS[::5]
    ),
    ("crater_depth", lambda: scooped_half_space(0.0), 0.0, PARTICLE),
    *(
        ("crater_volume", lambda s=share: cap(s), cap_volume(share), off_by_a_tenth(share))
        for share in (0.2, 0.5, 0.83, 1.0)
    ),
    (
        "crater_volume",
        lambda: cratered(WALLS["cylinder"], 7.0 * CELL),
        math.pi * CRATER**2 * 7.0 * CELL,
        math.pi * CRATER**2 * TENTH,
    ),
    *(("crater_lip_height", lambda c=cells: walled_crater(c * CELL), cells * CELL, TENTH) for cells in (1.0, 2.5, 5.0)),
    ("crater_rebound", lambda: depths(1e-3, 4e-3, 5e-3, math.nan, 4.5e-3), 0.1, ROUND_OFF),
    ("crater_depth_over_diameter", lambda: scooped_half_space(CRATER), 0.5, PARTICLE / CRATER),
    # A bar has exactly the length and diameter to which it was stretched, a flared one that of the cone. Its lowest
    # layer stands half a particle above its foot.
    *(("final_length", state, BAR_LENGTH, 1e-14) for state in (*bars(straight), *bars(flared))),
    *(("final_length", state, 2.0 / 3.0 * BAR_LENGTH, 1e-14) for state in bars(stretched)),
    *(("mushroom_diameter", state, 1.2 * BAR_DIAMETER, 1e-14) for state in bars(stretched)),
    *(
        ("mushroom_diameter", state, (1.5 - 0.25 * PARTICLE / BAR_LENGTH) * BAR_DIAMETER, 1e-14)
        for state in bars(flared)
    ),
    *(("width_at_fifth", state, 1.4 * BAR_DIAMETER, 1e-14) for state in bars(flared)),
    ("taylor_error", lambda: bar(references=REFERENCES), (0.1 / 0.9 + 0.2 + 0.25) / 3.0, 1e-9),
    ("taylor_error", thesis_bar, 0.008, 0.0005),
    ("rigid_energy", bar, 1.0, ROUND_OFF),
    ("vibration_energy", bar, 0.0, ROUND_OFF),
    ("strain_energy", bar, 0.0, 0.0),
    ("lost_energy", bar, 0.0, ROUND_OFF),
    ("rebound_momentum", bar, -1.0, ROUND_OFF),
    ("rigid_energy", split_bar, 0.0, ROUND_OFF),
    ("vibration_energy", split_bar, 1.0, ROUND_OFF),
    ("rigid_energy", lambda: bar(velocity=(30.0, 40.0, 0.0)), 0.0, 0.0),
    ("vibration_energy", lambda: bar(velocity=(30.0, 40.0, 0.0)), 0.25, ROUND_OFF),
    ("strain_energy", strained_bar, 0.2, ROUND_OFF),
    ("lost_energy", strained_bar, 1.0 - 0.25 - 0.2, 1e-9),
    ("rebound_momentum", strained_bar, 0.5, ROUND_OFF),
    *(("rear_face_place", state, LAST_LAYER, 1e-14) for state in bars(straight)),
    *(("rear_face_place", state, 2.0 / 3.0 * LAST_LAYER + TENTH, 1e-14) for state in bars(stretched)),
    ("rear_face_velocity", lambda: rear_faces(0.02, 0.020, 0.0195), -500.0, 1e-8),
    # Linear along the bar, and other values away from the axis.
    ("middle_velocity", waving_bar, 0.5 * BAR_LENGTH, 1e-14),
    ("middle_stress", waving_bar, -1e9 * BAR_LENGTH, 1e-5),
    *((f"middle_peak_{name}", middles, -5.0, 0.0) for name in ("velocity", "stress")),
    # Half of the time between observations.
    *(("contact_time", lambda t=t: pushed(rectangle(t)), t, 0.5e-8) for t in (0.5e-6, 1.234e-6)),
    ("contact_time", lambda: pushed(smeared(rectangle(1.2e-6))), 1.2e-6, 1e-8),
    ("contact_time", noisy, 1.2e-6, 2e-8),
    ("wall_pull", pulled, 0.03, 1e-7),
    ("wall_pull", lambda: pushed(rectangle(1.2e-6)), 0.0, 1e-9),
    ("plateau_pressure", lambda: plates(LATE), PRESSURE, ROUND_OFF * PRESSURE),
    ("plateau_velocity", lambda: plates(LATE), 0.5 * PLATE_SPEED, 1e-9),
    ("plateau_scatter", lambda: plates(LATE), 0.0, ROUND_OFF),
    ("plateau_scatter", lambda: plates(LATE, scatter=0.05), 0.05, 0.0005),
    *(
        (f"{plate}_{name}", state, expected, off)
        for plate in ("flyer", "target")
        for name, state, expected, off in (
            ("density", lambda: plates(LATE), BEHIND, 1e-8),
            ("density", drifted_plates, 0.9 * BEHIND, 1e-8),
            ("density_from_spacing", lambda: plates(LATE), BEHIND, 1e-5),
            ("density_from_spacing", drifted_plates, BEHIND, 1e-5),
            ("density", wild_plates, BEHIND, 1e-8),
            ("shock_front", lambda: plates(LATE), SHOCK * LATE, PARTICLE),
            ("shock_speed", lambda: running("", 5432.1), 5432.1, 1e-5),
        )
    ),
    ("plateau_pressure", wild_plates, PRESSURE, ROUND_OFF * PRESSURE),
    ("target_shock_speed", slow_start, 5000.0, 1e-5),
    ("free_surface_velocity", lambda: plates(LATE), 0.0, 0.0),
    ("free_surface_velocity", released_plates, PLATE_SPEED, 1e-9),
    ("acoustic_stress", released_plates, 0.5 * IMPEDANCE * PLATE_SPEED, 1e-2),
    *(
        (name, lambda: surface(*SPALLED), expected, 1e-3)
        for name, expected in (
            ("free_surface_peak", 201.0),
            ("free_surface_minimum", 150.0),
            ("pullback_velocity", 51.0),
            ("spall_strength", 0.5 * IMPEDANCE * 51.0),
        )
    ),
    *chain(*samples.offered("KNOWN")),
]


@pytest.mark.parametrize(("name", "build", "expected", "off"), KNOWN)
def test_reading__is_the_known_answer(name: str, build: Build, expected: float, off: float) -> None:
    assert abs(value(name, build()) - expected) <= off


def gone_disc() -> Any:
    disc = drilled_disc(HOLE)
    nothing = np.zeros_like(disc.target)
    return dataclasses.replace(disc, attached=nothing, attached_target=nothing)


def near_back(crater: float, *, absorbs: bool = False) -> Any:
    return dataclasses.replace(scooped_half_space(crater * DEPTH), back_absorbs=absorbs)


def bar_without_corner() -> Any:
    whole = bar()
    last = whole.place[:, 2] == whole.place[:, 2].max()
    return without(whole, (whole.place[:, 1] == 0) & last)


# Measurement, state, flags; a value comes with the flags of the second table only.
NO_VALUE: list[tuple[str, Build, str]] = [
    *(
        (name, state, flag)
        for name in OPENINGS
        for state, flag in (
            (lambda: drilled_disc(0.0), "not_perforated"),
            (lambda: dented_disc(0.375), "not_perforated"),
            (lambda: dented_disc(0.875), "not_perforated"),
            (lambda: drilled_disc(RADIUS - 2.0 * CELL), "not_contained"),
            (gone_disc, "not_contained"),
        )
    ),
    ("hole_diameter_areal", lambda: dented_disc(1.0, stretch=1.9), "not_perforated"),
    ("hole_diameter", lambda: dented_disc(1.0, stretch=1.9), "not_perforated"),
    ("hole_diameter", lambda: collared_disc(HOLE, inwards=HOLE - PARTICLE, depth=CELL), "not_perforated"),
    ("hole_diameter_lip", lambda: drilled_disc(HOLE), "no_lip"),
    ("hole_diameter_lip", lambda: lipped_disc(HOLE, HOLE + 1.1 * DIAMETER), "no_lip"),
    ("crater_depth", bored_half_space, "perforated"),
    ("crater_depth_over_diameter", bored_half_space, "perforated"),
    ("crater_diameter", lambda: scooped_half_space(0.0), "no_crater"),
    ("crater_diameter", lambda: cratered(lambda z: (2.0 if z < 1.5 * CELL else 12.0) * CELL, CRATER), "no_crater"),
    ("crater_depth_over_diameter", lambda: scooped_half_space(0.0), "no_crater"),
    *(
        (name, lambda: scooped_half_space(BREADTH - 2.0 * CELL), "not_contained")
        for name in ("crater_diameter", "crater_volume", "crater_diameter_largest")
    ),
    ("crater_volume", lambda: scooped_half_space(0.0), "no_crater"),
    ("crater_volume", bored_half_space, "perforated"),
    ("crater_lip_height", lambda: scooped_half_space(CRATER), "no_lip"),
    ("crater_lip_height", lambda: walled_crater(6.5 * CELL), "lip_at_edge"),
    ("crater_rebound", lambda: depths(math.nan, math.nan), "no_crater"),
    ("hole_diameter_mean_root", lambda: drilled_disc(0.0), "not_perforated"),
    ("width_at_fifth", lambda: bar(lambda points: points * (1.0, 1.0, 0.15)), "too_short"),
    ("final_length", bar_without_corner, "lost_particles"),
    ("mushroom_diameter", bar_without_corner, "lost_particles"),
    ("width_at_fifth", bar_without_corner, "lost_particles"),
    ("taylor_error", lambda: bar(references=(BAR_LENGTH, None, BAR_DIAMETER)), "no_reference"),
    ("rear_face_place", bar_without_corner, "lost_particles"),
    ("rear_face_velocity", lambda: rear_faces(0.02, math.nan), "lost_particles"),
    ("rear_face_velocity", lambda: rear_faces(0.02), "one_observation"),
    *((f"middle_{name}", bar_without_corner, "lost_particles") for name in ("velocity", "stress")),
    *((f"middle_peak_{name}", lambda: middles(math.nan), "lost_particles") for name in ("velocity", "stress")),
    *((name, lambda: bar(is_loaded=True), "loaded") for name in OF_THE_WALL_ALONE),
    *((name, lambda: pushed(np.full(9, math.nan)), "loaded") for name in ("contact_time", "wall_pull")),
    ("contact_time", lambda: pushed(rectangle(1.2e-6, 0.6e-6)), "in_contact"),
    ("contact_time", lambda: pushed(rectangle(1.2e-6, 1.1e-6)), "in_contact"),
    ("plateau_pressure", lambda: plates(0.0), "no_shock"),
    ("plateau_pressure", lambda: plates(0.1 * LATE), "no_plateau"),
    ("plateau_pressure", lambda: plates(1.3 * PLATE / SHOCK), "reflected"),
    ("target_shock_speed", lambda: running("target", 5000.0, placed=3), "no_plateau"),
    *(
        (name, lambda made=made: surface(*made), flag)
        for name in ("free_surface_minimum", "pullback_velocity", "spall_strength")
        for made, flag in (
            ((0.0, 0.0), "not_arrived"),
            ((0.0, 100.0, 199.0, 198.0), "ended_before"),  # no release yet
            ((0.0, 200.0, 170.0, 150.0), "ended_before"),  # still falling
            ((0.0, 200.0, 150.0, 151.0, 150.5), "no_minimum"),  # fell, and stays there
        )
    ),
    ("free_surface_peak", lambda: surface(0.0, 0.0), "not_arrived"),
    *chain(*samples.offered("NO_VALUE")),
]
DOUBTED: list[tuple[str, Build, str]] = [
    *chain(*samples.offered("DOUBTED")),
    *((name, lambda: dented_disc(0.125), "closed_on_axis") for name in OPENINGS),
    ("hole_diameter_areal", lambda: dented_disc(1.0, stretch=2.1), "closed_on_axis"),
    *((name, lambda: drilled_disc(0.51 * RADIUS), "near_rim") for name in OPENINGS),
    *((name, lambda: drilled_disc(0.49 * RADIUS), "") for name in OPENINGS),
    ("hole_diameter_lip", lambda: lipped_disc(HOLE, HOLE + DIAMETER - 0.5 * CELL), "lip_at_window"),
    ("crater_rebound", lambda: depths(1e-3, 4e-3, 5e-3), "before_maximum"),
    ("hole_diameter_lip", lambda: lipped_disc(HOLE, HOLE + DIAMETER - 1.5 * CELL), ""),
    *(
        (name, state, flag)
        for name in ("crater_depth", "crater_depth_over_diameter")
        for state, flag in (
            (lambda: near_back(0.30), ""),
            (lambda: near_back(0.37), "near_back"),
            (lambda: near_back(0.37, absorbs=True), ""),
        )
    ),
]


@pytest.mark.parametrize(("name", "build", "flag"), [*NO_VALUE, *DOUBTED])
def test_reading__is_flagged(name: str, build: Build, flag: str) -> None:
    reading = read(name, build())
    assert reading.flags == ((flag,) if flag else ())
    assert math.isnan(reading.value) == ((name, build, flag) in NO_VALUE)


def stray(part: float, depth: float = 0.5) -> Build:
    return lambda: with_particle(drilled_disc(HOLE), part * HOLE, depth * THICKNESS)


def scooped() -> Any:
    return scooped_half_space(CRATER)


# Measurement, state, state with a change that must not move the reading, and by how much it may.
UNMOVED: list[tuple[str, Build, Build, float]] = [
    # A particle that flies in the hole fills half of a ring of the bin, at its own radius.
    *(
        ("hole_diameter", lambda: drilled_disc(HOLE), stray(part, depth), 2.0 * part * 0.5 * PARTICLE)
        for part in (0.3, 0.6, 0.9)
        for depth in (0.3, 0.5)
    ),
    # Beside the plate nothing shares its bin.
    *(("hole_diameter", lambda: drilled_disc(HOLE), stray(0.3, depth), ROUND_OFF) for depth in (-1.125, 2.125)),
    *(("hole_diameter_areal", lambda: drilled_disc(HOLE), stray(part), 1e-14) for part in (0.3, 0.6, 0.9)),
    # One of the eight particles through the thickness: an eighth of a particle on each side.
    ("hole_diameter_areal", lambda: drilled_disc(HOLE), stray(1.0 - 0.6 * PARTICLE / HOLE), 2.0 * PARTICLE / 8.0),
    ("hole_diameter_midplane", lambda: drilled_disc(HOLE), stray(0.6, -1.0), 0.0),
    ("crater_depth", scooped, lambda: hollowed_half_space(CRATER, roof=2e-3, height=2e-3), 1e-14),
    *(
        (name, scooped, lambda: with_particle(scooped(), 0.1 * CRATER, 0.4 * CRATER), 1e-14)
        for name in ("crater_depth", "crater_diameter")
    ),
]


@pytest.mark.parametrize(("name", "before", "after", "off"), UNMOVED)
def test_reading__stays_where_it_is(name: str, before: Build, after: Build, off: float) -> None:
    assert abs(value(name, after()) - value(name, before())) <= off


@pytest.mark.parametrize("build", [conical_disc, lambda: drilled_disc(HOLE)])
def test_part_of_the_definition__is_half_of_the_gap_between_both_diameters(build: Build) -> None:
    state = build()
    gap = value("hole_diameter_areal", state) - value("hole_diameter", state)
    part = read("hole_diameter", state).parts[DEFINITION]
    assert math.isclose(part, 0.5 * abs(gap), rel_tol=1e-9, abs_tol=1e-12)
    assert DEFINITION not in read("hole_diameter_areal", state).parts
