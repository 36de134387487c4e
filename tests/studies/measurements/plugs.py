"""States of a plugging with a known answer: a plate with a plug in it, cut out of it, and half cut."""

import math

import numpy as np

from studies.measurements import History
from studies.measurements._plug import PlugView

STEEL = 7850.0
CELL = 0.5e-3
PARTICLE = 0.5 * CELL  # spacing
DIAMETER, THICKNESS, PLATE = 20e-3, 12e-3, 60e-3  # PLATE: radius
FRONT, REAR = 10.3e-3, 11.1e-3  # radii of the hole at the faces
PUSHER, FLYER = 200.0, 240.0  # velocities of projectile and plug, m/s
DISHED = 1.5e-3


def _ring(inner: float, outer: float, low: float, high: float) -> tuple[np.ndarray, np.ndarray]:
    """Particles between two radii, from the outer one inwards, and two depths."""
    across = outer - PARTICLE * (np.arange(round((outer - inner) / PARTICLE)) + 0.5)
    along = low + PARTICLE * (np.arange(round((high - low) / PARTICLE)) + 0.5)
    radius, depth = np.meshgrid(across, along, indexing="ij")
    return radius.ravel(), depth.ravel()


def plugged(*, free: bool = True, is_open: bool = True, speed: float = PUSHER, plate: float = 10.0) -> PlugView:
    """A dished plate, a plug with a tenth of it failed and flying along, and a projectile behind it."""
    hole = 0.5 * (FRONT + REAR)
    upper = _ring(FRONT, PLATE, 0.0, 0.5 * THICKNESS)
    lower = _ring(REAR, PLATE, 0.5 * THICKNESS, THICKNESS)
    plug = _ring(0.0, 0.9 * hole, 0.0, THICKNESS)
    skin = _ring(0.9 * hole, hole, 0.0, THICKNESS)
    projectile = _ring(0.0, 0.5 * DIAMETER, -80e-3, 0.0)
    parts = (upper, lower, plug, skin, projectile)
    of = np.repeat(np.arange(len(parts)), [part[0].size for part in parts])
    radius, origin = (np.concatenate(each) for each in zip(*parts, strict=True))
    moved = np.array([DISHED, DISHED, 30e-3, 30e-3, 25e-3])
    core = (of == 2) & free
    return PlugView(
        radius=radius,
        depth=origin + moved[of],
        origin=origin,
        velocity=np.array([plate, plate, FLYER, FLYER, speed])[of],
        mass=2.0 * math.pi * STEEL * radius * PARTICLE**2,
        projectile=of == 4,
        attached=(of < 2) | ((of == 2) & (not is_open)),
        core=core,
        plug=core | ((of == 3) & free),
        cell=CELL,
        width=PARTICLE,
        density=STEEL,
        thickness=THICKNESS,
        plate_radius=PLATE,
        projectile_diameter=DIAMETER,
    )


def slowed(touch: float, *, perforated: float = 1.0, end: float = 200e-6, freed: float = 120e-6) -> History:
    """A projectile that slows down evenly from the touch until its plug is free."""
    times = np.linspace(0.0, end, 161)
    lost = np.clip((times - touch) / (freed - touch), 0.0, 1.0) * 0.3
    return History(
        times,
        {
            "projectile_velocity": PUSHER * (1.0 - lost),
            "perforated": np.full(times.size, perforated),
            "plug_mass": np.where(times < freed, math.nan, 29.6e-3),
        },
    )
