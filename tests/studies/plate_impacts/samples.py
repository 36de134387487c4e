"""Samples of plate impacts for the tests that all measurements and scenarios share, and their states."""

import dataclasses
import math
from collections.abc import Callable
from typing import Any

import numpy as np

from studies.measurements import History
from studies.plate_impacts.plates import FLYER, TARGET, PlateView
from tests.samples import ANY
from tests.studies.measurements.states import CELL, DENSITY, PARTICLE, ROUND_OFF, line

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


def running(name: str, speed: float, *, placed: int = 21) -> History:
    """A front that runs evenly, of which the last ``known`` of 21 observations have a place."""
    times = 1e-7 * np.arange(21.0)
    path = np.where(np.arange(21) >= 21 - placed, speed * times, math.nan)
    return History(times, {f"{plate}_shock_front": path for plate in ("flyer", "target")})


def surface(*velocities: float) -> History:
    """A free surface with velocities (m/s) at even times, and its acoustic stress."""
    values = np.array(velocities)
    stress = 0.5 * IMPEDANCE * values
    times = 1e-8 * np.arange(values.size)
    return History(times, {"free_surface_velocity": values, "acoustic_stress": stress})


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


def slow_start() -> History:
    """A front that ran slower in the first third of the time."""
    history = running("target", 5000.0)
    history.values["target_shock_front"][:8] *= 0.3
    return history


def followed() -> dict[str, np.ndarray]:
    """What measurements of plates follow, while the shocks run."""
    rise = 4e-3 * np.sin(np.linspace(0.0, 0.75 * math.pi, 21))
    own = {"free_surface_velocity": 1e5 * rise, "acoustic_stress": 1e12 * rise}
    return own | dict(running("", SHOCK).values)


FOLLOWED = followed

# Up with ripples below the recovery, down, up again; then a deeper minimum that is not the first.
SPALLED = (0.0, 20.0, 190.0, 200.0, 197.5, 201.0, 199.0, 170.0, 150.0, 152.0, 165.0, 180.0, 120.0, 160.0)

BEHIND = SHOCKED * DENSITY
STATES: dict[type, dict[str, Callable[[], Any]]] = {
    PlateView: {
        "before the touch": lambda: plates(0.0),
        "just met": lambda: plates(0.1 * LATE),
        "shocked": lambda: plates(LATE),
        "scattered": lambda: plates(LATE, scatter=0.05),
        "through": lambda: plates(1.3 * PLATE / SHOCK),
        "released": released_plates,
    }
}
KNOWN: list[tuple[str, Callable[[], Any], float, float]] = [
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
]
NO_VALUE: list[tuple[str, Callable[[], Any], str]] = [
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
]

SMALL = {"plate_impact": {"flyer_thickness": 4e-3, "cells_per_thickness": 20.0}}
RESOLUTION = {"plate_impact": ("cells_per_thickness", "cells_per_thickness")}
DIMENSIONS = {"plate_impact": 1}  # the column stays one cell wide
VARIED: list[tuple[tuple[str, ...], tuple[dict[str, Any], ...]]] = [
    (("plate_impact",), ANY),
    (
        ("plate_impact",),
        (
            {"geometry": "axisymmetric"},
            {"cells_across": 3},
            {"cells_per_thickness": 10.0},
            {"cells_per_thickness": 300.0},
            {"target_thickness": 9e-3},
            {"flyer": "al-2024-t3"},
            {"target": "al-2024-t3"},
            {"speed": 20e3},
            {"speed": 1.0},
        ),
    ),
]
COMPILED_ALONE = (("plate_impact", {"strength": "material", "eos_form": "cubic"}),)
CASES: dict[str, tuple[str, dict[str, Any]]] = {
    "plate impact": ("plate_impact", {}),
    # Until the tensile floor has pulled back the free surface.
    "plate impact, released": ("plate_impact", {"strength": "material", "target_thickness": 8e-3, "end_time": 5.2e-6}),
}
LONG = {"plate impact, released"}
SOLVED = {"plate_impact": {"flyer_thickness": 10e-3, "cells_per_thickness": 40.0}}
REFUSED: list[tuple[str, dict[str, Any], str, str]] = [
    ("plate_impact", {"contact": "repulsion"}, "parameters.contact", "repulsion"),
    ("plate_impact", {"target_thickness": 1e-3}, "target_thickness", "at least ten cells"),
    ("plate_impact", {"flyer": "copper-ofhc-tillotson"}, "flyer", "use mie-grueneisen"),
    ("plate_impact", {"target": "armco-iron", "failure": "spall-rate"}, "failure", "choose another failure"),
]
