"""Samples of plugging for the tests that all measurements and scenarios share, and their states."""

import dataclasses
import math
from collections.abc import Callable
from typing import Any

import numpy as np

from studies.measurements import History
from studies.plugs.plug import PlugView
from tests.samples import ANY
from tests.studies.measurements.states import CELL, PARTICLE, lattice, line

STEEL = 7850.0
PUNCH, PUNCHED, PUNCHED_TO = 20e-3, 12e-3, 60e-3  # diameter of the projectile, thickness and radius of the plate
FRONT, REAR = 10.3e-3, 11.1e-3  # radii of the hole at the faces
PUSHER, PLUG = 200.0, 240.0  # velocities of projectile and plug, m/s
DISHED = 1.5e-3


def plugged(*, free: bool = True, is_open: bool = True, speed: float = PUSHER, plate: float = 10.0) -> PlugView:
    """A dished plate, a plug with a tenth of it failed and flying along, and a projectile behind it."""
    hole = 0.5 * (FRONT + REAR)
    parts = [
        lattice(line(inner, outer), line(low, high))
        for inner, outer, low, high in (
            (FRONT, PUNCHED_TO, 0.0, 0.5 * PUNCHED),
            (REAR, PUNCHED_TO, 0.5 * PUNCHED, PUNCHED),
            (0.0, 0.9 * hole, 0.0, PUNCHED),
            (0.9 * hole, hole, 0.0, PUNCHED),
            (0.0, 0.5 * PUNCH, -80e-3, 0.0),
        )
    ]
    of = np.repeat(np.arange(len(parts)), [part[0].size for part in parts])
    radius, origin = (np.concatenate(each) for each in zip(*parts, strict=True))
    moved = np.array([DISHED, DISHED, 30e-3, 30e-3, 25e-3])
    core = (of == 2) & free
    return PlugView(
        radius=radius,
        depth=origin + moved[of],
        origin=origin,
        velocity=np.array([plate, plate, PLUG, PLUG, speed])[of],
        mass=2.0 * math.pi * STEEL * radius * PARTICLE**2,
        projectile=of == 4,
        attached=(of < 2) | ((of == 2) & (not is_open)),
        core=core,
        plug=core | ((of == 3) & free),
        cell=CELL,
        width=PARTICLE,
        density=STEEL,
        thickness=PUNCHED,
        plate_radius=PUNCHED_TO,
        projectile_diameter=PUNCH,
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


CYLINDER = STEEL * math.pi * (0.5 * (FRONT + REAR)) ** 2 * PUNCHED  # mass of the plug


def followed() -> dict[str, np.ndarray]:
    """What measurements of plugging follow."""
    return dict(slowed(5e-6).values)


FOLLOWED = followed
STATES: dict[type, dict[str, Callable[[], Any]]] = {
    PlugView: {
        "through": plugged,
        "stuck": lambda: plugged(free=False, is_open=False, speed=0.0),
        "in it": lambda: plugged(free=False, is_open=False),
    }
}
# Measurement, state, value, and how far off the reading may be; or why there is no value, or a flag beside it.
KNOWN: list[tuple[str, Callable[[], Any], float, float]] = [
    ("hole_diameter_front", plugged, 2.0 * FRONT, PARTICLE),
    ("hole_diameter_rear", plugged, 2.0 * REAR, PARTICLE),
    ("dishing", plugged, DISHED, 1e-6 * DISHED),
    ("plug_mass", plugged, CYLINDER, CYLINDER * PARTICLE / FRONT),
    ("plug_velocity", plugged, PLUG, 1e-6 * PLUG),
    ("plug_separation", lambda: slowed(7e-6), 120e-6, 200e-6 / 160),  # to the interval between observations
    ("perforated", plugged, 1.0, 0.0),
    ("perforated", lambda: plugged(speed=-1.0), 0.0, 0.0),
    ("perforated", lambda: plugged(is_open=False, speed=9.0), 0.0, 0.0),
    # A plate that springs back may be faster than a projectile that rebounds.
    ("perforated", lambda: plugged(is_open=False, speed=-5.0, plate=-20.0), 0.0, 0.0),
    ("residual_velocity", lambda: slowed(7e-6), 0.7 * PUSHER, 1e-6 * PUSHER),
    ("residual_velocity", lambda: slowed(7e-6, perforated=0.0), 0.0, 0.0),
    *(("first_contact", lambda t=t: slowed(t), t, 1e-12) for t in (7.0e-6, 7.6e-6, 8.74e-6)),
]
NO_VALUE: list[tuple[str, Callable[[], Any], str]] = [
    ("hole_diameter_front", lambda: dataclasses.replace(plugged(), projectile_diameter=0.4 * FRONT), "not_contained"),
    ("plug_mass", lambda: plugged(free=False), "no_plug"),
    ("plug_separation", lambda: slowed(7e-6, freed=201e-6), "no_plug"),
    ("perforated", lambda: plugged(is_open=False, speed=11.0), "undecided"),
    ("residual_velocity", lambda: slowed(7e-6, perforated=math.nan), "undecided"),
]
DOUBTED: list[tuple[str, Callable[[], Any], str]] = [
    ("residual_velocity", lambda: slowed(7e-6, end=110e-6), "in_contact")
]

SMALL = {"plugging": {"speed": 300.0, "cells_per_diameter": 10.0, "plate_radius": 30e-3}}
NOSES: tuple[dict[str, Any], ...] = (
    *ANY,
    {"nose": "conical"},
    {"nose": "conical", "nose_length": 80e-3, "gap": 0.0},
    {"nose": "hemispherical", "offset": 0.5, "contact": "none"},
    {"speed": 2000.0},
)
UNBROKEN = {"failure": "none", "thermal_softening": False}
COMPILED_ALONE: tuple[tuple[str, dict[str, Any]], ...] = (
    *(("plugging", changes) for changes in NOSES),
    ("plugging", {"geometry": "quarter", "nose": "hemispherical", "shape": "quadratic-bspline", **UNBROKEN}),
    ("plugging", {"projectile": "arne-bilinear", "target": "weldox-460-e-2002", "failure": "johnson-cook"}),
)
FAST = {"speed": 2000.0, "projectile_length": 20e-3, "plate_thickness": 4e-3, "plate_radius": 45e-3, "end_time": 1.2e-5}
APART = {"geometry": "quarter", "gap": 4e-3}  # beyond the reach of repulsion
CASES = {
    "plugging": ("plugging", FAST),
    "plugging, sph": ("plugging", {**FAST, **APART, "method": "sph"}),
    "plugging, sph-fem": ("plugging", {**FAST, **APART, "method": "sph-fem"}),
}
LONG = set(CASES)
# Particles that repel each other begin farther apart, and their plate has room for elements.
SMOOTHED = {"plugging": {"plate_radius": 40e-3, "gap": 4e-3}}

COUPLED = {"geometry": "quarter", "method": "sph-fem", "plate_radius": 40e-3, "gap": 3e-3}


def of_method(method: str, name: str, **changes: Any) -> tuple[str, dict[str, Any], str, str]:
    return "plugging", {**COUPLED, "method": method, **changes}, name, f"method {method}"


BOILING = dict.fromkeys(("projectile", "target"), "copper-ofhc-tillotson")
REFUSED: list[tuple[str, dict[str, Any], str, str]] = [
    # What a method does not compute.
    *(
        of_method(method, name, **{name: value})
        for method in ("sph", "sph-fem")
        for name, value in (
            ("geometry", "axisymmetric"),
            ("contact", "bardenhagen"),
            ("scheme", "usl"),
            ("damping_rate", 1e6),
        )
    ),
    # Bodies that repel each other.
    ("plugging", {"contact": "repulsion"}, "contact", "material points"),
    ("plugging", {**COUPLED, "gap": 2e-3}, "gap", "at least 0.003 m, .*; enlarge the gap"),
    ("plugging", {**COUPLED, "plate_radius": 25e-3}, "plate_radius", "0.028 m"),
    *(
        ("plugging", {**BOILING, "failure": "none", **change}, next(iter(change)), "would boil")
        for change in ({"tension": "unlimited"}, {"thermal_softening": False})
    ),
    ("plugging", {"nose_length": 1e-3}, "nose_length", "no length of a blunt nose"),
    ("plugging", {"nose": "conical", "nose_length": 0.1}, "projectile_length", "lengthen the projectile"),
    ("plugging", {"plate_thickness": 1e-3}, "plate_thickness", "at least two cells"),
]
