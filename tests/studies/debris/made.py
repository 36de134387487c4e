"""Debris clouds of particles with known places and velocities."""

from typing import Any

import numpy as np

from studies.debris.breakup import Breakup
from studies.debris.cloud import CloudView
from studies.debris.setting import Melting
from studies.measurements.impact.view import connected
from tests.studies.measurements.states import CELL, DENSITY, PARTICLE, THICKNESS, lattice, line

CLOUD_SPEED, CLOUD_DIAMETER = 6000.0, 8e-3  # m/s, m
MELTING = Melting(onset=400e3, heat=200e3)


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
