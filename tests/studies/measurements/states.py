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
from studies.measurements.impact.view import ImpactView
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
            **dict.fromkeys(("target", "attached", "attached_target"), whole),
            "cell": CELL,
            **dict.fromkeys(("radial_width", "axial_width"), PARTICLE),
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
    radius, depth = lattice(line(0.0, HOLE / stretch), line((1.0 - left) * THICKNESS, THICKNESS))
    mass = np.append(disc.mass, DENSITY * radius * PARTICLE**2)
    places = np.append(disc.radius, stretch * radius), np.append(disc.depth, depth)
    return impact(*places, thickness=THICKNESS, breadth=RADIUS, mass=mass)


def lipped_disc(hole: float, crest: float) -> ImpactView:
    """A drilled disc whose entry side carries one ring of particles, two particles above the face."""
    return with_particle(drilled_disc(hole), crest, -2.0 * PARTICLE)


def collared_disc(hole: float, *, inwards: float, depth: float) -> ImpactView:
    """A drilled disc with a solid collar, a cell high, that stands into the hole."""
    disc = drilled_disc(hole)
    for place in line(depth, depth + CELL):
        for radius in line(hole - inwards, hole):
            disc = with_particle(disc, float(radius), float(place))
    return disc


def with_particle(state: ImpactView, radius: float, depth: float) -> ImpactView:
    """One more particle of the target, which touches the rest."""
    added = {"radius": radius, "depth": depth, "mass": DENSITY * radius * PARTICLE**2, "speed": 0.0, "sector": 0}
    added |= dict.fromkeys(("target", "attached", "attached_target"), True)
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
    History: {"nothing yet": lambda: followed(1), "at the end": lambda: followed()},
}


def followed(most: int | None = None) -> History:
    """Everything that any measurement follows, cut to the shortest history, or to the first observations."""
    values = {"crater_depth": 4e-3 * np.sin(np.linspace(0.0, 0.75 * math.pi, 201))}
    for each in samples.offered("FOLLOWED"):
        values |= each()
    size = min(most or values["crater_depth"].size, *(value.size for value in values.values()))
    return History(1e-7 * np.arange(size), {name: value[:size] for name, value in values.items()})


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
