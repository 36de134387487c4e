"""Samples of debris clouds for the tests that all measurements and scenarios share, and their states."""

import dataclasses
import math
from collections.abc import Callable
from typing import Any

import numpy as np
from scipy.optimize import brentq

from studies.debris.cloud import CloudView
from tests.samples import ANY, CYLINDER, DIAMETER, SHOT
from tests.studies.debris.made import CLOUD_SPEED, MELTING, ball, cloud
from tests.studies.measurements.states import DENSITY, PARTICLE, ROUND_OFF, TENTH, THICKNESS, lattice, line

BALLS = (2.5e-3, 30e-3, 3000.0), (2e-3, 45e-3, 5000.0)  # radius, middle (m), axial velocity (m/s)


def two_balls() -> CloudView:
    """Two separated spheres that fly along the axis; the first is the projectile's."""
    places = [ball(radius, middle) for radius, middle, _ in BALLS]
    speeds = [np.full((len(place), 3), (0.0, 0.0, speed)) for place, (_, _, speed) in zip(places, BALLS, strict=True)]
    first = np.repeat([True, False], [len(place) for place in places])
    return cloud(np.concatenate(places), np.concatenate(speeds), projectile=first)


RING = (12e-3, 15e-3, 30e-3, 33e-3)  # inner and outer radius, lower and upper place, m


def ring() -> CloudView:
    """A ring with a rectangular section, of circles of particles with the mass of their lengths."""
    inner, outer, lower, upper = RING
    radius, depth = lattice(line(inner, outer), line(lower, upper))
    places = np.stack([radius, np.zeros_like(radius), depth], axis=1)
    mass = DENSITY * 2.0 * math.pi * radius * PARTICLE**2
    return cloud(places, np.full((radius.size, 3), (0.0, 0.0, CLOUD_SPEED)), mass=mass)


EXPANSION, CENTRE_SPEED, EXPANDED = 2e5, 4000.0, 5e-3  # 1/s, m/s, m


def expanding_ball() -> CloudView:
    """A ball that expands evenly about a moving centre: each velocity is that of its place, scattered in its cube."""
    places = ball(EXPANDED, 30e-3)
    places += np.random.default_rng(1).uniform(-0.5, 0.5, places.shape) * PARTICLE
    velocity = EXPANSION * (places - np.array([0.0, 0.0, 30e-3]))
    return cloud(places, velocity + np.array([0.0, 0.0, CENTRE_SPEED]))


def capped(share: float) -> float:
    """Distance from the middle, over the radius, of the plane beyond which a share of a ball lies."""
    height = brentq(lambda h: 0.25 * h**2 * (3.0 - h) - share, 0.0, 2.0)
    return float(1.0 - height)


def quarter_balls() -> Any:
    """Each ball of a quarter that touches no plane is one of four."""
    state = two_balls()
    copies = np.where(state.projectile, 4.0, 1.0)
    return dataclasses.replace(state, copies=copies, mass=state.mass * copies)


MASSES = [float(two_balls().mass[two_balls().projectile == first].sum()) for first in (True, False)]
SPEEDS = [speed for _, _, speed in BALLS]
WEIGHED = list(zip(MASSES, SPEEDS, strict=True))
MOMENTUM, KINETIC = sum(m * v for m, v in WEIGHED), sum(0.5 * m * v**2 for m, v in WEIGHED)
# The radius and the length of the ring that a hundredth of its mass exceeds.
INNER, OUTER, LOWER, UPPER = RING
RING_RADIUS = math.sqrt(OUTER**2 - 0.01 * (OUTER**2 - INNER**2))
RING_LENGTH = UPPER - 0.01 * (UPPER - LOWER) - THICKNESS

STATES: dict[type, dict[str, Callable[[], Any]]] = {
    CloudView: {
        "two balls": two_balls,
        "ring": ring,
        "expanding": expanding_ball,
        "nothing behind": lambda: dataclasses.replace(two_balls(), thickness=1.0),
        "joined": lambda: dataclasses.replace(two_balls(), plate=two_balls().projectile),
        "never melts": lambda: dataclasses.replace(two_balls(), melting=("never_melts", MELTING)),
    }
}
# Measurement, state, value, and how far off the reading may be; or why there is no value.
KNOWN: list[tuple[str, Callable[[], Any], float, float]] = [
    ("mass_behind", two_balls, sum(MASSES), ROUND_OFF * sum(MASSES)),
    ("momentum_behind", two_balls, MOMENTUM, ROUND_OFF * MOMENTUM),
    ("kinetic_energy_behind", two_balls, KINETIC, ROUND_OFF * KINETIC),
    *((f"{name}_before", two_balls, 0.0, 0.0) for name in ("mass", "momentum", "kinetic_energy", "internal_energy")),
    *((f"tip_velocity_{share}", two_balls, SPEEDS[1], ROUND_OFF * SPEEDS[1]) for share in ("percent", "permille")),
    ("rear_velocity", two_balls, SPEEDS[0], ROUND_OFF * SPEEDS[0]),
    ("largest_fragment", two_balls, max(MASSES), ROUND_OFF * max(MASSES)),
    ("fragments", quarter_balls, 5.0, 0.0),
    ("largest_fragment", quarter_balls, max(MASSES), ROUND_OFF * max(MASSES)),
    ("cloud_radius", ring, RING_RADIUS, TENTH),
    ("cloud_radius_place", ring, 0.5 * (LOWER + UPPER) - THICKNESS, TENTH),
    ("cloud_length", ring, RING_LENGTH, TENTH),
    ("cloud_length_over_diameter", ring, 0.5 * RING_LENGTH / RING_RADIUS, 0.5 * RING_LENGTH * TENTH / RING_RADIUS**2),
    *(
        (f"tip_velocity_{name}", expanding_ball, CENTRE_SPEED + EXPANSION * EXPANDED * capped(of), EXPANSION * TENTH)
        for name, of in (("percent", 0.01), ("permille", 0.001))
    ),
]
NO_VALUE: list[tuple[str, Callable[[], Any], str]] = [
    *(
        (name, lambda: dataclasses.replace(two_balls(), melting=("never_melts", two_balls().melting[1])), "never_melts")
        for name in ("melted_share_projectile", "melted_share_behind")
    ),
    *(
        (name, lambda: dataclasses.replace(two_balls(), thickness=1.0), "nothing_behind")
        for name in ("tip_velocity_percent", "rear_velocity", "cloud_length", "largest_fragment")
    ),
]


def _spheres() -> dict[str, tuple[float, float]]:
    """Masses of whole balls, as far off as with another tenth of a cell, and the plane that 1 % of the mass exceeds."""
    masses = [4.0 / 3.0 * math.pi * radius**3 * DENSITY for radius, _, _ in BALLS]
    shells = [4.0 * math.pi * radius**2 * DENSITY * TENTH for radius, _, _ in BALLS]
    radius, middle, _ = BALLS[1]
    plane = middle + capped(0.01 * sum(masses) / masses[1]) * radius
    return {
        "fragments": (2.0, 0.0),
        "largest_fragment": (max(masses), max(shells)),
        "mass_behind": (sum(masses), sum(shells)),
        "cloud_length": (plane - THICKNESS, TENTH),
    }


SHAPES = {"two separated spheres": (lambda per_cell=1: two_balls(), _spheres())}

SMALL = {"debris_cloud": {**SHOT, "plate_thickness": 4e-3, "plate_radius": 1.5 * DIAMETER}}
VARIED = [
    (
        ("debris_cloud",),
        (
            *ANY,
            {"geometry": "quarter", "debris": "retire"},
            {"geometry": "half", "edges": "fixed"},
            {**CYLINDER, "end_time": 1e-5},
        ),
    )
]
# Some of its debris departs.
SOLVED = {
    "debris_cloud": {
        "plate_thickness": 2e-3,
        "plate_radius": 16e-3,
        "end_time": 4e-6,
        "speed": 6000.0,
        "cells_per_diameter": 6.0,
        "downrange": 0.5,
    }
}
CASES = {"debris cloud": ("debris_cloud", {"projectile": "al-6061-t6", "target": "al-6061-t6"})}
REFUSED = [("debris_cloud", {"contact": "repulsion"}, "parameters.contact", "repulsion")]
