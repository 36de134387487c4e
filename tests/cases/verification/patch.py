"""Patch tests: uniform states that a step must keep, turn, or change by exactly what theory says, by each method.

Seen through whole steps of the solver. On the grid only particles that the surface of the block cannot reach within the
step are looked at: mapping to the nodes, back, to the nodes again and back once more each spans a cell and a half. With
``jaumann: off`` a stress that is turned stays as it is in space, which the matter turns away from.
"""

import math
from collections.abc import Callable, Iterator
from dataclasses import replace
from typing import Any

import numpy as np

from solver.matter.stress import PointState, advance
from solver.matter.tensor import Unturned, equivalent_stress
from solver.methods.fem.mesh import lattice as mesh_of
from solver.methods.fem.mesh import node_masses
from solver.problem import ArtificialViscosity, Body, Problem, Smoothing
from solver.problem.geometry import Axisymmetric, Cartesian3D, grid
from solver.simulation import Simulation, start
from studies.quantities.numerical_defaults import Recipe
from tests.cases.verification import case
from tests.cases.verification.setups.column import with_numerics
from tests.cases.verification.setups.lattices import FREE, MIRROR, lattice, lattice_body, middles
from tests.cases.verification.setups.matter import elastic
from tests.cases.verification.setups.methods import COURANT, COURANT_OF_ELEMENTS, SMOOTHINGS
from tests.cases.verification.solutions.waves import COPPER
from tests.claims.rows import Row, absolute, at_most, observed_order, reported

SPACING, STEP = 1e-3, 1e-9  # m, s
CELLS = {"cartesian": (16, 16, 16), "axisymmetric": (16, 16)}  # of the block
REACH = 6.0  # cells from the surface that a step can see
PRESSURE = 1e9  # Pa
GRADIENT = np.array([[3e3, 1e3, -2e3], [5e2, -1e3, 4e3], [-1e3, 2e3, 2e3]])  # 1/s: stretch, shear and spin
# Of sums over some hundred particles or neighbours, of a volume change of 4e-6 in a density, and of a thousand steps.
ROUND_OFF = 1e-11
SMALL_STRAIN = 1e-9  # round-off of strains of 4e-6, and of rotations of 0.05

# In axisymmetry mass grows with the radius, and the mass-weighted velocity of v = k r at a node is k (r + O(h^2 / r));
# volumes per radian of particles have a kink on the axis, which wide shapes see from both sides. Exact answers are
# not to be had near the axis: three cells are reported apart. The error beyond them was set before any run.
NEAR_AXIS, NEAR_AXIS_ERROR = 3.0, 0.01

# A rigid rotation.
STRESS = (3e8, -1e8, -2e8, 0.5e8, -0.7e8, 1.1e8)  # Pa: a deviator
# Difference of the principal stresses, Pa: the change by one radian too far.
LARGEST_DIFFERENCE = 4e8
AXIS = (0.6, 0.0, 0.8)
TURNS = (50, 200)  # steps for a full turn of a point
TURN = 0.05  # of a block in one step, rad
TURNED = 1e-12  # round-off

# Blocks of smoothed particles, whose surfaces, edges and corners count.
COUNT, ROOM = 8, 4  # particles along each edge of the block, and empty cells around it
INSIDE = 2.6  # spacings from the surface: what a neighbour's neighbourhood is cut by
DISTURBED, SEED = 0.2, 5  # of a spacing: largest displacement of a disturbed lattice
# s: so short that what the stress does to the surface is a part of 1e-13 of it.
TURN_STEP = 1e-13
# The first run had the viscosity on, whose forces change the velocities of the surface by 3e-4 of what the patch test
# asks for: it missed the gates with 2e-9 and 5e-4. The gates are those; the gradient is looked at without the forces.
NONE = ArtificialViscosity(0.0, 0.0)
# A spinning block under stress for so many steps: its angular momentum over that at the start.
SPIN, SPIN_STEPS, TORQUE = 1e4, 200, 1e-11  # rad/s

# Blocks of finite elements.
EDGE, SKEWED = 6, 0.15  # elements an axis, moves of inner nodes in cells
ELEMENT_TURNS = (50, 100, 200)  # steps of a full turn
ELEMENT_GRADIENT = np.array([[-1.0, 2.0, 0.5], [-2.0, 3.0, 1.0], [0.3, -0.5, -2.0]]) * 1e3  # 1/s


# ---- exact answers -------------------------------------------------------------------------------


def _sheared(gradient: np.ndarray) -> tuple[float, np.ndarray]:
    """What a step with a velocity gradient does: growth of the volume, det(1 + L dt), and deviator, 2 G dev(D) dt."""
    rate = 0.5 * (gradient + gradient.T)
    s = 2.0 * COPPER.shear_modulus * STEP * (rate - np.eye(3) * np.trace(rate) / 3.0)
    return float(np.linalg.det(np.eye(3) + gradient * STEP)), _components(s)


def _components(s: np.ndarray) -> np.ndarray:
    return np.array([s[0, 0], s[1, 1], s[2, 2], s[0, 1], s[1, 2], s[2, 0]])


def _spin(angle: float, dt: float = 1.0) -> np.ndarray:
    """The velocity gradient of a rotation about ``AXIS`` by an angle in a time."""
    x, y, z = (part * angle / dt for part in AXIS)
    return np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])


def _rotated(angle: float) -> np.ndarray:
    """``STRESS`` turned by R s R^T about ``AXIS`` (Rodrigues), six components."""
    xx, yy, zz, xy, yz, zx = STRESS
    full = np.array([[xx, xy, zx], [xy, yy, yz], [zx, yz, zz]])
    k = _spin(1.0)
    turn = np.eye(3) + math.sin(angle) * k + (1.0 - math.cos(angle)) * k @ k
    return _components(turn @ full @ turn.T)


# ---- on the grid ---------------------------------------------------------------------------------


@case("patch", says="uniform states pass the patch tests", source="Irons; kinematics of a homogeneous deformation")
def _on_grid(recipe: Recipe) -> Iterator[Row]:
    for geometry in CELLS:
        yield from _pressure(geometry, recipe)
    yield from _gradient(recipe)
    yield from _expansion(recipe)


def _pressure(geometry: str, recipe: Recipe) -> Iterator[Row]:
    """Uniform pressure pushes no inner particle."""
    simulation, inside = _started(geometry, recipe)
    simulation.particles.pressure[:] = PRESSURE
    simulation.advance()
    gained = np.abs(simulation.particles.velocity).max(axis=1)
    gained /= PRESSURE / (COPPER.density * SPACING) * STEP
    radius = simulation.particles.position[:, 0] / SPACING
    near = inside & (radius < NEAR_AXIS) & (geometry == "axisymmetric")
    claim = f"{geometry}: velocity that a uniform pressure gives to inner particles (of p dt / rho h)"
    yield at_most(claim, limit=ROUND_OFF, got=float(gained[inside & ~near].max()))
    if near.any():
        yield reported(f"{claim} within {NEAR_AXIS:g} cells of the axis", float(gained[near].max()))


def _gradient(recipe: Recipe) -> Iterator[Row]:
    """A uniform velocity gradient stretches and shears."""
    simulation, inside = _started("cartesian", recipe)
    particles = simulation.particles
    particles.velocity[:] = particles.position @ GRADIENT.T
    simulation.advance()
    grown, exact = _sheared(GRADIENT)
    density = simulation.particles.density[inside]
    yield at_most(
        "cartesian: density after a uniform velocity gradient, relative error",
        limit=ROUND_OFF,
        got=float(np.abs(density * grown / COPPER.density - 1.0).max()),
    )
    # The modulus is that of the density, which has changed by 4e-6.
    got = simulation.particles.deviator[inside] / min(1.0, 1.0 / grown)
    yield at_most(
        "cartesian: deviator after a uniform velocity gradient (of its size)",
        limit=SMALL_STRAIN,
        got=float(np.abs(got - exact).max() / np.abs(exact).max()),
    )


def _expansion(recipe: Recipe) -> Iterator[Row]:
    """v = k x in axisymmetry: the volume rate is 3 k, but for a neighbourhood of the axis."""
    simulation, inside = _started("axisymmetric", recipe)
    particles = simulation.particles
    rate = GRADIENT[0][0]
    particles.velocity[:, :2] = rate * particles.position[:, :2]
    simulation.advance()
    p = simulation.particles
    error = np.abs((COPPER.density / p.density - 1.0) / ((1.0 + rate * STEP) ** 3 - 1.0) - 1.0)
    radius = p.position[:, 0] / SPACING
    far = inside & (radius > NEAR_AXIS)
    yield at_most(
        f"axisymmetric: error of a uniform expansion beyond {NEAR_AXIS:g} cells from the axis",
        limit=NEAR_AXIS_ERROR,
        got=float(error[far].max()),
    )
    yield reported("axisymmetric: error of a uniform expansion within them", float(error[inside & ~far].max()))


def _started(geometry: str, recipe: Recipe) -> tuple[Simulation, np.ndarray]:
    """A block at rest, and which of its particles the surface cannot reach."""
    simulation = start(_grid_block(geometry, recipe), threads=1)
    cells = np.array((*CELLS[geometry], 0)[:3])
    place = simulation.particles.position / SPACING
    inside = (place <= cells - REACH) & (place >= REACH)
    if geometry == "axisymmetric":
        inside[:, 0] = place[:, 0] <= cells[0] - REACH
        inside[:, 2] = True
    return simulation, np.asarray(inside.all(axis=1))


def _grid_block(geometry: str, recipe: Recipe, velocity: Callable[[np.ndarray], np.ndarray] | None = None) -> Problem:
    """A block of cells from the origin, with room around it."""
    flat = geometry == "axisymmetric"
    cells, step = CELLS[geometry], SPACING / recipe.particles_per_cell
    position = lattice(*(middles(count * recipe.particles_per_cell, step) for count in cells))
    room = (0, 2, 0) if flat else (2, 2, 2)
    record = grid(
        Axisymmetric if flat else Cartesian3D,
        lower=tuple(-SPACING * cells for cells in room),
        cells=tuple(count + low + 2 for count, low in zip(cells, room, strict=False)) + ((0,) if flat else ()),
        spacing=SPACING,
    )
    body = lattice_body(
        elastic(COPPER),
        record,
        position,
        (step, step, 0.0 if flat else step),
        density=COPPER.density,
        velocity=velocity(position) if velocity else 0.0,
    )
    problem = Problem(geometry=record, bodies=(body,), faces=(MIRROR if flat else FREE, FREE, FREE), end_time=STEP)
    return replace(with_numerics(problem, replace(recipe, damping_rate=0.0)), fixed_dt=STEP)


@case(
    "rotation",
    says="rigid rotation turns stress and keeps its size; with jaumann off the stress stays as it is in space",
    source="objectivity: Jaumann's rate by the midpoint rotation of Hughes and Winget (1980); Ma (2005), section 2.2.1",
)
def _turned(recipe: Recipe) -> Iterator[Row]:
    for steps in TURNS:
        after = _turned_point(2.0 * math.pi / steps, steps)
        where = f"point, a full turn in {steps} steps"
        change = abs(_mises(after) / _mises(STRESS) - 1.0)
        yield at_most(f"{where}: change of the von Mises stress", limit=TURNED * steps, got=change)
        # The midpoint rotation turns by 2 atan(w / 2) instead of w: (w^3 / 12) in each step.
        missed = 2.0 * math.pi * (2.0 * math.pi / steps) ** 2 / 12.0
        gap = float(np.abs(np.subtract(STRESS, after)).max())
        yield at_most(
            f"{where}: stress missed (of the bound from the midpoint rule)",
            limit=1.0,
            got=gap / (2.0 * missed * LARGEST_DIFFERENCE),
        )
    yield from _turned_block(recipe)


def _mises(stress: tuple[float, ...] | np.ndarray) -> float:
    return float(equivalent_stress(tuple(stress)))


def _turned_point(angle: float, steps: int) -> tuple[float, ...]:
    """``STRESS`` after steps that only turn it."""
    dt = 1e-8
    gradient = _spin(angle, dt)
    point = PointState(COPPER.density, 0.0, 0.0, 0.0, STRESS, 0.0, 300.0)
    matter = elastic(COPPER)
    for _ in range(steps):
        point = advance(matter, ArtificialViscosity(), SPACING, dt, gradient, point)[0]
        point = point._replace(density=COPPER.density)  # its straight steps grow the volume
    return point.deviator


def _turned_block(recipe: Recipe) -> Iterator[Row]:
    """One step of a block that turns rigidly: particles that the surface cannot reach turn their stress."""
    middle, turning = 0.5 * CELLS["cartesian"][0] * SPACING, _spin(TURN, STEP)
    problem = _grid_block("cartesian", recipe, lambda position: (position - middle) @ turning.T)
    got = _after_a_turn(problem)
    where, limit = f"{TURN} rad in a step", TURNED * 1e2
    sizes = np.array([_mises(stress) for stress in got])
    yield at_most(
        f"grid, {where}: change of the von Mises stress",
        limit=limit,
        got=float(np.abs(sizes / _mises(STRESS) - 1.0).max()),
    )
    turned = _rotated(2.0 * math.atan(0.5 * TURN))
    yield at_most(
        f"grid, {where}: distance from the stress turned by 2 atan(w / 2) (of its size)",
        limit=limit,
        got=_farthest(got, turned),
    )
    got = _after_a_turn(replace(problem, stress_rate=Unturned()))
    yield at_most(
        f"grid, jaumann off, {where}: change of the stress in space (of its size)",
        limit=limit,
        got=_farthest(got, np.array(STRESS)),
    )
    yield reported(
        "grid, jaumann off: distance from the stress of the matter that has turned (of its size)",
        _farthest(got, turned),
    )


def _after_a_turn(problem: Problem) -> np.ndarray:
    """Deviators (n, 6) of the inner particles after a step that began with ``STRESS`` everywhere, Pa."""
    simulation = start(problem, threads=1)
    simulation.particles.deviator[:] = STRESS
    before = simulation.particles.position.copy()
    simulation.advance()
    middle = 0.5 * CELLS["cartesian"][0] * SPACING
    inside = np.abs(before - middle).max(axis=1) < middle - REACH * SPACING
    return simulation.particles.deviator[inside]


def _farthest(stress: np.ndarray, expected: np.ndarray) -> float:
    """Largest difference of any component, over the size of ``STRESS``."""
    return float(np.abs(stress - expected).max()) / _mises(STRESS)


# ---- by smoothed particles -----------------------------------------------------------------------


@case(
    "sph-patch",
    says="with corrected gradients smoothed particles reproduce a linear velocity and a rotation to round-off, at "
    "free surfaces too and on disturbed lattices, and keep the angular momentum; without them the errors are shown",
    source="Bonet and Lok (1999), Comput. Methods Appl. Mech. Eng. 180, 97",
)
def _smoothed(recipe: Recipe) -> Iterator[Row]:
    for disturbed in (0.0, DISTURBED):
        for name, smoothing in SMOOTHINGS.items():
            where = f"{'disturbed' if disturbed else 'regular'} lattice, {name}"
            exact = name == "corrected gradients"
            yield from _smoothed_patch(where, smoothing, disturbed, exact=exact)
            yield from _smoothed_turn(where, smoothing, disturbed, exact=exact)
    for name, smoothing in SMOOTHINGS.items():
        yield _angular_momentum(name, smoothing, exact=name == "corrected gradients")


def _smoothed_patch(where: str, smoothing: Smoothing, disturbed: float, *, exact: bool) -> Iterator[Row]:
    """A linear velocity stretches and shears."""
    simulation = _smoothed_block(smoothing._replace(viscosity=NONE), disturbed, GRADIENT)
    inside = _inside(simulation)
    simulation.advance()
    grown, answer = _sheared(GRADIENT)
    errors = np.abs(simulation.particles.density * grown / COPPER.density - 1.0)
    # The modulus is that of the density, which has changed by 4e-6.
    got = simulation.particles.deviator / min(1.0, 1.0 / grown)
    gaps = np.abs(got - answer).max(axis=1) / np.abs(answer).max()
    if exact:
        yield at_most(
            f"{where}: density after a linear velocity, relative error of any particle",
            limit=ROUND_OFF,
            got=float(errors.max()),
        )
        yield at_most(
            f"{where}: deviator after a linear velocity, error of any particle (of its size)",
            limit=SMALL_STRAIN,
            got=float(gaps.max()),
        )
    else:
        yield from _regions(f"{where}: error of the volume strain (of it)", errors / abs(grown - 1.0), inside)
        yield from _regions(f"{where}: error of the deviator (of its size)", gaps, inside)


def _smoothed_turn(where: str, smoothing: Smoothing, disturbed: float, *, exact: bool) -> Iterator[Row]:
    """A rotation turns the stress by 2 atan(w / 2) and strains nothing."""
    simulation = _smoothed_block(smoothing, disturbed, _spin(TURN, TURN_STEP), dt=TURN_STEP)
    inside = _inside(simulation)
    simulation.particles.deviator[:] = STRESS
    simulation.advance()
    answer = _rotated(2.0 * math.atan(0.5 * TURN))
    gaps = np.abs(simulation.particles.deviator - answer).max(axis=1) / equivalent_stress(STRESS)
    claim = f"{where}: stress turned by {TURN} rad, error (of its size)"
    if exact:
        yield at_most(f"{claim} of any particle", limit=SMALL_STRAIN, got=float(gaps.max()))
    else:
        yield from _regions(claim, gaps, inside)


def _angular_momentum(name: str, smoothing: Smoothing, *, exact: bool) -> Row:
    """A block that spins and rings keeps its angular momentum where rotations have no strain."""
    gradient = _spin(SPIN) + np.diag([SPIN, -SPIN, 0.0])
    simulation = _smoothed_block(smoothing, DISTURBED, gradient, dt=None)
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
    return (p.mass[:, None] * np.cross(p.position, p.velocity)).sum(axis=0)


def _inside(simulation: Simulation) -> np.ndarray:
    """Particles whose neighbours the surface does not cut."""
    middle = 0.5 * COUNT * SPACING
    beside = np.abs(simulation.particles.position - middle).max(axis=1)
    return np.asarray(beside < middle - INSIDE * SPACING)


def _smoothed_block(
    smoothing: Smoothing, disturbed: float, gradient: np.ndarray, dt: float | None = STEP
) -> Simulation:
    """A cube of a lattice, disturbed by random displacements, with a linear velocity about its middle."""
    line = middles(COUNT, SPACING)
    position = lattice(line, line, line)
    position += SPACING * np.random.default_rng(SEED).uniform(-disturbed, disturbed, position.shape)
    geometry = grid(Cartesian3D, lower=(-ROOM * SPACING,) * 3, cells=(COUNT + 2 * ROOM,) * 3, spacing=SPACING)
    velocity = (position - 0.5 * COUNT * SPACING) @ gradient.T
    body = lattice_body(elastic(COPPER), geometry, position, (SPACING,) * 3, density=COPPER.density, velocity=velocity)
    problem = Problem(
        geometry=geometry,
        bodies=(body,),
        faces=(FREE, FREE, FREE),
        end_time=1.0,
        courant=COURANT,
        fixed_dt=dt,
        smoothing=smoothing,
    )
    return start(problem, threads=1)


# ---- by finite elements --------------------------------------------------------------------------


def of_elements() -> Iterator[Row]:
    """A turned block, and linear velocities and a uniform pressure in a skewed mesh."""
    yield from _turned_elements()
    where = "skewed patch"
    simulation = start(_meshed_block(lambda x: x @ ELEMENT_GRADIENT.T), threads=1)
    dt = simulation.dt
    simulation.advance()
    exact = COPPER.density / np.linalg.det(np.eye(3) + ELEMENT_GRADIENT * dt)
    yield at_most(
        f"{where}, linear velocities: largest error of the density",
        limit=ROUND_OFF,
        got=float(np.abs(_points(simulation).density / exact - 1.0).max()),
    )
    simulation = start(_meshed_block(np.zeros_like), threads=1)
    _points(simulation).pressure[:] = PRESSURE
    before = simulation.particles.position.copy()
    simulation.advance()
    inner = ((before > 0.0) & (before < EDGE * SPACING)).all(axis=1)
    speed = np.abs(simulation.particles.velocity).max(axis=1)
    yield at_most(
        f"{where}, uniform pressure: speed of inner nodes (of the fastest)",
        limit=ROUND_OFF,
        got=float(speed[inner].max() / speed.max()),
    )


def _turned_elements() -> Iterator[Row]:
    """A block that turns freely once: a step of the angle w strains by w^2 / 2, so that errors fall with the square."""
    dt = 1e-8
    errors = []
    for steps in ELEMENT_TURNS:
        rate = 2.0 * math.pi / (steps * dt)

        def turning(x: np.ndarray, rate: float = rate) -> np.ndarray:
            return rate * np.cross(AXIS, x)

        simulation = start(_meshed_block(turning, fixed_dt=dt, end_time=steps * dt), threads=1)
        simulation.advance()
        errors.append(float(np.abs(_points(simulation).density / COPPER.density - 1.0).max()))
    yield reported("rigid rotation: volume strain of a step of a 200th of a turn", errors[-1])
    order = observed_order(errors)
    yield absolute("rigid rotation: order of the strain of a step in its angle", expected=2.0, got=order, within=0.05)


def _points(simulation: Simulation) -> Any:
    """The material points of the elements."""
    return simulation.stepper.material_points(simulation.particles, simulation.body)[0]


def _meshed_block(flow: Callable[[np.ndarray], np.ndarray], **changes: Any) -> Problem:
    """A cube in free space whose inner nodes are moved at random, with the velocities ``flow``."""
    line = SPACING * np.arange(EDGE + 1)
    position, mesh = mesh_of(line, line, line)
    inner = ((position > 0.0) & (position < line[-1])).all(axis=1)
    position[inner] += np.random.default_rng(1).uniform(-SKEWED, SKEWED, (int(inner.sum()), 3)) * SPACING
    body = Body(
        name="block",
        matter=elastic(COPPER),
        position=position,
        velocity=flow(position - position.mean(axis=0)),
        mass=node_masses(mesh, position, COPPER.density),
        density=COPPER.density,
        spacing=(SPACING,) * 3,
        mesh=mesh,
    )
    return Problem(
        geometry=grid(Cartesian3D, lower=(0.0,) * 3, cells=(EDGE,) * 3, spacing=SPACING),
        bodies=(body,),
        faces=(FREE, FREE, FREE),
        **{"end_time": 1e-6, "courant": COURANT_OF_ELEMENTS, **changes},
    )


CASE = (_on_grid, _turned, _smoothed)
