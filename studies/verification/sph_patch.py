"""Patch test and rotation of a free block of smoothed particles: its surfaces, edges and corners count."""

import math
from collections.abc import Iterator

import numpy as np

from solver.geometry import grid
from solver.geometry.cartesian3d import Cartesian3D
from solver.problem import ArtificialViscosity, Body, Face, Problem, Smoothing
from solver.simulation import Simulation, start
from solver.tensor import equivalent_stress
from studies.values.recipes import Recipe
from studies.verification import Case, Row, at_most, reported
from studies.verification._column import lattice
from studies.verification._matter import elastic
from studies.verification._smoothed import COURANT, SMOOTHINGS
from studies.verification._waves import Isotropic
from studies.verification.patch import GRADIENT
from studies.verification.rotation import AXIS, STRESS, TURN, rotated, spin

MATTER = Isotropic(8930.0, 117e9, 0.35)  # copper: Ma (2005), Table 2.1
SPACING, STEP = 1e-3, 1e-9  # m, s
COUNT, ROOM = 8, 4  # particles along each edge of the block, and empty cells around it
INSIDE = 2.6  # spacings from the surface: what a neighbour's neighbourhood is cut by
DISTURBED, SEED = 0.2, 5  # of a spacing: largest displacement of a disturbed lattice
# s: so short that what the stress does to the surface is a part of 1e-13 of it.
TURN_STEP = 1e-13

# Of sums over a hundred neighbours in strains of 4e-6, and of rotations of 0.05; set with those of the grid's cases.
ROUND_OFF, SMALL_STRAIN = 1e-11, 1e-9
# The first run had the viscosity on, whose forces change the velocities of the surface by 3e-4 of what the patch test
# asks for: it missed the gates with 2e-9 and 5e-4. The gates are those; the gradient is looked at without the forces.
NONE = ArtificialViscosity(0.0, 0.0)
# A spinning block under stress for so many steps: its angular momentum over that at the start.
SPIN, SPIN_STEPS, TORQUE = 1e4, 200, 1e-11  # rad/s


def _run(recipe: Recipe) -> Iterator[Row]:
    for disturbed in (0.0, DISTURBED):
        for name, smoothing in SMOOTHINGS.items():
            where = f"{'disturbed' if disturbed else 'regular'} lattice, {name}"
            exact = name == "corrected gradients"
            yield from _patch(where, smoothing, disturbed, exact=exact)
            yield from _turn(where, smoothing, disturbed, exact=exact)
    for name, smoothing in SMOOTHINGS.items():
        yield _angular_momentum(name, smoothing, exact=name == "corrected gradients")


def _patch(where: str, smoothing: Smoothing, disturbed: float, *, exact: bool) -> Iterator[Row]:
    """A linear velocity changes density by det(1 + L dt), and shears by 2 G dev(D) dt."""
    gradient = np.array(GRADIENT)
    simulation = _block(smoothing._replace(viscosity=NONE), disturbed, gradient)
    inside = _inside(simulation)
    simulation.advance()
    grown = np.linalg.det(np.eye(3) + gradient * STEP)
    strain = abs(grown - 1.0)
    errors = np.abs(simulation.particles.density * grown / MATTER.density - 1.0)
    if exact:
        yield at_most(
            f"{where}: density after a linear velocity, relative error of any particle",
            limit=ROUND_OFF,
            got=float(errors.max()),
        )
    else:
        yield from _regions(f"{where}: error of the volume strain (of it)", errors / strain, inside)
    rate = 0.5 * (gradient + gradient.T)
    s = 2.0 * MATTER.shear_modulus * STEP * (rate - np.eye(3) * np.trace(rate) / 3.0)
    answer = np.array([s[0, 0], s[1, 1], s[2, 2], s[0, 1], s[1, 2], s[2, 0]])
    # The modulus is that of the density, which has changed by 4e-6.
    got = simulation.particles.deviator / min(1.0, 1.0 / grown)
    gaps = np.abs(got - answer).max(axis=1) / np.abs(answer).max()
    if exact:
        yield at_most(
            f"{where}: deviator after a linear velocity, error of any particle (of its size)",
            limit=SMALL_STRAIN,
            got=float(gaps.max()),
        )
    else:
        yield from _regions(f"{where}: error of the deviator (of its size)", gaps, inside)


def _turn(where: str, smoothing: Smoothing, disturbed: float, *, exact: bool) -> Iterator[Row]:
    """A rotation turns the stress by 2 atan(w / 2) and strains nothing."""
    turning = spin([part * TURN / TURN_STEP for part in AXIS])
    simulation = _block(smoothing, disturbed, turning, dt=TURN_STEP)
    inside = _inside(simulation)
    simulation.particles.deviator[:] = STRESS
    simulation.advance()
    answer = rotated(STRESS, 2.0 * math.atan(0.5 * TURN))
    gaps = np.abs(simulation.particles.deviator - answer).max(axis=1) / equivalent_stress(STRESS)
    claim = f"{where}: stress turned by {TURN} rad, error (of its size)"
    if exact:
        yield at_most(f"{claim} of any particle", limit=SMALL_STRAIN, got=float(gaps.max()))
    else:
        yield from _regions(claim, gaps, inside)


def _angular_momentum(name: str, smoothing: Smoothing, *, exact: bool) -> Row:
    """A block that spins and rings keeps its angular momentum where rotations have no strain."""
    gradient = spin([part * SPIN for part in AXIS]) + np.diag([SPIN, -SPIN, 0.0])
    simulation = _block(smoothing, DISTURBED, gradient, dt=None)
    begin = _moment(simulation)
    for _ in range(SPIN_STEPS):
        simulation.advance()
    change = float(np.linalg.norm(_moment(simulation) - begin) / np.linalg.norm(begin))
    claim = f"{name}: change of the angular momentum in {SPIN_STEPS} steps of a spinning block"
    return at_most(claim, limit=TORQUE, got=change) if exact else reported(claim, change)


def _regions(claim: str, errors: np.ndarray, inside: np.ndarray) -> Iterator[Row]:
    yield reported(f"{claim}, largest inside", float(errors[inside].max()))
    yield reported(f"{claim}, largest at the surface", float(errors[~inside].max()))


def _moment(simulation: Simulation) -> np.ndarray:
    p = simulation.particles
    moments: np.ndarray = (p.mass[:, None] * np.cross(p.position, p.velocity)).sum(axis=0)
    return moments


def _inside(simulation: Simulation) -> np.ndarray:
    """Particles whose neighbours the surface does not cut."""
    middle = 0.5 * COUNT * SPACING
    beside = np.abs(simulation.particles.position - middle).max(axis=1)
    return np.asarray(beside < middle - INSIDE * SPACING)


def _block(smoothing: Smoothing, disturbed: float, gradient: np.ndarray, dt: float | None = STEP) -> Simulation:
    """A cube of a lattice, disturbed by random displacements, with a linear velocity about its middle."""
    line = SPACING * (np.arange(COUNT) + 0.5)
    position = lattice(line, line, line)
    position += SPACING * np.random.default_rng(SEED).uniform(-disturbed, disturbed, position.shape)
    body = Body(
        name="block",
        matter=elastic(MATTER),
        position=position,
        velocity=(position - 0.5 * COUNT * SPACING) @ gradient.T,
        mass=np.full(len(position), MATTER.density * SPACING**3),
        density=MATTER.density,
        spacing=(SPACING,) * 3,
    )
    geometry = grid(Cartesian3D, lower=(-ROOM * SPACING,) * 3, cells=(COUNT + 2 * ROOM,) * 3, spacing=SPACING)
    free = (Face.FREE, Face.FREE)
    problem = Problem(
        geometry=geometry,
        bodies=(body,),
        faces=(free, free, free),
        end_time=1.0,
        courant=COURANT,
        fixed_dt=dt,
        smoothing=smoothing,
    )
    return start(problem, threads=1)


CASE = Case(
    name="sph-patch",
    says="with corrected gradients smoothed particles reproduce a linear velocity and a rotation to round-off, at free "
    "surfaces too and on disturbed lattices, and keep the angular momentum; without them the errors are shown",
    source="Bonet and Lok (1999), Comput. Methods Appl. Mech. Eng. 180, 97",
    run=_run,
    quick=False,
)
