"""Elastic waves by smoothed particles: a step with its stress and speed, and a standing wave with its order."""

import math
from collections.abc import Iterator

import numpy as np

from solver.problem import ArtificialViscosity, Problem, Smoothing
from solver.simulation import simulate, start
from studies.values.recipes import Recipe
from studies.verification import Case, Row, absolute, observed_order, relative, reported
from studies.verification._collision import Piece, collide, collision_problem, waves
from studies.verification._column import Stretch, column
from studies.verification._matter import elastic
from studies.verification._smoothed import LINE, SMOOTHINGS, SPH, smoothed, trend
from studies.verification._waves import Isotropic

SPEED = 1.0  # m/s: strains of 1e-4, so that the linear theory is exact to four digits
MATTER = Isotropic(8930.0, 117e9, 0.35)  # copper: Ma (2005), Table 2.1
PARTICLES = (25, 50, 100)  # along the flyer, or the standing wave
STRESS, WAVE_SPEED = 0.01, 0.01  # as of the grid: ``elastic_waves``

# A standing wave between two mirrors after a period. Stated before any run: on a lattice the sums are of the order 2,
# and the viscosity's linear term, which is proportional to the spacing, makes that 1.
LENGTH = 1e-2  # m
ORDERS = {"without viscosity": 2.0, "with viscosity": 1.0}
ORDER_ERROR = 0.3
# m/s. At ``SPEED`` the order misses its gate by 0.002: 3e-4 of the error does not change with the spacing, as large as
# the strain, which linear theory leaves out. This speed was added when that was known, before it ran.
GENTLE = 1e-3
# rad. After a whole period the velocity is at rest in its phase, whose error counts in the square: the order of that
# row is 4 in place of the stated 2, and misses. This phase, with the order 2, was stated then, before it ran.
PASSING = 2.5 * math.pi
AMPLITUDE = 0.01  # of the velocity, with the finest spacing and without viscosity
NUMERICS = {
    "without viscosity": SPH._replace(viscosity=ArtificialViscosity(0.0, 0.0)),
    "with viscosity": SPH,
    "with viscosity and artificial stress 0.2": SPH._replace(tensile=0.2),
}


def _run(recipe: Recipe) -> Iterator[Row]:
    for name, smoothing in SMOOTHINGS.items():
        yield from _step(name, smoothing)
    for name, smoothing in NUMERICS.items():
        yield from _standing(name, smoothing, SPEED)
    yield from _standing("without viscosity", NUMERICS["without viscosity"], GENTLE)
    yield from _passing()


def _step(name: str, smoothing: Smoothing) -> Iterator[Row]:
    """Two bodies collide: stress rho c v / 2 and fronts of speed c."""
    c = MATTER.longitudinal_speed
    piece, stress = Piece(elastic(MATTER), MATTER.density, c), 0.5 * MATTER.density * c * SPEED
    errors = []
    for particles in PARTICLES:
        problem = collision_problem(piece, piece, SPEED, LINE, flyer_cells=particles)
        result = collide(smoothed(problem, smoothing))
        errors.append(abs(result.target.plateau.stress / stress - 1.0))
    for body, wave in waves(result):
        where = f"step wave, {name}, {body}"
        got = wave.plateau.stress
        yield relative(f"{where}: stress (MPa)", expected=stress / 1e6, got=got / 1e6, within=STRESS)
        yield relative(f"{where}: wave speed (m/s)", expected=c, got=wave.speed, within=WAVE_SPEED)
        yield reported(f"{where}: scatter of the stress (of its mean)", wave.plateau.scatter)
    yield trend(f"step wave, {name}: error of the stress over three spacings", errors)


def _standing(name: str, smoothing: Smoothing, speed: float) -> Iterator[Row]:
    """v = v0 sin(pi x / L) cos(pi c t / L): after a period everything is as it was."""
    errors = []
    for particles in PARTICLES:
        problem = _mode(particles, smoothing, speed)
        end = simulate(problem).snapshot
        p, turn = end.particles, math.pi * MATTER.longitudinal_speed / LENGTH * end.time
        exact = speed * math.cos(turn) * np.sin(math.pi * p.position[:, 0] / LENGTH)
        errors.append(float(np.sqrt(((p.velocity[:, 0] - exact) ** 2).mean() * 2.0)) / speed)
    where = f"standing wave, {speed:g} m/s, {name}"
    for particles, error in zip(PARTICLES, errors, strict=True):
        is_gated = name == "without viscosity" and particles == PARTICLES[-1]
        yield absolute(
            f"{where}, {particles} particles: error of the velocity after a period (of its amplitude)",
            expected=0.0,
            got=error,
            within=AMPLITUDE if is_gated else None,
        )
    if name in ORDERS:
        yield absolute(
            f"{where}: observed order", expected=ORDERS[name], got=observed_order(errors), within=ORDER_ERROR
        )


def _passing() -> Iterator[Row]:
    """The same wave when its velocity passes through zero: an error of its phase counts in full."""
    errors = []
    for particles in PARTICLES:
        made = start(_mode(particles, NUMERICS["without viscosity"], GENTLE), threads=1)
        omega = math.pi * MATTER.longitudinal_speed / LENGTH
        while omega * made.time < PASSING:
            dt = made.dt
            made.advance()
            at = made.time - 0.5 * dt  # of the velocities
        p, turn = made.particles, omega * at
        exact = GENTLE * math.cos(turn) * np.sin(math.pi * p.position[:, 0] / LENGTH)
        errors.append(float(np.sqrt(((p.velocity[:, 0] - exact) ** 2).mean() * 2.0)) / GENTLE)
    where = f"standing wave, {GENTLE:g} m/s, without viscosity, after 5/4 of a period"
    claim = f"{where}: error of the velocity (of its amplitude)"
    yield absolute(claim, expected=0.0, got=errors[-1], within=AMPLITUDE)
    order = observed_order(errors)
    yield absolute(f"{where}: observed order", expected=2.0, got=order, within=ORDER_ERROR)


def _mode(particles: int, smoothing: Smoothing, speed: float) -> Problem:
    spacing = LENGTH / particles
    wave = Stretch("bar", elastic(MATTER), MATTER.density, 0.0, LENGTH, lambda x: speed * np.sin(math.pi * x / LENGTH))
    problem = column(
        [wave],
        LINE,
        cells=particles,
        spacing=spacing,
        end_time=2.0 * LENGTH / MATTER.longitudinal_speed,
        ends=("SYMMETRIC", "SYMMETRIC"),
    )
    return smoothed(problem, smoothing)


CASE = Case(
    name="sph-elastic-waves",
    says="elastic waves of smoothed particles have their stress and speed within 1 %, and the orders 2 without "
    "viscosity and 1 with it",
    source="d'Alembert",
    run=_run,
    quick=False,
)
