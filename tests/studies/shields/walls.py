"""Shields and walls with a known answer: made walls after some changes, as each geometry shows them."""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from solver.state import MASS, STORED, VX, Arrivals, Particles, Snapshot, empty_table, records, views
from studies.shields.measurements.shield import ShieldView
from studies.shields.measurements.wall import WallView, wall_of
from tests.studies.debris.made import CLOUD_SPEED, ball, cloud
from tests.studies.measurements.states import (
    CELL,
    DENSITY,
    HOLE,
    PARTICLE,
    body_of,
    drilled_disc,
    lattice,
    line,
    setting_of_plate,
)

WALL, SPAN = 6e-3, 8e-3  # thickness and radius
PIT, SCAB = (2e-3, 2.5e-3), (2.5e-3, 2e-3)  # radius, and depth from the front or from the back, m
SPALL_SPEED = 400.0  # m/s
BULGE = 1.3e-3  # m
ASIDE = -3e-3  # m, from the middle of a half model's wall to that of its changes
AGE = 50e-6  # s, of the wall's stage
PIECE = 1e-6  # kg, of debris


def shield() -> ShieldView:
    """A shield in the stage of its bumper, which has a hole."""
    place = ball(1e-3, 20e-3)
    debris = cloud(place, np.full(place.shape, (0.0, 0.0, CLOUD_SPEED)))
    return ShieldView(None, 1.0, False, CELL, (drilled_disc(HOLE),), debris, missed=0.0, clock_ahead=0.0, attached=0.0)


class Moved(NamedTuple):
    """What has become of each particle of a wall: displacement (m) and velocity (m/s)."""

    normal: np.ndarray
    inwards: np.ndarray
    velocity: np.ndarray  # along the normal
    has_departed: np.ndarray
    has_failed: np.ndarray


Change = Callable[[np.ndarray, np.ndarray, Moved], None]  # of the radius and the depth at rest


def walled(
    *changes: Change, kind: str = "axisymmetric", coming: float = 0.0, held_back: bool = False, bounced: int = 0
) -> WallView:
    """A wall after some changes, as a geometry shows it, on a grid with three thicknesses before and behind it.

    Of two pieces of debris, in the model, as many as have ``bounced`` joined at the speed of spall and went back at it.
    A half model has its changes beside its middle.
    """
    flat, half = kind == "axisymmetric", kind == "half"
    across, along = line(0.0, SPAN), line(0.0, WALL)
    first = line(-SPAN, SPAN) if half else across
    position = np.stack(lattice(*((first, along, np.zeros(1)) if flat else (first, across, along))), axis=-1)
    axis, aside = 1 if flat else 2, ASIDE if half else 0.0
    radius, depth = np.hypot(position[:, 0] - aside, 0.0 if flat else position[:, 1]), position[:, axis]
    normal, inwards, velocity = np.zeros((3, depth.size))
    moved = Moved(normal, inwards, velocity, *np.zeros((2, depth.size), bool))
    for change in changes:
        change(radius, depth, moved)
    setting = setting_of_plate(kind, thickness=WALL, radius=SPAN, room=round(3.0 * WALL / CELL))
    body, debris = body_of("target", DENSITY), body_of("debris", DENSITY)
    body.position, body.mass, debris.mass = position, np.ones(depth.size), np.zeros(0)
    arrivals = Arrivals(np.array([-AGE, 0.0]), np.ones(2, np.int64), np.zeros((STORED + 1, 2)))
    arrivals.table[MASS], arrivals.table[VX + axis] = PIECE, SPALL_SPEED
    vars(setting.problem).update(
        bodies=(body, debris),
        arrivals=arrivals,
        faces=((0, 0),) * 3,
        particle_count=depth.size + arrivals.time.size,
        start_time=-AGE,
    )
    particles = views(empty_table(depth.size + bounced))
    particles.position[: depth.size] = position
    particles.position[: depth.size, axis] += moved.normal
    particles.position[: depth.size, :axis] *= (1.0 - moved.inwards / radius)[:, None]
    particles.velocity[: depth.size, axis] = moved.velocity
    particles.damage[: depth.size] = moved.has_failed
    particles.mass[: depth.size] = DENSITY * (radius * PARTICLE**2 if flat else PARTICLE**3)
    particles.position[depth.size :, axis] = -WALL
    particles.velocity[depth.size :, axis] = -SPALL_SPEED
    particles.mass[depth.size :] = PIECE
    body_number = (np.arange(depth.size + bounced) >= depth.size).astype(np.int64)
    gone = np.append(moved.has_departed, [True, False][:bounced]).astype(bool)
    departed = records(0.0, particles, body_number, np.flatnonzero(gone))
    particles = Particles(*(array[~gone] for array in particles))
    wall = wall_of(setting, Snapshot(0.0, 0, particles, body_number[~gone], departed))
    return WallView(wall, coming, held_back, CELL)


def pit(depth_of_pit: float = PIT[1]) -> Change:
    """A round crater with a flat floor, whose matter flew back."""

    def change(radius: np.ndarray, depth: np.ndarray, moved: Moved) -> None:
        mine = (radius < PIT[0]) & (depth < depth_of_pit)
        moved.has_departed[mine] = True
        moved.velocity[mine] = -SPALL_SPEED
        moved.normal[mine] = -2.0 * WALL

    change.__name__ = f"pit of {1e3 * depth_of_pit:g} mm"
    return change


def in_scab(radius: np.ndarray, depth: np.ndarray) -> np.ndarray:
    """Which particles stand in the slab at the back."""
    return (radius < SCAB[0]) & (depth > WALL - SCAB[1])


def scabbed(radius: np.ndarray, depth: np.ndarray, moved: Moved) -> None:
    """The slab came off and flies on: one half of it on the grid, the other departed."""
    mine = in_scab(radius, depth)
    moved.normal[mine] = WALL
    moved.velocity[mine] = SPALL_SPEED
    moved.has_departed[mine & (depth > WALL - 0.5 * SCAB[1])] = True


def parted(radius: np.ndarray, depth: np.ndarray, moved: Moved) -> None:
    """The slab bulges away from the rest, and hangs together with it at its edge."""
    mine = in_scab(radius, depth)
    moved.normal[mine] = 3.0 * CELL * np.clip((SCAB[0] - radius[mine]) / 1e-3, 0.0, 1.0)


def bulged(radius: np.ndarray, depth: np.ndarray, moved: Moved) -> None:
    """The wall stands back in its middle, nowhere thinner."""
    moved.normal[:] += BULGE * np.clip(2.0 - radius / 3e-3, 0.0, 1.0)


def moving(radius: np.ndarray, depth: np.ndarray, moved: Moved) -> None:
    """The middle moves on so fast that it would have gone two cells in the time of its stage."""
    moved.velocity[radius < 3e-3] = 2.0 * CELL / AGE


def drawn_in(radius: np.ndarray, depth: np.ndarray, moved: Moved) -> None:
    """The rim let go, and the wall has moved inwards there, in one piece."""
    moved.inwards[:] = 3.0 * CELL * np.clip(2.0 * radius / SPAN - 1.0, 0.0, 1.0)


def plugged_out(radius: np.ndarray, depth: np.ndarray, moved: Moved) -> None:
    """A plug flies on behind the wall."""
    mine = radius < PIT[0]
    moved.normal[mine] = WALL + 2.0 * CELL
    moved.velocity[mine] = SPALL_SPEED


def crushed(radius: np.ndarray, depth: np.ndarray, moved: Moved) -> None:
    """The matter of a plug has failed, and stands where it stood."""
    moved.has_failed[radius < PIT[0]] = True


def fallen_back(radius: np.ndarray, depth: np.ndarray, moved: Moved) -> None:
    """The plug comes back."""
    plugged_out(radius, depth, moved)
    moved.velocity[:] *= -1.0


def littered(radius: np.ndarray, depth: np.ndarray, moved: Moved) -> None:
    """In a crater a lump lies that is free, and moves on towards its floor."""
    mine = (radius < PIT[0] - 2.0 * CELL) & (depth < 2.0 * CELL)
    moved.has_departed[mine] = False
    moved.normal[mine] = 0.0
    moved.velocity[mine] = SPALL_SPEED
