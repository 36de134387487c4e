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
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace

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
from solver.grid.transfer import StepDamping, StepWork, move_particles, scatter_smoothed, scatter_state, scatter_surface
from solver.jit import Bound, Record, kernel
from solver.problem import Problem, Scheme
from solver.problem.geometry import Geometry, dimensions, node_count
from solver.state import NEW_X, NEW_Z, X, Z, lines
from solver.steps.crossing import cross_faces
from solver.steps.method import Method, Partition, StepBalance
from solver.steps.points import CULPRIT, FAULT, OUTSIDE, PointUpdate, StateLimits
from solver.steps.space import VELOCITY, Pack
from solver.steps.threads import ThreadPool
from solver.vectors import first_lanes, line, number, set_line, spread, where


class Kernels:
    """The kernels of each step, bound to the types of one problem."""

    def __init__(self) -> None:
        self.scatter_state = Bound(scatter_state)
        self.add_lines = Bound(add_lines)
        self.close_nodes = Bound(close_nodes)
        self.solve_momentum = Bound(solve_momentum)
        self.mirror_nodes = Bound(mirror_nodes)
        self.add_ghost_impulse = Bound(add_ghost_impulse)
        self.move_particles = Bound(move_particles)
        self.close_mapped = Bound(close_mapped)
        self.divide_mapped = Bound(divide_mapped)
        self.clear_lines = Bound(clear_lines)


class Field:
    """One velocity field: its nodes, the closed faces around them, which bodies move in it, and its part of each stage.

    Each share of the particles adds to a table of its own, with the scratch of one of ``packs``; the first table is
    that of the nodes.
    """

    def __init__(self, problem: Problem, bodies: slice, kernels: Kernels, pool: ThreadPool, packs: Sequence[Pack]):
        self.problem, self.bodies, self.kernels, self.pool, self.packs = problem, bodies, kernels, pool, packs
        # Small pages cost nothing in two dimensions, and a fifth of a step in three, where neighbours of a node lie in
        # nine of them (3-D linear 31.7 -> 38.4, axisymmetric spline 21.4 -> 21.6 reference numbers, 2026-11-22).
        sparse, smooth = dimensions(problem.geometry) == 2, problem.damping.order > 1
        count = node_count(problem.geometry)
        self.nodes = empty_nodes(count, smooth=smooth, surface=problem.contact is not None, sparse=sparse)
        whole = len(self.nodes.mass)
        self.tables = [self.nodes.state, *(lines(whole, sparse=sparse) for _ in packs[1:])]
        self.touched = np.zeros((len(packs), whole // BLOCK), np.uint8)
        self.blocks = np.zeros(0, np.int64)  # of nodes that particles touch in this step
        self.closed = closed_nodes(problem.geometry, problem.faces, problem.clamp)
        self.lost = np.zeros((len(packs), 4))
        ours = range(len(problem.bodies))[bodies]
        self.dashpots = [dashpots(problem, one, self.closed) for one in problem.absorbers if one.body in ours]
        self.loads = Loads(problem, ours)

    def scatter(self, partition: Partition) -> None:
        """m, p and f at n from the particles."""
        tables, touched = self.tables, self.touched

        def scatter(share: int) -> None:
            self.kernels.scatter_state(*self._particles_of(partition, share), tables[share], touched[share])

        self.pool.run(scatter, range(len(tables)))
        self._sum_shares()
        if len(tables) > 1:
            np.bitwise_or.reduce(touched, axis=0, out=touched[0])
        self.blocks = marked(touched[0])

    def load(self, partition: Partition, time: float, dt: float, impulse: np.ndarray) -> None:
        """f at n with loads, faces and absorbing surfaces."""
        if not self.loads.is_idle:
            impulse += self.loads.add(self.nodes, partition.table, partition.shares, time=time, dt=dt)
        self.close(dt, impulse)
        for surface in self.dashpots:
            absorb(surface, self.nodes, dt, impulse)

    def close(self, dt: float, impulse: np.ndarray) -> None:
        """Fold the ghosts and hold the faces."""
        self.kernels.close_nodes(self.closed, self.touched[0], self.nodes.state, dt, impulse)
        if dt and not self.loads.is_idle:
            fold_vectors(self.closed, self.loads.table, FORCE)

    def scatter_surface(self, partition: Partition) -> None:
        """Outward areas of the body at n."""
        geometry, shape, areas = self.problem.geometry, self.problem.shape, self.nodes.areas
        areas[:] = 0.0  # ghosts too, in whatever block
        for ranges in partition.shares[:, self.bodies]:  # into one table, so one after another
            scatter_surface(geometry, shape, self.packs[0], partition.table, ranges, areas, self.touched[0])
        fold_vectors(self.closed, areas, FORCE)
        mirror_vectors(self.closed, areas, FORCE)

    def solve(self, dt: float) -> None:
        """v and a at n, and v at n+1; the ghosts' too."""
        nodes = self.nodes
        self._over_blocks(self.kernels.solve_momentum, nodes.state, nodes.motion, nodes.mapped, dt)
        self.mirror()

    def smooth(self, partition: Partition) -> None:
        """v at n seen through the particles once more."""
        geometry, shape, nodes = self.problem.geometry, self.problem.shape, self.nodes
        nodes.smoothed[:] = 0.0  # ghosts too, in whatever block
        for ranges in partition.shares[:, self.bodies]:
            scatter_smoothed(geometry, shape, self.packs[0], partition.table, ranges, nodes.motion, nodes.smoothed)
        fold_vectors(self.closed, nodes.smoothed, VELOCITY)
        self._over_blocks(divide_mapped, nodes.state, nodes.smoothed, nodes.smoothed)
        mirror_vectors(self.closed, nodes.smoothed, VELOCITY)

    def move(self, partition: Partition, work: StepWork, damping: StepDamping, dt: float) -> None:
        """x and v of the particles at n+1, and their p back on the nodes."""
        seen = self.nodes.motion, self.nodes.smoothed

        def move(share: int) -> None:
            ours = self._particles_of(partition, share)
            self.kernels.move_particles(*ours, *seen, self.tables[share], work, damping, dt, self.lost[share])

        self.pool.run(move, range(len(self.tables)))
        self._sum_shares()

    def close_mapped(self) -> float:
        """Hold the faces in the momentum mapped back; returns the energy that walls and absorbers removed, J."""
        energy: float = self.kernels.close_mapped(self.closed, self.nodes.state)
        for surface in self.dashpots:
            energy += energy_absorbed(surface, self.nodes)
        return energy

    def divide(self) -> None:
        """v at n+1 from the momentum mapped back."""
        self._over_blocks(self.kernels.divide_mapped, self.nodes.state, self.nodes.state, self.nodes.mapped)
        self.mirror()

    def mirror(self) -> None:
        """Velocities of the ghosts."""
        self.kernels.mirror_nodes(self.closed, self.nodes.motion, self.nodes.mapped)

    def clear(self) -> None:
        """No mass on any node."""
        self._over_blocks(self.kernels.clear_lines, self.nodes.state)
        self.touched[:] = 0

    def _particles_of(
        self, partition: Partition, share: int
    ) -> tuple[Geometry, Record | None, Pack, np.ndarray, np.ndarray]:
        """What kernels take of the particles of a share in this field."""
        ranges = partition.shares[:, self.bodies]
        return self.problem.geometry, self.problem.shape, self.packs[share], partition.table, ranges[share]

    def _sum_shares(self) -> None:
        """Sum the tables of the shares in the first one, in their order."""
        for table, touched in zip(self.tables[1:], self.touched[1:], strict=True):
            self._over_blocks(self.kernels.add_lines, self.nodes.state, table, blocks=marked(touched))

    def _over_blocks(
        self, work: Callable[..., None], *arguments: np.ndarray | float, blocks: np.ndarray | None = None
    ) -> None:
        """A kernel over blocks of nodes, by default all that particles touch, cut into one range a thread."""
        found = self.blocks if blocks is None else blocks
        ranges = self.pool.ranges(found.size)
        self.pool.run(lambda share: work(found[share[0] : share[1]], *arguments), ranges)


class Stepper(Method):
    """The ordered stages of a step over one problem's arrays; ``shares`` of the particles may be done at once."""

    def __init__(self, problem: Problem, limits: StateLimits, pool: ThreadPool, shares: int):
        self.problem = problem = problem if problem.shape is not None else replace(problem, shape=Linear())
        self.pool, self.kernels = pool, Kernels()
        self.points = PointUpdate(problem, limits, shares)
        self.faces = np.array(problem.faces, dtype=np.int64).reshape(3, 2)
        count = len(problem.bodies)
        bodies = [slice(i, i + 1) for i in range(count)] if problem.contact else [slice(0, count)]
        self.fields = [Field(problem, ours, self.kernels, pool, self.points.packs) for ours in bodies]
        self.contact = (
            NodalContact(problem, problem.contact, [field.nodes for field in self.fields]) if problem.contact else None
        )

    def carried(self) -> dict[str, np.ndarray]:
        """Arrays that pass from step to step beside the particles."""
        return {"taken": self.contact.taken()} if self.contact else {}

    def take_over(self, arrays: Mapping[str, np.ndarray]) -> None:
        """Go on from what ``carried`` gave."""
        if self.contact:
            self.contact.take_over(arrays["taken"])

    def advance(self, partition: Partition, time: float, dt: float) -> StepBalance:
        """Take the particles from n, at a time, to n+1."""
        problem, impulse, end = self.problem, np.zeros(3), time + dt
        if problem.scheme == Scheme.USF:
            self._strain_before(partition, end, dt)
        energy, contact, work = self._move(partition, end, dt, impulse)
        if problem.scheme == Scheme.USF:
            partition.table[X : Z + 1] = partition.table[NEW_X : NEW_Z + 1]
            self._check_positions(partition.particles.position)
            self.points.tallies[:, OUTSIDE] = 1.0  # they moved after it was counted: every step looks
        else:
            self._strain(partition, end, dt, whole_work=0)
        tally, gone, reflected = self.points.tally(), 0, 0
        if tally.outside:
            gone, reflected = cross_faces(problem.geometry, self.faces, problem.clamp, partition.particles, impulse)
        return StepBalance(impulse, energy, contact, work, gone, reflected, tally)

    def _strain_before(self, partition: Partition, end: float, dt: float) -> None:
        """sigma at n+1 from the nodal v at n; the nodes are clear again."""
        for field in self.fields:
            field.scatter(partition)
            field.close(0.0, np.zeros(3))
            field.solve(0.0)
            field.clear()
        partition.table[NEW_X : NEW_Z + 1] = partition.table[X : Z + 1]
        self._strain(partition, end, dt, whole_work=1)

    def _move(self, partition: Partition, end: float, dt: float, impulse: np.ndarray) -> tuple[float, float, float]:
        """x and v at n+1, and the nodal v that the strain takes.

        Returns the energy that damping, walls and absorbers removed, that which contact removed, and the loads' work.
        """
        problem, energy, contact, loaded = self.problem, 0.0, 0.0, 0.0
        damping = StepDamping(-math.expm1(-problem.damping.rate * dt), float(problem.damping.order))
        work = StepWork(0.0 if problem.scheme == Scheme.USF else 0.5, float(problem.viscosity.heating))
        for field in self.fields:
            field.scatter(partition)  # m, p, f at n
            field.load(partition, end - dt, dt, impulse)
        if self.contact:
            for field in self.fields:
                field.scatter_surface(partition)
            self.contact.add_forces(partition.table, partition.shares, self.points.packs[0], dt)
        for field in self.fields:
            field.solve(dt)  # v at n+1
            self.kernels.add_ghost_impulse(field.closed, field.nodes.motion, dt, impulse)
            if damping.part > 0.0 and damping.order > 1.0:
                field.smooth(partition)
        for field in self.fields:
            field.move(partition, work, damping, dt)  # x, v at n+1, and p at n+1
            if damping.part > 0.0:
                impulse -= field.lost[:, :3].sum(axis=0)
                energy += float(field.lost[:, 3].sum())
                field.lost[:] = 0.0
            energy += field.close_mapped()
            if not field.loads.is_idle:
                loaded += field.loads.work(field.nodes, dt)
            if problem.scheme == Scheme.MUSL:
                field.divide()  # v at n+1
        if self.contact:
            contact = self.contact.energy_removed()
        for field in self.fields:
            field.clear()
        return energy, contact, loaded

    def _strain(self, partition: Partition, end: float, dt: float, *, whole_work: int) -> None:
        """sigma at n+1: each share's bodies one after another, because they have its pack in common."""
        problem = self.problem
        mapped = [field.nodes.mapped for field in self.fields for _ in range(len(problem.bodies))[field.bodies]]

        def strain(share: int) -> None:
            for body, velocities in enumerate(mapped):
                place = share, body, partition.table, partition.shares[share, body].tolist()
                self.points.update(problem.geometry, problem.viscosity, *place, velocities, end, dt, whole_work)

        self.pool.run(strain, range(len(self.points.packs)))

    def _check_positions(self, position: np.ndarray) -> None:
        """Report a position that is not finite: with USF particles move after their state was checked."""
        nowhere = np.flatnonzero(~np.isfinite(position).all(axis=1))
        if nowhere.size and not self.points.tallies[:, FAULT].any():
            self.points.tallies[0, [FAULT, CULPRIT]] = 1.0, nowhere[0]


def marked(touched: np.ndarray) -> np.ndarray:
    """Indices of the blocks that ``touched`` (n,) marks with 1.

    numpy searches booleans a word at a time: 4 us for 30 000 blocks, and 54 us as bytes (2026-11-22).
    """
    return touched.view(np.bool_).nonzero()[0]


def shares_of(ranges: Sequence[tuple[int, int]], shares: int) -> np.ndarray:
    """The particles of bodies, each from begin to end, cut into shares: (shares, bodies, 2)."""
    begin, end = np.array(ranges, np.int64).T
    edges = begin + (end - begin) * np.arange(shares + 1)[:, None] // shares
    return np.stack([edges[:-1], edges[1:]], axis=-1)


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
