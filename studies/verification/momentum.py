"""Momentum along the flight stays what it was until a fixed face is reached."""

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from solver.simulation import simulate, start
from solver.state import Particles
from studies.values.recipes import Recipe
from studies.verification import Case, Row, at_most
from studies.verification._impacts import impact_setting

LIMIT = 1e-10
# Speed that no signal in copper exceeds here (m/s): c + up behind a shock of 6 km/s is 11 km/s. The run ends when the
# signal is at the rim; ahead of it the grid hands on a trace, smaller by an order of magnitude with each cell.
FASTEST = 12e3
SPEED, RADIUS = 6e3, 28e-3
END_TIME = 10e-6


def _run(recipe: Recipe) -> Iterator[Row]:
    for geometry, axis in (("axisymmetric", 1), ("quarter", 2)):
        setting = impact_setting(recipe, geometry=geometry, speed=SPEED, material="copper-ofhc", plate_radius=RADIUS)
        problem = setting.problem
        reached = (setting.radius - 0.5 * setting.projectile_diameter) / FASTEST
        simulation = start(problem, threads=1)
        before = _along(simulation.particles, axis)
        while simulation.time < reached:
            simulation.advance()
        change = abs(_along(simulation.particles, axis) / before - 1.0)
        yield at_most(
            f"{geometry}, {SPEED / 1e3:g} km/s, {simulation.step} steps: change of the axial momentum",
            limit=LIMIT,
            got=change,
        )
        outcome = simulate(replace(problem, end_time=END_TIME), interval=0.1 * END_TIME)
        yield at_most(
            f"{geometry}, to {1e6 * END_TIME:g} us, with what rim and outflow took: largest error (of sum |m v|)",
            limit=LIMIT,
            got=float(np.max([abs(audit.momentum_error) for audit in outcome.history])),
        )


def _along(particles: Particles, axis: int) -> float:
    return float((particles.mass * particles.velocity[:, axis]).sum())


CASE = Case(
    name="momentum",
    says="axial momentum of an impact stays to 1e-10 until a fixed face is reached",
    source="Newton",
    run=_run,
    quick=False,
)
