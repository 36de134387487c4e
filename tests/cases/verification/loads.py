"""Loads from outside: a pressure on the end of a column and of a bar, and free fall; their work is what they bring."""

import math
from collections.abc import Iterator
from itertools import pairwise
from typing import Any

import numpy as np

from solver.problem import Traction
from solver.simulation import Outcome, simulate
from studies.quantities.numerical_defaults import Recipe
from tests.cases.verification import case
from tests.cases.verification.setups.column import Stretch, column, plateau, profile
from tests.cases.verification.setups.matter import elastic
from tests.cases.verification.setups.runs import executed
from tests.cases.verification.solutions.waves import COPPER
from tests.claims.rows import Row, relative, zero

SPACING = 1e-3  # m
CELLS, ROOM = 120, 4  # of the column, and beside each end
PRESSURE = 0.4e9  # Pa
RISE, PULSE = 0.5e-6, 10e-6  # s
READ = 16e-6  # s: the pulse then stands between a sixth and two thirds of the column
FALL = 9.81, 50e-6  # m/s2 and s

# The square bar, as the scenario ``elastic_bar`` has it: one-dimensional, for its Poisson's ratio is 0.
BAR: dict[str, Any] = {
    "section": "square",
    "geometry": "quarter",
    "poisson_ratio": 0.0,
    "young_modulus": 100e9,
    "density": 8900.0,
    "bar_length": 40e-3,
    "bar_diameter": 4e-3,
    "cells_per_diameter": 4.0,
    "speed": 0.0,
}
BAR_RISE = 1e-6  # s
# Of the time 2 L / c in which the wave comes back: where its plateau is read, and the end of the run.
BAR_PLATEAU, BAR_END = (0.25, 0.9), 1.9

# Asked before any run: the linear theory holds to p / (rho c^2), 2 parts in 1000 here. So was a momentum to 1e-6, which
# the node areas do not give: 1e-5 with splines and 0.2 % with linear shapes, once the end lies off the nodes. It is
# reported. The end of the bar was first read off the velocities of its last particles, 2.7 % low; its motion is exact
# to 0.6 %, as that of the column (``studies/bars/measured.py``).
ARRIVES, BALANCE, ROUND_OFF = 0.02, 1e-10, 1e-12


@case(
    "loads",
    says="a confined pressure pulse moves matter at p / (rho c_L), a pressed bar its end at p / (rho c), matter falls "
    "freely to round-off, and the work of loads closes the balance of energy",
    source="d'Alembert; Galilei; energy balance of the discrete step",
)
def _run(recipe: Recipe) -> Iterator[Row]:
    yield from _pulse(recipe)
    yield from _fall(recipe)
    yield from _pressed_bar(recipe)
    yield from _falling_bar(recipe)


def _pulse(recipe: Recipe) -> Iterator[Row]:
    """A pulse of uniaxial strain: matter in it moves at p / (rho c_L)."""
    c = COPPER.longitudinal_speed
    begin = ROOM * SPACING
    load = Traction(
        0,
        axis=0,
        side=0,
        time=np.array([0.0, RISE, PULSE, PULSE + RISE]),
        pressure=PRESSURE * np.array([0.0, 1.0, 1.0, 0.0]),
    )
    outcome = _computed(recipe, READ, tractions=(load,))
    line = profile(outcome.snapshot, 0)
    low, high = begin + c * (READ - PULSE), begin + c * (READ - RISE)
    inside = line.part((line.place > low) & (line.place < high))
    level = plateau(inside, SPACING, low, high)
    yield relative(
        "pulse of 0.4 GPa: velocity p / (rho c_L) (m/s)",
        expected=PRESSURE / (COPPER.density * c),
        got=level.velocity,
        within=ARRIVES,
    )
    yield relative("its stress (GPa)", expected=0.4, got=level.stress / 1e9, within=ARRIVES)
    momentum = float((line.mass * line.velocity).sum())
    yield relative(
        "its momentum, pressure times section and time (N s)", expected=PRESSURE * SPACING**2 * PULSE, got=momentum
    )
    yield relative(
        "work of the pulse, p v over section and time (J)",
        expected=PRESSURE**2 / (COPPER.density * c) * SPACING**2 * (PULSE - RISE / 3.0),
        got=outcome.audit.exchanged.worked,
        within=ARRIVES,
    )
    yield _balance("pulse", outcome)


def _fall(recipe: Recipe) -> Iterator[Row]:
    """Matter in free fall: v = g t, and no stress."""
    gravity, time = FALL
    outcome = _computed(recipe, time, gravity=(gravity, 0.0, 0.0))
    line = profile(outcome.snapshot, 0)
    speed = gravity * outcome.audit.time
    yield zero(
        "free fall: largest difference from g t (of it)",
        got=float(np.abs(line.velocity / speed - 1.0).max()),
        within=ROUND_OFF,
    )
    yield zero(
        "free fall: largest stress (of rho v^2)",
        got=float(np.abs(line.stress).max()) / (COPPER.density * COPPER.longitudinal_speed**2),
        within=ROUND_OFF,
    )
    kinetic = 0.5 * float(line.mass.sum()) * speed**2
    yield zero(
        "free fall: work minus kinetic energy (of it)",
        got=outcome.audit.exchanged.worked / kinetic - 1.0,
        within=BALANCE,
    )
    yield _balance("free fall", outcome)


def _pressed_bar(recipe: Recipe) -> Iterator[Row]:
    """A bar at rest on a wall is pressed at its other end, which a wave from the wall drives back after 2 L / c."""
    sound = math.sqrt(BAR["young_modulus"] / BAR["density"])
    back, velocity = 2.0 * BAR["bar_length"] / sound, PRESSURE / (BAR["density"] * sound)
    pulse = f"0 s 0, {BAR_RISE!r} s 1, 1 s 1"
    loading = {"pressure": PRESSURE, "pulse": pulse, "end_time": BAR_END * back}
    result = executed("elastic_bar", recipe, {**BAR, **loading})
    history = result.measurements["rear_face_velocity"].history
    observed, end = np.array(history["time"]), np.array(history["value"], float)[1:]
    time = 0.5 * (observed[1:] + observed[:-1])
    low, high = BAR_PLATEAU
    where = "square bar pressed with 0.4 GPa"
    yield relative(
        f"{where}: velocity of its end, p / (rho c) (m/s)",
        expected=velocity,
        got=-float(end[(time > low * back) & (time < high * back)].mean()),
        within=ARRIVES,
    )
    yield relative(
        f"{where}: wave back from the wall after 2 L / c (us)",
        expected=1e6 * back,
        got=1e6 * (_turn(time, end) - 0.5 * BAR_RISE),
        within=ARRIVES,
    )
    histories = result.histories
    energy = sum(np.sum(histories[f"{kind}_energy"], axis=0) for kind in ("kinetic", "internal"))
    energy = energy + histories["otherwise_removed_energy"] - histories["load_work"]
    yield zero(
        f"{where}: energy histories minus work (of the work)",
        got=float(np.abs(energy).max()) / histories["load_work"][-1],
        within=BALANCE,
    )


def _falling_bar(recipe: Recipe) -> Iterator[Row]:
    """A bar that gravity lifts off its wall falls freely."""
    gravity, time = FALL
    result = executed("elastic_bar", recipe, {**BAR, "gravity": -gravity, "end_time": time})
    mass = BAR["density"] * BAR["bar_diameter"] ** 2 * BAR["bar_length"]
    times, momentum = (np.array(result.histories[name]) for name in ("time", "axial_momentum"))
    yield zero(
        "square bar in free fall: largest difference of its momentum from m g t (of it)",
        got=float(np.abs(momentum[0, 1:] / (mass * gravity * times[1:]) - 1.0).max()),
        within=ROUND_OFF,
    )


def _turn(time: np.ndarray, velocity: np.ndarray) -> float:
    """The first time at which a velocity turns positive, s; NaN where it does not."""
    for (before, low), (after, high) in pairwise(zip(time, velocity, strict=True)):
        if low < 0.0 <= high:
            return float(before + (after - before) * low / (low - high))
    return math.nan


def _computed(recipe: Recipe, end_time: float, **changes: Any) -> Outcome:
    begin = ROOM * SPACING
    stretch = Stretch("column", elastic(COPPER), COPPER.density, begin, begin + CELLS * SPACING)
    return simulate(
        column([stretch], recipe, cells=CELLS + 2 * ROOM, spacing=SPACING, end_time=end_time, **changes), threads=1
    )


def _balance(where: str, outcome: Outcome) -> Row:
    drift = outcome.audit.energy_drift
    return zero(
        f"{where}: energy minus work of the loads (of the work)",
        got=drift if math.isfinite(drift) else math.inf,
        within=BALANCE,
    )


CASE = _run
