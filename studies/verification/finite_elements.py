"""Finite elements: plane impact, an elastic step wave, Sod's tube, Noh's plane, a turned block and a skewed patch.

Columns are bars of hexahedra, one of them in each cell and across, between planes of symmetry.
"""

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from solver.fem.elements import Hexahedron
from solver.fem.mesh import lattice, node_masses
from solver.geometry import grid
from solver.geometry.cartesian3d import Cartesian3D
from solver.problem import Body, Face, Mesh, Problem
from solver.simulation import simulate, start
from studies.values.recipes import Recipe
from studies.verification import DEFAULT, Case, Row, absolute, at_most, observed_order, relative, reported
from studies.verification._collision import Collision, Piece, collide, collision_problem, waves
from studies.verification._column import ColumnProfile, Stretch, column, front, plateau, profile
from studies.verification._gas import NOH_GAMMA, SOD, SOD_GAMMA, Noh, riemann
from studies.verification._hugoniot import COPPER, shocked
from studies.verification._matter import elastic, fluid, gas
from studies.verification._waves import Isotropic

LINE: Recipe = replace(DEFAULT, particles_per_cell=1)
ONE, EIGHT = Hexahedron(), Hexahedron(8)
COURANT = 0.8  # of the bound of each element

# Fixed before any run: plate impact at 2 km/s as smoothed particles are asked, waves and gases about as the grid is.
# Orders are reported.
PRESSURE, DENSITY = 0.03, 0.01
STRESS, WAVE_SPEED = 0.01, 0.01
GAS = 0.02  # p* and u* of Sod's tube, and its shock's speed
NOH_FRONT, NOH_PLATEAU = 0.03, 0.05
ROUND_OFF = 1e-11  # of sums over a thousand steps

IMPACT_SPEED, FLYER = 2e3, (25, 50, 100)  # m/s, and elements along the flyer
ELASTIC_SPEED = 1.0  # m/s
MATTER = Isotropic(8930.0, 117e9, 0.35)  # copper: Ma (2005), Table 2.1
TUBE, SOD_TIME = (100, 200, 400), 0.2
NOH_CELLS, NOH_TIME, NOH_ROOM = (50, 100, 200), 0.6, 0.05
BLOCK, BLOCK_SPACING, SKEWED = 6, 1e-3, 0.15  # elements an axis, m, moves of inner nodes in cells


def meshed(problem: Problem, kind: Hexahedron = ONE) -> Problem:
    """The problem of a column (``_column.column``) as a bar of one hexahedron across."""
    bodies = tuple(_bar(body, problem.geometry.spacing, kind) for body in problem.bodies)
    return replace(problem, bodies=bodies, courant=COURANT)


def _bar(body: Body, spacing: float, kind: Hexahedron) -> Body:
    middles = np.sort(body.position[:, 0])
    step = body.spacing[0]
    planes = np.append(middles - 0.5 * step, middles[-1] + 0.5 * step)
    position, mesh = lattice(kind, planes, np.array([0.0, spacing]), np.array([0.0, spacing]))
    velocity = np.zeros_like(position)
    velocity[:, 0] = np.interp(position[:, 0], body.position[:, 0], body.velocity[:, 0])
    return replace(
        body,
        position=position,
        velocity=velocity,
        mass=node_masses(mesh, position, body.density),
        spacing=(step, spacing, spacing),
        mesh=mesh,
    )


def _run(recipe: Recipe) -> Iterator[Row]:
    yield from _impact()
    yield from _elastic()
    yield from _sod()
    yield from _noh()
    yield from _turned()
    yield from _patch()


def _trend(where: str, names: Sequence[str], errors: Sequence[Sequence[float]]) -> Iterator[Row]:
    """Reported rows of the finest errors with their observed orders; errors are coarse to fine."""
    for name, series in zip(names, zip(*errors, strict=True), strict=True):
        order = observed_order(series)
        yield reported(
            f"{where}: error of the {name}, finest of {len(series)}",
            series[-1],
            order=None if math.isnan(order) else order,
        )


def _kept(where: str, result: Any) -> Iterator[Row]:
    for name, got in (
        ("drift of the total energy", result.audit.energy_drift),
        ("error of the momentum", result.audit.momentum_error),
    ):
        yield absolute(f"{where}: {name}", expected=0.0, got=got, within=ROUND_OFF)


# ---- waves in solids -----------------------------------------------------------------------------


def _impact() -> Iterator[Row]:
    exact = shocked(COPPER, 0.5 * IMPACT_SPEED)
    piece = Piece(fluid(COPPER), COPPER.density, exact.shock_speed)
    for kind in (ONE, EIGHT):
        where = f"Cu on Cu, 2 km/s, {kind.points} point{'s' if kind.points > 1 else ''}"
        errors = []
        for cells in FLYER if kind == ONE else FLYER[-1:]:
            problem = collision_problem(piece, piece, IMPACT_SPEED, LINE, flyer_cells=cells)
            result = collide(meshed(problem, kind))
            got = result.target.plateau
            errors.append((abs(got.stress / exact.pressure - 1.0), abs(got.density / exact.density - 1.0)))
        yield from _states(where, result, exact.pressure, exact.density, exact.shock_speed)
        if kind == ONE:
            yield from _trend(where, ("pressure", "density"), errors)
        yield from _kept(where, result.outcome)


def _states(where: str, result: Collision, pressure: float, density: float, speed: float) -> Iterator[Row]:
    for body, wave in waves(result):
        got = wave.plateau
        yield relative(
            f"{where}, {body}: plateau pressure (GPa)", expected=pressure / 1e9, got=got.stress / 1e9, within=PRESSURE
        )
        yield relative(f"{where}, {body}: density (kg/m3)", expected=density, got=got.density, within=DENSITY)
        yield relative(f"{where}, {body}: shock speed (m/s)", expected=speed, got=wave.speed)


def _elastic() -> Iterator[Row]:
    c = MATTER.longitudinal_speed
    piece = Piece(elastic(MATTER), MATTER.density, c)
    errors = []
    for cells in FLYER:
        problem = collision_problem(piece, piece, ELASTIC_SPEED, LINE, flyer_cells=cells)
        result = collide(meshed(problem))
        stress = 0.5 * MATTER.density * c * ELASTIC_SPEED
        wave = result.target
        errors.append((abs(wave.plateau.stress / stress - 1.0), abs(wave.speed / c - 1.0)))
    where = "elastic wave in uniaxial strain"
    yield relative(f"{where}: stress (MPa)", expected=stress / 1e6, got=wave.plateau.stress / 1e6, within=STRESS)
    yield relative(f"{where}: wave speed (m/s)", expected=c, got=wave.speed, within=WAVE_SPEED)
    yield from _trend(where, ("stress", "wave speed"), errors)
    yield from _kept(where, result.outcome)


# ---- gases ---------------------------------------------------------------------------------------


def _sod() -> Iterator[Row]:
    left, right = SOD
    exact = riemann(*SOD, SOD_GAMMA)
    matter = gas(SOD_GAMMA, densest=left.density, sound_speed=left.sound_speed(SOD_GAMMA))
    errors = []
    for cells in TUBE:
        problem = column(
            [
                Stretch(name, matter, state.density, x, x + 0.5, energy=state.energy(SOD_GAMMA))
                for name, state, x in (("left", left, -0.5), ("right", right, 0.0))
            ],
            LINE,
            lower=-0.5,
            cells=cells,
            spacing=1.0 / cells,
            end_time=SOD_TIME,
            ends=("SYMMETRIC", "SYMMETRIC"),
        )
        outcome = simulate(meshed(problem))
        line = profile(outcome.snapshot, 1)
        place = front(line, 1.0 / cells, 0.5 * (exact.pressure + right.pressure))
        behind = plateau(line, 1.0 / cells, exact.contact * SOD_TIME, place)
        errors.append(
            [
                abs(got / answer - 1.0)
                for got, answer in (
                    (behind.stress, exact.pressure),
                    (behind.velocity, exact.velocity),
                    (place / SOD_TIME, exact.shock),
                )
            ]
        )
    names = ("p*", "u*", "speed of the shock")
    for name, error in zip(names, errors[-1], strict=True):
        yield at_most(f"Sod, {TUBE[-1]} elements: error of {name}", limit=GAS, got=error)
    yield from _trend("Sod", names, errors)
    yield from _kept("Sod", outcome)


def _noh() -> Iterator[Row]:
    exact = Noh(1)
    matter = gas(NOH_GAMMA, densest=exact.density, sound_speed=0.0)
    errors = []
    for cells in NOH_CELLS:
        problem = column(
            [Stretch("gas", matter, 1.0, 0.0, 1.0, -1.0)],
            LINE,
            cells=round((1.0 + NOH_ROOM) * cells),
            spacing=1.0 / cells,
            end_time=NOH_TIME,
            ends=("SYMMETRIC", "FREE"),
        )
        outcome = simulate(meshed(problem))
        line: ColumnProfile = profile(outcome.snapshot, 0)
        place = front(line, 1.0 / cells, 0.5 * exact.pressure)
        behind = plateau(line, 1.0 / cells, 0.0, place)
        errors.append(
            [
                abs(place / (exact.front * NOH_TIME) - 1.0),
                abs(behind.density / exact.density - 1.0),
                abs(behind.stress / exact.pressure - 1.0),
            ]
        )
    names = ("front", "plateau density", "plateau pressure")
    limits = (NOH_FRONT, NOH_PLATEAU, NOH_PLATEAU)
    for name, error, limit in zip(names, errors[-1], limits, strict=True):
        yield at_most(f"Noh, plane, {NOH_CELLS[-1]} elements: error of the {name}", limit=limit, got=error)
    yield from _trend("Noh, plane", names, errors)
    yield from _kept("Noh, plane", outcome)


# ---- blocks --------------------------------------------------------------------------------------


def _block(kind: Hexahedron, flow: Callable[[np.ndarray], np.ndarray], **changes: Any) -> Problem:
    """A cube in free space whose inner nodes are moved at random, with the velocities ``flow``."""
    line = BLOCK_SPACING * np.arange(BLOCK + 1)
    position, mesh = lattice(kind, line, line, line)
    inner = ((position > 0.0) & (position < line[-1])).all(axis=1)
    moves = np.random.default_rng(1).uniform(-SKEWED, SKEWED, (int(inner.sum()), 3))
    position[inner] += moves * BLOCK_SPACING
    body = Body(
        name="block",
        matter=elastic(MATTER),
        position=position,
        velocity=flow(position - position.mean(axis=0)),
        mass=node_masses(mesh, position, MATTER.density),
        density=MATTER.density,
        spacing=(BLOCK_SPACING,) * 3,
        mesh=Mesh(kind, mesh.nodes),
    )
    free = (Face.FREE, Face.FREE)
    geometry = grid(Cartesian3D, lower=(0.0,) * 3, cells=(BLOCK,) * 3, spacing=BLOCK_SPACING)
    return Problem(
        geometry=geometry, bodies=(body,), faces=(free, free, free), **{"end_time": 1e-6, "courant": COURANT, **changes}
    )


TURNS = (50, 100, 200)  # steps of a full turn
SPIN = np.array([0.6, 0.0, 0.8])


def _turned() -> Iterator[Row]:
    """A block that turns freely once: a step of the angle w strains by w^2 / 2, so that errors fall with the square."""
    dt = 1e-8
    errors = []
    for steps in TURNS:
        rate = 2.0 * math.pi / (steps * dt)

        def turning(x: np.ndarray, rate: float = rate) -> np.ndarray:
            flow: np.ndarray = rate * np.cross(SPIN, x)
            return flow

        simulation = start(_block(ONE, turning, fixed_dt=dt, end_time=steps * dt), threads=1)
        simulation.advance()
        points, _ = simulation.stepper.material_points(simulation.particles, simulation.body)
        strain = np.abs(points.density / MATTER.density - 1.0).max()
        errors.append((strain,))
    yield reported("rigid rotation: volume strain of a step of a 200th of a turn", errors[-1][0])
    order = observed_order([error for (error,) in errors])
    yield absolute("rigid rotation: order of the strain of a step in its angle", expected=2.0, got=order, within=0.05)


GRADIENT = np.array([[-1.0, 2.0, 0.5], [-2.0, 3.0, 1.0], [0.3, -0.5, -2.0]]) * 1e3  # 1/s


def _patch() -> Iterator[Row]:
    """Linear velocities in a skewed mesh, and a uniform pressure in one."""
    for kind in (ONE, EIGHT):
        simulation = start(_block(kind, lambda x: x @ GRADIENT.T), threads=1)
        dt = simulation.dt
        simulation.advance()
        points, _ = simulation.stepper.material_points(simulation.particles, simulation.body)
        exact = MATTER.density / np.linalg.det(np.eye(3) + GRADIENT * dt)
        yield at_most(
            f"skewed patch, {kind.points} points, linear velocities: largest error of the density",
            limit=ROUND_OFF,
            got=float(np.abs(points.density / exact - 1.0).max()),
        )
        simulation = start(_block(kind, np.zeros_like), threads=1)
        points, _ = simulation.stepper.material_points(simulation.particles, simulation.body)
        points.pressure[:] = 1e9
        before = simulation.particles.position.copy()
        simulation.advance()
        inner = ((before > 0.0) & (before < BLOCK * BLOCK_SPACING)).all(axis=1)
        speed = np.abs(simulation.particles.velocity).max(axis=1)
        yield at_most(
            f"skewed patch, {kind.points} points, uniform pressure: speed of inner nodes (of the fastest)",
            limit=ROUND_OFF,
            got=float(speed[inner].max() / speed.max()),
        )


CASE = Case(
    name="finite-elements",
    says="finite elements hold plane impact, an elastic wave, Sod's tube, Noh's plane and patches of skewed elements, "
    "and keep momentum and energy to round-off",
    source="Rankine and Hugoniot; d'Alembert; Sod (1978), J. Comput. Phys. 27, 1; Noh (1987), J. Comput. Phys. 72, 78; "
    "patch test: Irons and Razzaque (1972)",
    run=_run,
    quick=False,
)
