"""Elastic waves: steps in uniaxial strain, in a bar and in a rod with free sides; a standing wave with its order.

On the grid, by smoothed particles, and by finite elements.
"""

import math
from collections.abc import Callable, Iterator
from functools import partial

import numpy as np

from solver.problem import ArtificialViscosity, Problem, Smoothing
from solver.problem.geometry import Axisymmetric, grid
from solver.simulation import simulate, start
from solver.state import Particles
from studies.quantities.numerical_defaults import Recipe
from tests.cases.verification import case
from tests.cases.verification.setups.collision import FLYER_CELLS, Collision, Piece, collide, collision_problem, waves
from tests.cases.verification.setups.column import Stretch, column, with_numerics
from tests.cases.verification.setups.lattices import FREE, MIRROR, lattice, lattice_body, middles
from tests.cases.verification.setups.matter import elastic
from tests.cases.verification.setups.methods import LINE, SMOOTHINGS, SPH, kept, meshed, smoothed
from tests.cases.verification.solutions.waves import COPPER, COPPER_BAR, Isotropic
from tests.claims.rows import Row, absolute, observed_order, relative, relatives, reported, trend, zero

SPEED = 1.0  # m/s: strains of 1e-4, so that the linear theory is exact to four digits
PLANE = {"uniaxial strain, nu 0.35": COPPER, "bar, nu 0": COPPER_BAR}

# The rod of free sides, nu 0.3: radius and length in cells, and when its front is read, as parts of its length.
ROD = Isotropic(COPPER.density, COPPER.young, 0.3)
ROD_RADIUS, ROD_LENGTH, ROD_READ = 4, 160, (0.5, 0.9)
VOID_CELLS = 3  # beside and behind the rod
ROD_SPACING = 1e-4  # m

# Set before any run. The rod: Skalak's answer is the leading term for long waves.
STRESS, WAVE_SPEED, ROD_SPEED = 0.01, 0.01, 0.02

PARTICLES = (25, 50, 100)  # or elements, along the flyer or the standing wave
ELEMENTS_ROUND_OFF = 1e-11  # of sums over a thousand steps

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
INVISCID = "without viscosity"
NUMERICS = {
    INVISCID: SPH._replace(viscosity=ArtificialViscosity(0.0, 0.0)),
    "with viscosity": SPH,
    "with viscosity and artificial stress 0.2": SPH._replace(tensile=0.2),
}


def _collided(
    matter: Isotropic, recipe: Recipe, method: Callable[[Problem], Problem] = lambda problem: problem, cells: int = 0
) -> tuple[float, Collision]:
    """Two bodies collide: stress rho c v / 2, Pa, and fronts of speed c."""
    c = matter.longitudinal_speed
    piece = Piece(elastic(matter), matter.density, c)
    problem = collision_problem(piece, piece, SPEED, recipe, flyer_cells=cells or FLYER_CELLS)
    return 0.5 * matter.density * c * SPEED, collide(method(problem))


@case(
    "elastic-waves",
    says="elastic step waves have their stress and speed, a rod that of a bar",
    source="d'Alembert; Skalak (1957), J. Appl. Mech. 24, 59, for the rod with free sides",
)
def _on_grid(recipe: Recipe) -> Iterator[Row]:
    for name, matter in PLANE.items():
        stress, result = _collided(matter, recipe)
        for body, wave in waves(result):
            where = f"{name}, {body}"
            yield from relatives(where, ("stress (MPa)", stress / 1e6, wave.plateau.stress / 1e6, STRESS))
            yield reported(f"{where}: scatter of the stress (of its mean)", wave.plateau.scatter)
            yield from relatives(where, ("wave speed (m/s)", matter.longitudinal_speed, wave.speed, WAVE_SPEED))
        yield zero(f"{name}: drift of the total energy", got=result.outcome.audit.energy_drift)
    yield from _rod(recipe)


def _rod(recipe: Recipe) -> Iterator[Row]:
    """A rod runs into a mirror: the level 1/3 of rho c v moves with the bar speed c.

    Radial inertia turns the front into an Airy function, whose integral up to x = c t is 1/3: Skalak (1957), J. Appl.
    Mech. 24, 59.
    """
    places = [_level_place(part, recipe) for part in ROD_READ]
    elapsed = (ROD_READ[1] - ROD_READ[0]) * ROD_LENGTH * ROD_SPACING / ROD.bar_speed
    yield relative(
        f"rod with free sides, nu {ROD.poisson}: speed of the level 1/3 (m/s)",
        expected=ROD.bar_speed,
        got=(places[1] - places[0]) / elapsed,
        within=ROD_SPEED,
    )
    yield reported("the speed of uniaxial strain in the same matter (m/s)", ROD.longitudinal_speed)


def _level_place(part: float, recipe: Recipe) -> float:
    """Where the mean stress of a section last reaches a third of rho c v, m from the mirror."""
    p = simulate(_rod_problem(part * ROD_LENGTH * ROD_SPACING / ROD.bar_speed, recipe)).snapshot.particles
    section = (p.position[:, 1] / ROD_SPACING).astype(int)
    volume = np.bincount(section, p.mass / p.density)
    force = np.bincount(section, p.mass / p.density * (p.pressure - p.deviator[:, 1]))
    stress = force / np.where(volume > 0.0, volume, 1.0)
    level = ROD.density * ROD.bar_speed * SPEED / 3.0
    last = int(np.flatnonzero(stress >= level)[-1])
    share = (stress[last] - level) / (stress[last] - stress[last + 1])
    return float((last + 0.5 + share) * ROD_SPACING)


def _rod_problem(end_time: float, recipe: Recipe) -> Problem:
    cells = (ROD_RADIUS + VOID_CELLS, ROD_LENGTH + VOID_CELLS, 0)
    geometry = grid(Axisymmetric, lower=(0.0, 0.0, 0.0), cells=cells, spacing=ROD_SPACING)
    step = ROD_SPACING / recipe.particles_per_cell
    radius, length = (middles(cells * recipe.particles_per_cell, step) for cells in (ROD_RADIUS, ROD_LENGTH))
    velocity = np.array([0.0, -SPEED, 0.0])
    position, steps = lattice(radius, length), (step, step, 0.0)
    rod = lattice_body(elastic(ROD), geometry, position, steps, density=ROD.density, velocity=velocity, name="rod")
    faces = (MIRROR, MIRROR, FREE)
    problem = Problem(geometry=geometry, bodies=(rod,), faces=faces, end_time=end_time)
    return with_numerics(problem, recipe)


# ---- by smoothed particles and finite elements ---------------------------------------------------


@case(
    "sph-elastic-waves",
    says="elastic waves of smoothed particles have their stress and speed within 1 %, and the orders 2 without "
    "viscosity and 1 with it",
    source="d'Alembert",
)
def _smoothed(recipe: Recipe) -> Iterator[Row]:
    for name, smoothing in SMOOTHINGS.items():
        yield from _smoothed_step(name, smoothing)
    for name, smoothing in NUMERICS.items():
        yield from _standing(name, smoothing, SPEED)
    yield from _standing(INVISCID, NUMERICS[INVISCID], GENTLE)
    yield from _passing()


def _smoothed_step(name: str, smoothing: Smoothing) -> Iterator[Row]:
    errors = []
    for particles in PARTICLES:
        stress, result = _collided(COPPER, LINE, partial(smoothed, smoothing=smoothing), particles)
        errors.append(abs(result.target.plateau.stress / stress - 1.0))
    for body, wave in waves(result):
        where = f"step wave, {name}, {body}"
        yield from relatives(
            where,
            ("stress (MPa)", stress / 1e6, wave.plateau.stress / 1e6, STRESS),
            ("wave speed (m/s)", COPPER.longitudinal_speed, wave.speed, WAVE_SPEED),
        )
        yield reported(f"{where}: scatter of the stress (of its mean)", wave.plateau.scatter)
    yield trend(f"step wave, {name}: error of the stress over three spacings", errors)


def _standing(name: str, smoothing: Smoothing, speed: float) -> Iterator[Row]:
    """v = v0 sin(pi x / L) cos(pi c t / L): after a period everything is as it was."""
    errors = []
    for particles in PARTICLES:
        end = simulate(_mode(particles, smoothing, speed)).snapshot
        errors.append(_off_mode(end.particles, end.time, speed))
    where = f"standing wave, {speed:g} m/s, {name}"
    for particles, error in zip(PARTICLES, errors, strict=True):
        is_gated = name == INVISCID and particles == PARTICLES[-1]
        yield zero(
            f"{where}, {particles} particles: error of the velocity after a period (of its amplitude)",
            got=error,
            within=AMPLITUDE if is_gated else None,
        )
    if name in ORDERS:
        yield _order(where, ORDERS[name], errors)


def _passing() -> Iterator[Row]:
    """The same wave when its velocity passes through zero: an error of its phase counts in full."""
    errors = []
    omega = math.pi * COPPER.longitudinal_speed / LENGTH
    for particles in PARTICLES:
        made = start(_mode(particles, NUMERICS[INVISCID], GENTLE), threads=1)
        while omega * made.time < PASSING:
            dt = made.dt
            made.advance()
        errors.append(_off_mode(made.particles, made.time - 0.5 * dt, GENTLE))  # the time of the velocities
    where = f"standing wave, {GENTLE:g} m/s, {INVISCID}, after 5/4 of a period"
    claim = f"{where}: error of the velocity (of its amplitude)"
    yield zero(claim, got=errors[-1], within=AMPLITUDE)
    yield _order(where, 2.0, errors)


def _off_mode(p: Particles, time: float, speed: float) -> float:
    """Root of the mean square of the velocity's error, of that of its amplitude."""
    turn = math.pi * COPPER.longitudinal_speed / LENGTH * time
    exact = speed * math.cos(turn) * np.sin(math.pi * p.position[:, 0] / LENGTH)
    return float(np.sqrt(((p.velocity[:, 0] - exact) ** 2).mean() * 2.0)) / speed


def _order(where: str, expected: float, errors: list[float]) -> Row:
    claim = f"{where}: observed order"
    return absolute(claim, expected=expected, got=observed_order(errors), within=ORDER_ERROR)


def _mode(particles: int, smoothing: Smoothing, speed: float) -> Problem:
    wave = Stretch("bar", elastic(COPPER), COPPER.density, 0.0, LENGTH, lambda x: speed * np.sin(math.pi * x / LENGTH))
    problem = column(
        [wave],
        LINE,
        cells=particles,
        spacing=LENGTH / particles,
        end_time=2.0 * LENGTH / COPPER.longitudinal_speed,
        ends=("SYMMETRIC", "SYMMETRIC"),
    )
    return smoothed(problem, smoothing)


def of_elements() -> Iterator[Row]:
    """A step wave by finite elements."""
    errors: dict[str, list[float]] = {"stress": [], "wave speed": []}
    c = COPPER.longitudinal_speed
    for cells in PARTICLES:
        stress, result = _collided(COPPER, LINE, meshed, cells)
        wave = result.target
        errors["stress"].append(abs(wave.plateau.stress / stress - 1.0))
        errors["wave speed"].append(abs(wave.speed / c - 1.0))
    where = "elastic wave in uniaxial strain"
    yield from relatives(
        where,
        ("stress (MPa)", stress / 1e6, wave.plateau.stress / 1e6, STRESS),
        ("wave speed (m/s)", c, wave.speed, WAVE_SPEED),
    )
    for name, series in errors.items():
        yield trend(f"{where}: error of the {name}, finest of {len(PARTICLES)}", series)
    yield from kept(where, result.outcome.audit, ELEMENTS_ROUND_OFF)


CASE = (_on_grid, _smoothed)
