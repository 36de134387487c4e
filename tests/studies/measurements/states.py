"""States with a known answer for measurements: drilled plates, scooped blocks, stretched bars, colliding plates."""

import dataclasses
import math
from collections.abc import Callable
from types import SimpleNamespace
from typing import Any, get_type_hints

import numpy as np

from solver.problem.geometry import Axisymmetric, Cartesian3D, grid
from solver.state import Particles, Snapshot
from studies import measurements
from studies.measurements import History, Reading
from studies.measurements._breakup import Breakup
from studies.measurements._settings import Melting
from studies.measurements.bar import BarView, rear_face_place, rebound_momentum
from studies.measurements.impact.cloud import CloudView
from studies.measurements.impact.view import ImpactView, connected
from studies.measurements.plates import FLYER, TARGET, PlateView
from tests import samples

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

OPENINGS = ("hole_diameter", "hole_diameter_areal", "hole_diameter_midplane")


def line(begin: float, end: float) -> np.ndarray:
    """Places of particles that fill begin..end from its end, so that the edge stands exactly at ``begin``."""
    count = round((end - begin) / PARTICLE)
    return begin + PARTICLE * (np.arange(count) + 0.5)


def lattice(*lines: np.ndarray) -> tuple[np.ndarray, ...]:
    """Coordinates (n,) of all points of some lines."""
    return tuple(axis.ravel() for axis in np.meshgrid(*lines, indexing="ij"))


def impact(radius: np.ndarray, depth: np.ndarray, *, thickness: float, breadth: float, **changes: Any) -> ImpactView:
    """A body of revolution of particles, all of it target and in one piece."""
    whole = np.ones(radius.size, bool)
    return ImpactView(
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
            "room": 8.0 * CELL,
            "back_absorbs": False,
            "projectile_diameter": DIAMETER,
            **changes,
        }
    )


def drilled_disc(hole: float) -> ImpactView:
    """A plate with a round hole: its matter begins exactly at the drill's radius."""
    radius, depth = lattice(line(hole, RADIUS), line(0.0, THICKNESS))
    return impact(radius, depth, thickness=THICKNESS, breadth=RADIUS)


def scooped_half_space(crater: float) -> ImpactView:
    """A deep block without a ball about the origin."""
    radius, depth = lattice(line(0.0, BREADTH), line(0.0, DEPTH))
    left = np.hypot(radius, depth) > crater
    return impact(radius[left], depth[left], thickness=DEPTH, breadth=BREADTH)


def cratered(wall: Callable[[float], float], floor: float) -> ImpactView:
    """A deep block without a crater: each layer of particles begins exactly at the wall of its depth."""
    depths = line(0.0, DEPTH)
    rows = [line(wall(z) if z < floor else 0.0, BREADTH) for z in depths]
    depth = np.concatenate([np.full(row.size, z) for row, z in zip(rows, depths, strict=True)])
    return impact(np.concatenate(rows), depth, thickness=DEPTH, breadth=BREADTH)


def bored_half_space() -> ImpactView:
    """A deep block with a hole right through it, wider than the column about the axis."""
    radius, depth = lattice(line(HOLE, BREADTH), line(0.0, DEPTH))
    return impact(radius, depth, thickness=DEPTH, breadth=BREADTH)


def dented_disc(left: float, *, stretch: float = 1.0) -> ImpactView:
    """A plate of which a share is left where the hole would be, on its exit side and drawn out in both directions."""
    disc = drilled_disc(HOLE)
    gone = (1.0 - left) * THICKNESS
    radius, depth = lattice(line(0.0, HOLE / stretch), line(gone, THICKNESS))
    state = impact(
        np.append(disc.radius, stretch * radius), np.append(disc.depth, depth), thickness=THICKNESS, breadth=RADIUS
    )
    mass = np.append(disc.mass, DENSITY * radius * PARTICLE**2)
    return dataclasses.replace(state, mass=mass)


def lipped_disc(hole: float, crest: float) -> ImpactView:
    """A drilled disc whose entry side carries one ring of particles, two particles above the face."""
    disc = drilled_disc(hole)
    return with_particle(disc, crest, -2.0 * PARTICLE)


def collared_disc(hole: float, *, inwards: float, depth: float) -> ImpactView:
    """A drilled disc with a solid collar, a cell high, that stands into the hole."""
    disc = drilled_disc(hole)
    for place in line(depth, depth + CELL):
        for radius in line(hole - inwards, hole):
            disc = with_particle(disc, float(radius), float(place))
    return disc


def with_particle(state: ImpactView, radius: float, depth: float) -> ImpactView:
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
    arrays: dict[str, Any] = {name: np.append(getattr(state, name), value) for name, value in added.items()}
    return dataclasses.replace(state, **arrays)


def chosen(state: Any, which: np.ndarray) -> Any:
    """The particles of a state at some places (k,), or where ``which`` (n, bool) says so."""
    arrays = {name: value[which] for name, value in vars(state).items() if isinstance(value, np.ndarray)}
    return dataclasses.replace(state, **arrays)


def reordered(state: Any) -> Any:
    """A state, and the states in it, with its particles in another order."""
    if isinstance(state, tuple):
        return tuple(map(reordered, state))
    if not dataclasses.is_dataclass(type(state)):
        return state
    inside = dataclasses.replace(state, **{name: reordered(value) for name, value in vars(state).items()})
    return chosen(inside, np.random.default_rng(0).permutation(inside.mass.size)) if hasattr(inside, "mass") else inside


def without(state: Any, gone: np.ndarray) -> Any:
    return chosen(state, ~gone)


def hollowed_half_space(crater: float, *, roof: float, height: float) -> ImpactView:
    """A scooped half space with a void, as spall leaves it, a ``roof`` below the floor."""
    block = scooped_half_space(crater)
    void = (block.radius < 2.0 * DIAMETER) & (block.depth > crater + roof)
    return without(block, void & (block.depth < crater + roof + height))


# Bars

BAR_LENGTH, BAR_DIAMETER, BAR_SPEED = 20e-3, 8e-3, 100.0
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
    place, points = (np.stack(lattice(*each), axis=-1) for each in (places, lines))
    inside = np.hypot(points[:, 0], points[:, 1]) < 0.5 * BAR_DIAMETER
    points, place = points[inside], place[inside]
    mass = DENSITY * (points[:, 0] * PARTICLE**2 if round_model else np.full(len(points), PARTICLE**3))
    return BarView(
        **{
            "place": place,
            "position": shape(points),
            "velocity": np.tile(velocity, (len(points), 1)),
            "mass": mass,
            "strain_energy": np.zeros(len(points)),
            "stress": np.zeros(len(points)),
            "height": points[:, 2],
            "width": PARTICLE,
            "cell": CELL,
            "length": BAR_LENGTH,
            "speed": BAR_SPEED,
            "is_loaded": False,
            "references": (BAR_LENGTH, BAR_DIAMETER, BAR_DIAMETER),
            **changes,
        }
    )


def short_bar() -> BarView:
    """What is left of a bar that lost the rows on which its edges are read."""
    whole = bar()
    return without(whole, whole.place[:, 0] == whole.place[:, 0].max())


# Plates

PLATE = 40.0 * CELL  # thickness
PLATE_SPEED, PRESSURE, SHOCKED = 2000.0, 48e9, 1.25  # m/s, Pa, compression behind the shock
# M/s: mass behind a shock that stops at half the speed and compresses so.
SHOCK = 5.0 * 0.5 * PLATE_SPEED
IMPEDANCE = 35e6  # rho0 c0, Pa s/m


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
        thickness=PLATE,
        impedance=IMPEDANCE,
        cell=CELL,
        time=time,
        speed=PLATE_SPEED,
    )


LATE = 0.8 * PLATE / SHOCK  # the shock has run through 0.8 of each plate


def released_plates() -> PlateView:
    """Plates of which the outermost three cells of the target fly off at the impact speed, and ring by 50 m/s."""
    state = plates(LATE)
    below = PLATE - (state.layer + 0.5) * PARTICLE
    loose = (state.body == TARGET) & (below < 3.0 * CELL)
    ringing = PLATE_SPEED + np.where(state.layer % 2, 50.0, -50.0)
    return dataclasses.replace(state, velocity=np.where(loose, ringing, state.velocity))


# Histories


def pushed(rates: np.ndarray, interval: float = 1e-8) -> History:
    """A bar that is pushed at some rates (shares of its momentum per second), one in each interval."""
    times = interval * np.arange(rates.size + 1)
    momentum = -1.0 + np.concatenate([[0.0], np.cumsum(rates * interval)])
    return History(times, {rebound_momentum.name: momentum})


def rectangle(contact: float, end: float = 2e-6, interval: float = 1e-8) -> np.ndarray:
    """A constant push that turns the momentum round within a contact time, and then none."""
    times = interval * np.arange(round(end / interval) + 1)
    return np.diff(np.clip(times / contact, 0.0, 1.0)) * 2.0 / interval


def running(name: str, speed: float, *, placed: int = 21) -> History:
    """A front that runs evenly, of which the last ``known`` of 21 observations have a place."""
    times = 1e-7 * np.arange(21.0)
    path = np.where(np.arange(21) >= 21 - placed, speed * times, math.nan)
    return History(times, {f"{plate}_shock_front": path for plate in ("flyer", "target")})


def smeared(rates: np.ndarray) -> np.ndarray:
    """The same push from the first touch on, its end smeared evenly over 20 intervals."""
    return np.convolve(np.pad(rates, 10, mode="edge"), np.full(21, 1.0 / 21.0), mode="valid")


def surface(*velocities: float) -> History:
    """A free surface with velocities (m/s) at even times, and its acoustic stress."""
    values = np.array(velocities)
    stress = 0.5 * IMPEDANCE * values
    times = 1e-8 * np.arange(values.size)
    return History(times, {"free_surface_velocity": values, "acoustic_stress": stress})


# Debris

CLOUD_SPEED, CLOUD_DIAMETER = 6000.0, 8e-3  # m/s, m
MELTING = Melting(heat_capacity=400.0, room_temperature=300.0, melt_temperature=1300.0, latent_heat=200e3)


TOUGH = Breakup(DENSITY, sound_speed=4000.0, yield_stress=3e8, fracture_toughness=3e7, surface_tension=1.0)


def cloud(position: np.ndarray, velocity: np.ndarray, initial: np.ndarray | None = None, **changes: Any) -> CloudView:
    """Loose matter of the target at places (n, 3) about the z axis, each particle one cube of the lattice.

    Before the impact it was at ``initial`` (n, 3), by default where it is.
    """
    count = len(position)
    initial = position if initial is None else initial
    return CloudView(
        **{
            "radius": np.hypot(position[:, 0], position[:, 1]),
            "depth": position[:, 2],
            "initial_radius": np.hypot(initial[:, 0], initial[:, 1]),
            "initial_depth": initial[:, 2],
            "axial_velocity": velocity[:, 2],
            "transverse_velocity": np.hypot(velocity[:, 0], velocity[:, 1]),
            "mass": np.full(count, DENSITY * PARTICLE**3),
            "energy": np.zeros(count),
            "residual": np.zeros(count),
            "projectile": np.zeros(count, bool),
            "plate": np.zeros(count, bool),
            "fragment": connected(np.floor(position / CELL).astype(np.int64)),
            "copies": np.ones(count),
            "cell": CELL,
            "width": PARTICLE,
            "thickness": THICKNESS,
            "diameter": CLOUD_DIAMETER,
            "speed": CLOUD_SPEED,
            "breakup": (TOUGH, TOUGH),
            "melting": (MELTING, MELTING),
            **changes,
        }
    )


def ball(radius: float, middle: float) -> np.ndarray:
    """Places (n, 3) of a lattice ball about a place on the axis."""
    across = line(-radius, radius)
    points = np.stack(lattice(across, across, across), axis=-1)
    inside = (points**2).sum(axis=1) < radius**2
    return points[inside] + np.array([0.0, 0.0, middle])


# Settings and snapshots, as views ask for them


def setting_of_plate(kind: str, *, thickness: float = THICKNESS, radius: float = RADIUS, room: int = 8) -> Any:
    """What ``view`` asks a setting for, on a grid with ``room`` cells before and behind the plate."""
    flat = kind == "axisymmetric"
    cells, deep = round(radius / CELL), round(thickness / CELL) + 2 * room
    left, wide = (-radius, 2 * cells) if kind == "half" else (0.0, cells)
    lower = (0.0, -room * CELL, 0.0) if flat else (left, 0.0, -room * CELL)
    record = Axisymmetric if flat else Cartesian3D
    extent = (cells, deep, 0) if flat else (wide, cells, deep)
    return SimpleNamespace(
        problem=SimpleNamespace(
            geometry=grid(record, lower=lower, cells=extent, spacing=CELL),
            bodies=(body_of("target", DENSITY),),
            absorbers=(),
            arrivals=None,
        ),
        target="target",
        projectile_diameter=DIAMETER,
        thickness=thickness,
        radius=radius,
        sector={"axisymmetric": 1.0, "quarter": 0.5 * math.pi, "half": math.pi}[kind],
    )


def body_of(name: str, density: float, velocity: tuple[float, float, float] = (0.0, 0.0, 0.0)) -> Any:
    return SimpleNamespace(
        name=name, density=density, spacing=(PARTICLE,) * 3, velocity=np.array(velocity), mass=np.ones(1)
    )


def snapshot_of(particles: Particles) -> Snapshot:
    return Snapshot(0.0, 0, particles, np.zeros(particles.mass.size, np.int64))


# By what a measurement looks at.
STATES: dict[type, dict[str, Callable[[], Any]]] = {
    ImpactView: {
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
        "loaded": lambda: bar(is_loaded=True),
    },
    PlateView: {
        "before the touch": lambda: plates(0.0),
        "just met": lambda: plates(0.1 * LATE),
        "shocked": lambda: plates(LATE),
        "scattered": lambda: plates(LATE, scatter=0.05),
        "through": lambda: plates(1.3 * PLATE / SHOCK),
        "released": released_plates,
    },
    History: {
        "nothing yet": lambda: joined(pushed(np.zeros(0)), running("", 0.0, placed=0)),
        "rebound": lambda: joined(pushed(rectangle(1.2e-6)), running("", SHOCK)),
        "in contact": lambda: joined(pushed(rectangle(4e-6)), running("", SHOCK, placed=2)),
        "never touched": lambda: joined(pushed(np.zeros(200)), running("", SHOCK)),
    },
}


def joined(push: History, front: History) -> History:
    """Everything that any measurement follows, cut to the shortest history."""
    size = min(push.times.size, front.times.size)
    rise = 4e-3 * np.sin(np.linspace(0.0, 0.75 * math.pi, max(push.times.size, front.times.size)))
    values = {**push.values, **front.values, "crater_depth": rise, rear_face_place.name: BAR_LENGTH - rise}
    values |= {"middle_velocity": -1e5 * rise, "middle_stress": -1e12 * rise}
    values |= {"free_surface_velocity": 1e5 * rise, "acoustic_stress": 1e12 * rise}
    for followed in samples.offered("FOLLOWED"):
        values |= followed()
    return History(front.times[:size], {name: value[:size] for name, value in values.items()})


def states() -> dict[type, dict[str, Callable[[], Any]]]:
    """The states of all kinds, those of features included."""
    return samples.joined("STATES", STATES)


def looks_at(name: str) -> type:
    hints = get_type_hints(measurements.load(name).definition)
    (kind,) = (hint for argument, hint in hints.items() if argument != "return")
    return kind


def read(name: str, state: Any) -> Reading:
    return measurements.load(name).read(state)


def value(name: str, state: Any) -> float:
    reading = read(name, state)
    assert reading.flags == ()
    return reading.value


# Walls by depth: radius at the surface and depth of the floor are those of the scoop.
WALLS: dict[str, Callable[[float], float]] = {
    "cylinder": lambda z: CRATER,
    "hemisphere": lambda z: math.sqrt(CRATER**2 - z**2),
    "paraboloid": lambda z: CRATER * math.sqrt(1.0 - z / CRATER),
    "cone": lambda z: CRATER - 0.5 * z,
    "undercut": lambda z: CRATER + 0.3 * z,
}
TENTH = 0.1 * CELL
