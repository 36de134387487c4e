"""Elastic step waves: in uniaxial strain, in a bar without Poisson's effect, and in a rod with free sides."""

from collections.abc import Iterator

import numpy as np

from solver.geometry import grid, lattice_measure
from solver.geometry.axisymmetric import Axisymmetric
from solver.problem import Body, Face, Problem
from solver.simulation import simulate
from studies.values.recipes import Recipe
from studies.verification import Case, Row, absolute, relative, reported
from studies.verification._collision import Piece, collide, collision_problem, waves
from studies.verification._column import lattice, solver_numerics
from studies.verification._matter import elastic
from studies.verification._waves import Isotropic

SPEED = 1.0  # m/s: strains of 1e-4, so that the linear theory is exact to four digits
YOUNG, DENSITY = 117e9, 8930.0  # copper: Ma (2005), Table 2.1
PLANE = {  # name: Poisson's ratio
    "uniaxial strain, nu 0.35": 0.35,
    "bar, nu 0": 0.0,
}

# The rod of free sides, nu 0.3: radius and length in cells, and when its front is read, as parts of its length.
ROD_NU, ROD_RADIUS, ROD_LENGTH, ROD_READ = 0.3, 4, 160, (0.5, 0.9)
VOID_CELLS = 3  # beside and behind the rod
ROD_SPACING = 1e-4  # m

# Set before any run. The rod: Skalak's answer is the leading term for long waves.
STRESS, WAVE_SPEED, ROD_SPEED = 0.01, 0.01, 0.02


def _run(recipe: Recipe) -> Iterator[Row]:
    for name, poisson in PLANE.items():
        yield from _plane(name, Isotropic(DENSITY, YOUNG, poisson), recipe)
    yield from _rod(Isotropic(DENSITY, YOUNG, ROD_NU), recipe)


def _plane(name: str, matter: Isotropic, recipe: Recipe) -> Iterator[Row]:
    """Two bodies collide: stress rho c v / 2 and fronts of speed c."""
    c = matter.longitudinal_speed
    piece = Piece(elastic(matter), matter.density, c)
    result = collide(collision_problem(piece, piece, SPEED, recipe))
    for body, wave in waves(result):
        where = f"{name}, {body}"
        yield relative(
            f"{where}: stress (MPa)",
            expected=0.5 * matter.density * c * SPEED / 1e6,
            got=wave.plateau.stress / 1e6,
            within=STRESS,
        )
        yield reported(f"{where}: scatter of the stress (of its mean)", wave.plateau.scatter)
        yield relative(f"{where}: wave speed (m/s)", expected=c, got=wave.speed, within=WAVE_SPEED)
    drift = result.outcome.audit.energy_drift
    yield absolute(f"{name}: drift of the total energy", expected=0.0, got=drift)


def _rod(matter: Isotropic, recipe: Recipe) -> Iterator[Row]:
    """A rod runs into a mirror: the level 1/3 of rho c v moves with the bar speed c.

    Radial inertia turns the front into an Airy function, whose integral up to x = c t is 1/3: Skalak (1957), J. Appl.
    Mech. 24, 59.
    """
    places = [_level_place(matter, part, recipe) for part in ROD_READ]
    elapsed = (ROD_READ[1] - ROD_READ[0]) * ROD_LENGTH * ROD_SPACING / matter.bar_speed
    yield relative(
        f"rod with free sides, nu {ROD_NU}: speed of the level 1/3 (m/s)",
        expected=matter.bar_speed,
        got=(places[1] - places[0]) / elapsed,
        within=ROD_SPEED,
    )
    yield reported("the speed of uniaxial strain in the same matter (m/s)", matter.longitudinal_speed)


def _level_place(matter: Isotropic, part: float, recipe: Recipe) -> float:
    """Where the mean stress of a section last reaches a third of rho c v, m from the mirror."""
    problem = _rod_problem(matter, part * ROD_LENGTH * ROD_SPACING / matter.bar_speed, recipe)
    p = simulate(problem).snapshot.particles
    section = (p.position[:, 1] / ROD_SPACING).astype(int)
    volume = np.bincount(section, p.mass / p.density)
    force = np.bincount(section, p.mass / p.density * (p.pressure - p.deviator[:, 1]))
    stress = force / np.where(volume > 0.0, volume, 1.0)
    level = matter.density * matter.bar_speed * SPEED / 3.0
    last = int(np.flatnonzero(stress >= level)[-1])
    share = (stress[last] - level) / (stress[last] - stress[last + 1])
    return float((last + 0.5 + share) * ROD_SPACING)


def _rod_problem(matter: Isotropic, end_time: float, recipe: Recipe) -> Problem:
    geometry = grid(
        Axisymmetric,
        lower=(0.0, 0.0, 0.0),
        cells=(ROD_RADIUS + VOID_CELLS, ROD_LENGTH + VOID_CELLS, 0),
        spacing=ROD_SPACING,
    )
    step = ROD_SPACING / recipe.particles_per_cell
    lines = [step * (np.arange(cells * recipe.particles_per_cell) + 0.5) for cells in (ROD_RADIUS, ROD_LENGTH)]
    position = lattice(*lines)
    measure = lattice_measure(geometry, position.T, (step, step, 0.0))
    body = Body(
        name="rod",
        matter=elastic(matter),
        position=position,
        velocity=np.array([0.0, -SPEED, 0.0]),
        mass=matter.density * measure,
        density=matter.density,
        spacing=(step, step, 0.0),
    )
    mirror, free = (Face.SYMMETRIC, Face.FREE), (Face.FREE, Face.FREE)
    return Problem(
        geometry=geometry, bodies=(body,), faces=(mirror, mirror, free), end_time=end_time, **solver_numerics(recipe)
    )


CASE = Case(
    name="elastic-waves",
    says="elastic step waves have their stress and speed, a rod that of a bar",
    source="d'Alembert; Skalak (1957), J. Appl. Mech. 24, 59, for the rod with free sides",
    run=_run,
)
