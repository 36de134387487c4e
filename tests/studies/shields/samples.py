"""Shields for the tests that all laws, measurements and scenarios share, and a question."""

import math
from collections.abc import Callable
from typing import Any

from studies.laws import Law, Shot
from studies.shields.measurements.shield import ShieldView
from studies.shields.measurements.wall import WallView
from studies.shields.shield import CRITICAL_DIAMETER, FurtherBumper, Shield, at_shield
from tests.samples import ANY, CYLINDER, DIAMETER, SHOT
from tests.studies.measurements.states import CELL, PARTICLE
from tests.studies.shields.walls import (
    WALL,
    bulged,
    drawn_in,
    moving,
    parted,
    pit,
    plugged_out,
    scabbed,
    shield,
    walled,
)


def _shield(law: Law, scale: float = 1.0) -> Shield:
    """A shield, all lengths times a scale; with a second bumper for a law that is about three walls."""
    further = (FurtherBumper(1e-3 * scale, 0.05 * scale),) if law.name.endswith("three_walls") else ()
    return Shield(2e-3 * scale, 4e-3 * scale, 0.1 * scale, 345e6, further_bumpers=further)


def _at_shield(law: Law, shot: Shot, scale: float) -> Shot:
    return at_shield(shot, _shield(law, scale))


def _arguments(law: Law) -> tuple[float, float, Shield]:
    return 2700.0, 2800.0, _shield(law)


LAW_SHOTS = {CRITICAL_DIAMETER: _at_shield}  # by the quantity of laws: of a shot at the bumper
FORMULA_ARGUMENTS = {CRITICAL_DIAMETER: _arguments}  # behind the speed
# To laws and shots.
QUESTION = {
    "speed": "7 km/s",
    "projectile": "al-2017-t4",
    "projectile_diameter": "5 mm",
    "bumper": "al-6061-t6",
    "bumper_thickness": "1.2 mm",
    "stand_off": "10 cm",
    "wall_thickness": "3.2 mm",
    "wall_yield_stress": "275.8 MPa",
}

Build = Callable[[], Any]
STATES: dict[type, dict[str, Build]] = {
    ShieldView: {"bumper": shield},
    WallView: {
        "before": lambda: WallView(None, 1.0, False, CELL),
        "whole": walled,
        "reached": lambda: walled(coming=0.5),
        "pitted and bulged": lambda: walled(pit(), bulged),
        "scabbed": lambda: walled(pit(), scabbed),
        "parted": lambda: walled(pit(), parted),
        "drilled": lambda: walled(pit(WALL)),
        "plugged out": lambda: walled(plugged_out),
        "filmed": lambda: walled(pit(WALL - PARTICLE)),
        "let go": lambda: walled(pit(), drawn_in),
        "torn": lambda: walled(lambda radius, depth, moved: moved.has_departed.fill(True)),
    },
}
# Measurement, state, flag: without a value, and with one.
NO_VALUE: list[tuple[str, Build, str]] = [
    ("wall_perforated", lambda: WallView(None, 1.0, False, CELL), "not_reached"),
    ("wall_hole_diameter", walled, "not_perforated"),
    *((f"wall_spall_{name}", lambda: walled(pit()), "no_spall") for name in ("diameter", "velocity")),
]
DOUBTED: list[tuple[str, Build, str]] = [
    *((name, lambda: walled(pit(WALL - PARTICLE)), "closed_by_film") for name in ("wall_perforated", "wall_failed")),
    *((f"wall_{name}", lambda: walled(coming=0.011), "still_coming") for name in ("perforated", "failed", "bulge")),
    *((f"wall_{name}", lambda: walled(held_back=True), "still_attached") for name in ("perforated", "failed")),
    *(
        ("wall_bulge", lambda c=changes: walled(*c), flag)
        for changes, flag in (((bulged,), ""), ((bulged, moving), "still_moving"))
    ),
    *((f"wall_{name}", lambda: walled(drawn_in), "rim_moved") for name in ("perforated", "bulge", "detached_spall")),
    # Nothing that is still to come closes a hole.
    *((f"wall_{name}", lambda: walled(pit(WALL), coming=0.5), "") for name in ("perforated", "failed")),
]

SMALL = {
    "whipple_shield": {
        **{name: value for name, value in SHOT.items() if name != "target"},
        "bumper": "copper-ofhc",
        "wall": "copper-ofhc",
        "bumper_thickness": 4e-3,
        "bumper_radius": 1.5 * DIAMETER,
        "stand_off": 4.0 * DIAMETER,
        "wall_thickness": 4e-3,
        "wall_radius": 2.0 * DIAMETER,
    }
}
VARIED = [
    (
        ("whipple_shield",),
        (
            *ANY,
            {"geometry": "quarter", "edges": "free"},
            {**CYLINDER, "wall_thickness": 40e-3},
            {"bumper_2": "al-2024-t3", "bumper_2_thickness": 2e-3, "bumper_2_stand_off": 4.0 * DIAMETER},
            {"geometry": "half", **CYLINDER, "obliquity": math.radians(40.0), "yaw": math.radians(-15.0)},
        ),
    )
]
CASES = {"Whipple shield": ("whipple_shield", {"speed": 6000.0, "uprange": 1.0, "end_time": 8e-6, "wall_time": 8e-6})}
# Of a perforated bumper and a wall that is perforated and spalls: seconds of a run, and made states have them.
OF_LONGER_RUNS = {"bumper_hole_diameter", "wall_hole_diameter", "wall_spall_diameter", "wall_spall_velocity"}
