"""One step in its ordered stages: Ma (2005), section 2.2.4.

Particles hold x, v, sigma at time n. All weights are those of x at n.

MUSL   nodes: m, p, f at n, then p at n+1; particles: x, v at n+1; their momentum mapped back gives the nodal velocity
       at n+1, from which strain and stress at n+1 follow
USL    the same without mapping back: the strain takes the nodal p / m at n+1
USF    strain and stress at n+1 first, from the nodal p / m at n; their forces then give p, v, x at n+1

Energy (MUSL): the forces of stress n change the kinetic energy of the particles by f . (v(n) + v(n+1)) / 2 dt at the
nodes, with v(n) mapped before and v(n+1) mapped back after them. That is, particle by particle, minus the work of its
own stress in the mean of the two velocity gradients, and so the internal energy takes it: half when the forces act,
half in the strain update. Kinetic and internal energy then live at the same time level and their sum is kept to
round-off, whatever the stress is (compatible differencing: Caramana et al. 1998, J. Comput. Phys. 146, 227). Pressure
and temperature want the energy at the time of the density, half a step later; they add that half by prediction,
implicit in the pressure. USL takes the same halves and USF the mean of old and new stress at once; neither sees the
velocities that the particles end with, so that their sums drift, and the audit tells by how much.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np

from solver.grid.absorb import absorb, dashpots, energy_absorbed
from solver.grid.contact import NodalContact
from solver.grid.faces import (
    add_ghost_impulse,
    close_mapped,
    close_nodes,
    closed_nodes,
    fold_vectors,
    mirror_nodes,
    mirror_vectors,
)
from solver.grid.loads import Loads
from solver.grid.nodes import ACCELERATION, BEFORE, BLOCK, FORCE, empty_nodes
from solver.grid.shapes.linear import Linear
from solver.grid.transfer import StepDamping, StepWork, move_particles, scatter_smoothed, scatter_state
from solver.jit import Bound, kernel
from solver.problem import Problem, Scheme
from solver.problem.geometry import dimensions, node_count
from solver.state import NEW_X, NEW_Z, X, Z, lines
from solver.steps.crossing import cross_faces
from solver.steps.method import Method, Partition, StepBalance
from solver.steps.points import CULPRIT, FAULT, OUTSIDE, PointUpdate, StateLimits
from solver.steps.space import VELOCITY
from solver.steps.threads import ThreadPool
from solver.vectors import first_lanes, line, number, set_line, spread, where


def bound_kernels() -> Any:
    """The kernels of each step by their names, bound to the types of one problem."""
    return SimpleNamespace(**{each.__name__: Bound(each) for each in KERNELS})


class Field:
    """One velocity field: its nodes, the closed faces around them, and which bodies move in it.

    Each share of the particles adds to a table of its own; the first is that of the nodes.
    """

    def __init__(self, problem: Problem, bodies: slice, shares: int, kernels: Any):
        self.kernels = kernels
        # Small pages cost nothing in two dimensions, and a fifth of a step in three, where neighbours of a node lie in
        # nine of them (3-D linear 31.7 -> 38.4, axisymmetric spline 21.4 -> 21.6 reference numbers, 2026-11-22).
        sparse = dimensions(problem.geometry) == 2
        self.nodes = empty_nodes(
            node_count(problem.geometry),
            smooth=problem.damping.order > 1,
            surface=problem.contact is not None,
            sparse=sparse,
        )
        whole = len(self.nodes.mass)
        self.tables = [self.nodes.state, *(lines(whole, sparse=sparse) for _ in range(1, shares))]
        self.touched = np.zeros((shares, whole // BLOCK), np.uint8)
        self.blocks = np.zeros(0, np.int64)  # of nodes that particles touch in this step
        self.closed = closed_nodes(problem.geometry, problem.faces, problem.clamp)
        self.lost = np.zeros((shares, 4))
        self.bodies = bodies
        ours = range(len(problem.bodies))[bodies]
        self.dashpots = [dashpots(problem, one, self.closed) for one in problem.absorbers if one.body in ours]
        self.loads = Loads(problem, ours)

    def gathered(self, pool: ThreadPool) -> None:
        """Sum the tables of the shares in the first one, in their order."""
        if len(self.tables) == 1:
            return
        for table, touched in zip(self.tables[1:], self.touched[1:], strict=True):
            _over_blocks(pool, self.kernels.add_lines, marked(touched), self.nodes.state, table)

    def close(self, dt: float, impulse: np.ndarray) -> None:
        """Fold the ghosts and hold the faces."""
        touched = self.touched[0]
        self.kernels.close_nodes(self.closed, touched, self.nodes.state, dt, impulse)
        if dt and not self.loads.is_idle:
            fold_vectors(self.closed, self.loads.table, FORCE)

    def load(self, partition: Partition, time: float, dt: float, impulse: np.ndarray) -> None:
        """Forces of tractions and gravity, folded with the faces' own."""
        if self.loads.is_idle:
            return
        impulse += self.loads.add(self.nodes, partition.table, partition.shares, time=time, dt=dt)

    def work(self, dt: float) -> float:
        """Work of tractions and gravity in the step, J."""
        return 0.0 if self.loads.is_idle else self.loads.work(self.nodes, dt)

    def absorb(self, dt: float, impulse: np.ndarray) -> None:
        """Forces of the absorbing surfaces."""
        for surface in self.dashpots:
            absorb(surface, self.nodes, dt, impulse)

    def close_mapped(self) -> float:
        """Hold the faces in the momentum mapped back; returns the energy that walls and absorbers removed, J."""
        energy: float = self.kernels.close_mapped(self.closed, self.nodes.state)
        for surface in self.dashpots:
            energy += energy_absorbed(surface, self.nodes)
        return energy

    def mirror(self) -> None:
        """Velocities of the ghosts."""
        self.kernels.mirror_nodes(self.closed, self.nodes.motion, self.nodes.mapped)


class Stepper(Method):
    """The ordered stages of a step over one problem's arrays; ``shares`` of the particles may be done at once."""

    def __init__(self, problem: Problem, limits: StateLimits, pool: ThreadPool, shares: int):
        if problem.shape is None:
            problem = replace(problem, shape=Linear())
        self.problem = problem
        self.pool = pool
        self.kernels = bound_kernels()
        self.points = PointUpdate(problem, limits, shares)
        self.time = 0.0  # at n+1, s
        self.faces = np.array(problem.faces, dtype=np.int64).reshape(3, 2)
        bodies = len(problem.bodies)
        apart = bodies if problem.contact else 1  # contact asks for a field a body
        self.fields = [
            Field(problem, slice(i, i + 1) if problem.contact else slice(0, bodies), shares, self.kernels)
            for i in range(apart)
        ]
        self.contact = NodalContact(problem, self.fields) if problem.contact else None

    def carried(self) -> dict[str, np.ndarray]:
        """Arrays that pass from step to step beside the particles."""
        return {"taken": self.contact.taken()} if self.contact else {}

    def take_over(self, arrays: Mapping[str, np.ndarray]) -> None:
        """Go on from what ``carried`` gave."""
        if self.contact:
            self.contact.take_over(arrays["taken"])

    def advance(self, partition: Partition, time: float, dt: float) -> StepBalance:
        """Take the particles from n, at a time, to n+1."""
        self.time = time + dt
        scheme, impulse = self.problem.scheme, np.zeros(3)
        if scheme == Scheme.USF:
            self._update_first(partition, dt)
        energy, contact, work = self._move(partition, dt, impulse)
        if scheme == Scheme.USF:
            partition.table[X : Z + 1] = partition.table[NEW_X : NEW_Z + 1]
            self._check_positions(partition.particles.position)
            self.points.tallies[:, OUTSIDE] = 1.0  # they moved after it was counted: every step looks
        else:
            self._update(partition, dt, whole_work=0)  # sigma at n+1
        tally = self.points.tally()
        gone, reflected = 0, 0
        if tally.outside:
            gone, reflected = cross_faces(
                self.problem.geometry, self.faces, self.problem.clamp, partition.particles, impulse
            )
        return StepBalance(impulse, energy, contact, work, gone, reflected, tally)

    def _update_first(self, partition: Partition, dt: float) -> None:
        """Stress at n+1 from the nodal velocities at n; the nodes are clear again."""
        for field in self.fields:
            self._scatter(field, partition)
            field.close(0.0, np.zeros(3))
            self._solve(field, 0.0)
            field.mirror()
            self._clear(field)
        partition.table[NEW_X : NEW_Z + 1] = partition.table[X : Z + 1]
        self._update(partition, dt, whole_work=1)

    def _move(self, partition: Partition, dt: float, impulse: np.ndarray) -> tuple[float, float, float]:
        """x, v at n+1, and the nodal velocities that the strain takes.

        Returns the energy that damping, walls and absorbers removed, that which contact removed, and the loads' work.
        """
        problem, energy, contact, loaded = self.problem, 0.0, 0.0, 0.0
        damping = StepDamping(-math.expm1(-problem.damping.rate * dt), float(problem.damping.order))
        work = StepWork(0.0 if problem.scheme == Scheme.USF else 0.5, float(problem.viscosity.heating))
        for field in self.fields:
            self._scatter(field, partition)  # m, p, f at n
            field.load(partition, self.time - dt, dt, impulse)
            field.close(dt, impulse)
            field.absorb(dt, impulse)
        if self.contact:
            self.contact.add_forces(partition.table, partition.shares, self.points.packs[0], dt)
        for field in self.fields:
            self._solve(field, dt)  # v at n+1
            field.mirror()
            self.kernels.add_ghost_impulse(field.closed, field.nodes.motion, dt, impulse)
            if damping.part > 0.0 and damping.order > 1.0:
                self._smooth(field, partition)

        def move(field: Field, share: int, ranges: np.ndarray) -> None:
            to_nodes = problem.geometry, problem.shape, self.points.packs[share], partition.table, ranges
            velocities = field.nodes.motion, field.nodes.smoothed, field.tables[share]
            self.kernels.move_particles(*to_nodes, *velocities, work, damping, dt, field.lost[share])

        for field in self.fields:
            self._over_shares(field, partition, move)
            field.gathered(self.pool)
            if damping.part > 0.0:
                impulse -= field.lost[:, :3].sum(axis=0)
                energy += float(field.lost[:, 3].sum())
                field.lost[:] = 0.0
            energy += field.close_mapped()
            loaded += field.work(dt)
            if problem.scheme == Scheme.MUSL:
                nodes = field.nodes
                tables = nodes.state, nodes.state, nodes.mapped
                _over_blocks(self.pool, self.kernels.divide_mapped, field.blocks, *tables)
                field.mirror()
        if self.contact:
            contact = self.contact.energy_removed()
        for field in self.fields:
            self._clear(field)
        return energy, contact, loaded

    def _scatter(self, field: Field, partition: Partition) -> None:
        problem = self.problem

        def scatter(field: Field, share: int, ranges: np.ndarray) -> None:
            pack, tables = self.points.packs[share], (field.tables[share], field.touched[share])
            self.kernels.scatter_state(problem.geometry, problem.shape, pack, partition.table, ranges, *tables)

        self._over_shares(field, partition, scatter)
        field.gathered(self.pool)
        if len(field.tables) > 1:
            np.bitwise_or.reduce(field.touched, axis=0, out=field.touched[0])
        field.blocks = marked(field.touched[0])

    def _smooth(self, field: Field, partition: Partition) -> None:
        """The nodal velocities seen through the particles once more."""
        smoothed = field.nodes.smoothed
        smoothed[:] = 0.0  # ghosts too, in whatever block
        for share in range(len(field.tables)):
            ranges = partition.shares[share, field.bodies]
            geometry, shape = self.problem.geometry, self.problem.shape
            motion = field.nodes.motion
            scatter_smoothed(geometry, shape, self.points.packs[0], partition.table, ranges, motion, smoothed)
        fold_vectors(field.closed, smoothed, VELOCITY)
        _over_blocks(self.pool, divide_mapped, field.blocks, field.nodes.state, smoothed, smoothed)
        mirror_vectors(field.closed, smoothed, VELOCITY)

    def _check_positions(self, position: np.ndarray) -> None:
        """Report a position that is not finite: with USF particles move after their state was checked."""
        nowhere = np.flatnonzero(~np.isfinite(position).all(axis=1))
        if nowhere.size and not self.points.tallies[:, FAULT].any():
            self.points.tallies[0, [FAULT, CULPRIT]] = 1.0, nowhere[0]

    def _update(self, partition: Partition, dt: float, *, whole_work: int) -> None:
        """Each share's bodies one after another, because they have its pack in common."""
        problem = self.problem
        pairs = [(field, body) for field in self.fields for body in range(len(problem.bodies))[field.bodies]]

        def update(share: int) -> None:
            for field, body in pairs:
                where = share, body, partition.table, partition.shares[share, body].tolist()
                velocities = field.nodes.mapped
                self.points.update(problem.geometry, problem.viscosity, *where, velocities, self.time, dt, whole_work)

        self.pool.run(update, range(len(self.points.packs)))

    def _over_shares(self, field: Field, partition: Partition, call: Any) -> None:
        """A kernel over each share of the particles of a field."""
        shares = range(len(field.tables))
        self.pool.run(lambda share: call(field, share, partition.shares[share, field.bodies]), shares)

    def _solve(self, field: Field, dt: float) -> None:
        nodes = field.nodes
        tables = nodes.state, nodes.motion, nodes.mapped
        _over_blocks(self.pool, self.kernels.solve_momentum, field.blocks, *tables, dt)

    def _clear(self, field: Field) -> None:
        _over_blocks(self.pool, self.kernels.clear_lines, field.blocks, field.nodes.state)
        field.touched[:] = 0


def marked(touched: np.ndarray) -> np.ndarray:
    """Indices of the blocks that ``touched`` (n,) marks with 1.

    numpy searches booleans a word at a time: 4 us for 30 000 blocks, and 54 us as bytes (2026-11-22).
    """
    return touched.view(np.bool_).nonzero()[0]


def _over_blocks(pool: ThreadPool, work: Any, blocks: np.ndarray, *arguments: Any) -> None:
    """A kernel over blocks of nodes, cut into one range a thread."""
    if pool.threads == 1:
        work(blocks, *arguments)
        return
    shares = [blocks[begin:end] for begin, end in pool.ranges(blocks.size)]
    pool.run(lambda share: work(share, *arguments), shares)


def shares_of(ranges: Sequence[tuple[int, int]], shares: int) -> np.ndarray:
    """The particles of bodies, each from begin to end, cut into shares: (shares, bodies, 2)."""
    return np.array(
        [
            [
                [begin + (end - begin) * share // shares, begin + (end - begin) * (share + 1) // shares]
                for begin, end in ranges
            ]
            for share in range(shares)
        ],
        np.int64,
    )


@kernel
def add_lines(blocks, table, other):
    """Add the lines of another table, and clear them there."""
    for block in blocks:
        for i in range(BLOCK * block, BLOCK * (block + 1)):
            set_line(table, i, line(table, i) + line(other, i))
            set_line(other, i, spread(0.0))


@kernel
def clear_lines(blocks, table):
    """Clear the lines of some blocks for the next mapping."""
    for block in blocks:
        for i in range(BLOCK * block, BLOCK * (block + 1)):
            set_line(table, i, spread(0.0))


@kernel
def solve_momentum(blocks, state, motion, mapped, dt):
    """p(n+1) = p(n) + f dt, as velocity and acceleration; leaves momentum and force clear for the mapping back."""
    for block in blocks:
        for i in range(BLOCK * block, BLOCK * (block + 1)):
            mass = number(state, i, 0)
            if mass > 0.0:
                node = line(state, i)
                set_line(motion, i, node * (1.0 / mass))
                set_line(state, i, where(first_lanes(1), node, 0.0))
                for c in range(3):
                    mapped[i, VELOCITY + c] = motion[i, BEFORE + c] + motion[i, ACCELERATION + c] * dt


@kernel
def divide_mapped(blocks, state, momentum, velocity):
    """Velocity of nodes that carry mass, from mapped momentum."""
    for block in blocks:
        for i in range(BLOCK * block, BLOCK * (block + 1)):
            if number(state, i, 0) > 0.0:
                set_line(velocity, i, line(momentum, i) * (1.0 / number(state, i, 0)))


KERNELS = (
    scatter_state,
    add_lines,
    close_nodes,
    solve_momentum,
    mirror_nodes,
    add_ghost_impulse,
    move_particles,
    close_mapped,
    divide_mapped,
    clear_lines,
)
