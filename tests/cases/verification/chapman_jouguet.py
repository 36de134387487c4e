"""Plane detonation of TNT from a closed end, after MPM3D-F90's Deto1k: Chapman's and Jouguet's state, Taylor's wave.

The tip of the wave behind the front is a cusp, of which any grid cuts off a few cells: the largest pressure is reported
with its trend. The state at the front is read from the wave behind it: pressure, density and velocity over x / t as
parabolas through the particles between two shares of the front's speed, at the front. Shares and degree were set before
any figure was known by them; what the parabolas miss of the exact wave is reported.
"""

import math
from collections.abc import Iterator

import numpy as np

from solver.matter.eos.jwl import JonesWilkinsLee, burnt_fraction
from solver.problem import Problem
from solver.simulation import Outcome, simulate
from studies.quantities.numerical_defaults import Recipe
from tests.cases.verification import case
from tests.cases.verification.setups.column import ColumnProfile, Stretch, column, front, profile
from tests.cases.verification.setups.matter import ROOM, matter_of
from tests.cases.verification.solutions.detonation import TNT, TaylorWave, chapman_jouguet, taylor_wave
from tests.claims.rows import Row, refinement, relative, zero

LENGTH = 0.1  # m, of the bar
CELLS = (400, 800, 1600)  # along it; the last is near the 2000 of the deck
BURNT = 0.9  # of the bar, at the end

# Of the front's speed: behind the cells that smear the front, ahead of the matter at rest (0.52).
FROM, TO, DEGREE = 0.6, 0.95, 2
STATE, SPEED = 0.02, 0.005


def explosive() -> JonesWilkinsLee:
    """The TNT of the deck, unlit."""
    return JonesWilkinsLee(
        density=TNT.density,
        A=TNT.A,
        B=TNT.B,
        R1=TNT.R1,
        R2=TNT.R2,
        omega=TNT.omega,
        E0=TNT.E0,
        detonation_velocity=TNT.velocity,
        temperature=ROOM,
    )


def bar(cells: int, recipe: Recipe) -> Problem:
    """A bar between rigid sides that is lit at its closed end, for cells along it."""
    stretch = Stretch(
        "explosive",
        matter_of(explosive(), shear_modulus=0.0),
        TNT.density,
        0.0,
        LENGTH,
        energy=TNT.E0 / TNT.density,
        lighting=lambda position: position[:, 0] / TNT.velocity,
    )
    return column(
        [stretch],
        recipe,
        cells=cells + 3,
        spacing=LENGTH / cells,
        end_time=BURNT * LENGTH / TNT.velocity,
        ends=("SYMMETRIC", "FREE"),
    )


def released(problem: Problem, outcome: Outcome) -> float:
    """Chemical energy that has burnt, of all of it."""
    [body] = problem.bodies
    assert body.lighting is not None
    now, spacing = outcome.snapshot.time, problem.geometry.spacing
    burnt = [burnt_fraction(body.matter.eos, lit, now, spacing) for lit in body.lighting]
    return float((body.mass * np.array(burnt)).sum()) / float(body.mass.sum())


def at_front(speed: np.ndarray, values: np.ndarray) -> float:
    """Parabola through values over x / t, at the front."""
    share = speed / TNT.velocity
    inside = (share > FROM) & (share < TO)
    return float(np.polyval(np.polyfit(share[inside] - 1.0, values[inside], DEGREE), 0.0))


@case(
    "chapman-jouguet",
    says="a plane detonation of TNT reaches Chapman's and Jouguet's pressure, density and velocity within 2 %, and its "
    "energy is accounted for",
    source="Lee, Hornig and Kury (1968), UCRL-50422; Fickett and Davis (1979), Detonation; constants of Deto1k.mpm, "
    "MPM3D-F90",
)
def _run(recipe: Recipe) -> Iterator[Row]:
    exact, wave = chapman_jouguet(TNT), taylor_wave(TNT)
    errors, peaks = [], []
    for cells in CELLS:
        problem = bar(cells, recipe)
        outcome = simulate(problem)
        line = profile(outcome.snapshot, 0)
        errors.append(_wave_error(line, wave))
        peaks.append(1.0 - float(line.stress.max()) / exact.pressure)
    speed = line.place / line.time
    figures = (
        ("pressure (GPa)", exact.pressure / 1e9, line.stress / 1e9, wave.pressure / 1e9),
        ("density (kg/m3)", exact.density, line.density, wave.density),
        ("velocity of the products (m/s)", exact.velocity, line.velocity, wave.velocity),
    )
    where = f"TNT, {CELLS[-1]} cells"
    for name, expected, values, behind in figures:
        got = at_front(speed, values)
        yield relative(f"{where}: Chapman-Jouguet {name}", expected=expected, got=got, within=STATE)
        missed = at_front(wave.speed, behind)
        yield relative(f"the exact wave read so: {name}", expected=expected, got=missed)
    reached = front(line, LENGTH / CELLS[-1], 0.5 * exact.pressure) / line.time
    yield relative(f"{where}: speed of the front (m/s)", expected=exact.front, got=reached, within=SPEED)
    of_wave = refinement("{} cells: L1 error of the pressure", CELLS, errors)
    of_peak = refinement("{} cells: largest pressure below Chapman-Jouguet's", CELLS, peaks)
    for both in zip(of_wave, of_peak, strict=True):
        yield from both
    drift = outcome.audit.energy_drift
    yield zero("drift of the energy, burnt and unburnt", got=drift, within=1e-12)
    yield relative("share of the energy released", expected=BURNT, got=released(problem, outcome), within=STATE)


def _wave_error(line: ColumnProfile, wave: TaylorWave) -> float:
    """Mean of |p - exact| over that of the exact pressure, with the volumes of the particles."""
    speed = line.place / line.time
    expected = np.interp(speed, wave.speed[::-1], wave.pressure[::-1])
    expected[speed > wave.speed[0]] = 0.0
    missed = float((line.volume * np.abs(line.stress - expected)).sum())
    return missed / float((line.volume * expected).sum()) if math.isfinite(missed) else math.nan


CASE = _run
