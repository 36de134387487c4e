"""Smoothed particles beside finite elements in one problem: Zhang, Qiang and Gao (2011), the coupled algorithm.

Bodies with a mesh are elements, the others particles. Particles that begin at nodes of a mesh are fixed to them. In the
sums of particles the nodes stand as background particles, with their mass, place, velocity and the stress of the
elements around them at n, so that no kernel is cut at the interface; they are seen and sum nothing themselves. A fixed
particle has the mass of its node on top of its own, and moves the node: what the elements feel there is a prescribed
motion. Both methods take one step, and read each other at one time level.

The forces of background particles on particles, and of elements on prescribed nodes, are two readings of one traction,
and differ by errors of discretisation. Beyond the source, each fixed particle gets the difference of what elements
pull at its node and what background particles do to the particles nearest to it. So momentum is kept to round-off;
energy is kept to the work of the difference, which the audit shows. Only particles that begin near the mesh are in it:
nodes act on others, as debris that comes to them, without being pushed back, and the audit shows that too.
"""

import operator
from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from solver.errors import ProblemError
from solver.methods.fem.step import TOGETHER, ElementStepper
from solver.methods.sph.smoothing import SUPPORT
from solver.methods.sph.step import ParticleStepper
from solver.methods.sph.tables import MOVED
from solver.problem import Problem
from solver.state import MASS, NEW_X, VX, Particles
from solver.steps.method import Method, Partition, StepBalance
from solver.steps.points import CULPRIT, MAXIMA, StateLimits, Tally
from solver.steps.threads import ThreadPool

# Courant number of elements, of which each knows its stable step. ``Problem.courant`` is that of the particles.
COURANT_OF_ELEMENTS = 0.8
# Distance from a driven node at the start, in supports, within which nodes may come to act on a particle.
NEAR = 1.5


class CoupledStepper(Method):
    """The stages of a step of particles and elements; ``shares`` of each may be done at once."""

    def __init__(self, problem: Problem, limits: StateLimits, pool: ThreadPool, shares: int):
        meshed = [body for body in problem.bodies if body.mesh]
        if any(body.mesh for body in problem.bodies[len(meshed) :]):
            raise ProblemError("bodies with a mesh come first; reorder the bodies")
        if any(load.body >= len(meshed) for load in problem.tractions):
            raise ProblemError("a traction presses on particles; let it press on a body with a mesh")
        elements = replace(problem, bodies=tuple(meshed), smoothing=None)
        self.elements = ElementStepper(elements, limits, pool, shares)
        self.particles = ParticleStepper(replace(problem, tractions=()), limits, pool, shares)
        self.nodes = sum(body.mass.size for body in meshed)
        self.count = sum(body.mass.size for body in problem.bodies)
        # The number of the particle that is fixed to each node, or -1.
        self.fixed = _fixed_particles(problem, self.nodes)
        self._join_solids(problem)
        self._find_near(problem)
        self.faulty = False

    def advance(self, partition: Partition, time: float, dt: float) -> StepBalance:
        """Take particles, nodes and elements from n, at a time, to n+1."""
        # The elements remember the step that ended at n, for both.
        kick = 0.5 * (float(self.elements.before[0]) + dt)
        self.elements.before = np.array([dt])
        table, drivers = partition.table, self._drivers(partition.particles)
        driven = np.flatnonzero(drivers >= 0)
        own = table[MASS, driven].copy()
        self.elements.show(table[:, : self.nodes])
        self.elements.push(table, time, kick, dt)
        table[MASS, drivers[driven]] += own
        table[MASS, driven] = 0.0
        self.particles.push(partition, time, kick, dt)
        impulse = self._balance_forces(partition, drivers, kick, dt)
        table[MASS, driven] = own
        self.elements.move(table, drivers, kick, dt)
        table[MASS, driven] = 0.0
        self.particles.strain(partition, time, kick, dt)
        table[MASS, drivers[driven]] -= own
        table[MASS, driven] = own
        self.elements.strain(table, time, kick, dt)
        first, second = self.elements.balance(kick), self.particles.balance(partition, kick)
        self.faulty = first.tally.fault > 0.0
        part = self.particles.problem.courant / COURANT_OF_ELEMENTS
        slowed = first.tally._replace(signal=part * first.tally.signal, convected=part * first.tally.convected)
        return _added(first._replace(tally=slowed, impulse=first.impulse + impulse), second)

    def material_points(self, particles: Particles, body: np.ndarray) -> tuple[Particles, np.ndarray]:
        """The points with a stress that a fault is about, and the index of each one's body."""
        return self.elements.material_points(particles, body) if self.faulty else (particles, body)

    def show(self, table: np.ndarray) -> None:
        """Write the present state of the nodes."""
        self.elements.show(table[:, : self.nodes])

    def carried(self) -> dict[str, np.ndarray]:
        """Arrays that pass from step to step beside the particles."""
        return self.elements.carried()

    def take_over(self, arrays: Mapping[str, np.ndarray]) -> None:
        """Go on from what ``carried`` gave."""
        self.elements.take_over(arrays)

    def _join_solids(self, problem: Problem) -> None:
        """Make a mesh and the body of the particles that are fixed to it one solid."""
        sizes = [body.mass.size for body in problem.bodies]
        body, nodes = np.repeat(np.arange(len(sizes)), sizes), np.flatnonzero(self.fixed >= 0)
        solids = self.particles.solids
        for mesh, other in np.unique([body[nodes], body[self.fixed[nodes]]], axis=1).T:
            solids[:] = [solids[mesh] if one == solids[other] else one for one in solids]

    def _find_near(self, problem: Problem) -> None:
        """The particles that nodes may act on, and the driven node that each is nearest to, at the start."""
        from scipy.spatial import cKDTree

        position = np.concatenate([body.position for body in problem.bodies])
        nodes, first = np.flatnonzero(self.fixed >= 0), self.nodes
        apart, nearest = cKDTree(position[nodes]).query(position[first:])
        assert problem.smoothing is not None
        reach = NEAR * SUPPORT * problem.smoothing.ratio * problem.geometry.spacing
        near = np.flatnonzero(apart < reach)
        self.near, self.nearest = near + first, nodes[nearest[near]]

    def _balance_forces(self, partition: Partition, drivers: np.ndarray, kick: float, dt: float) -> np.ndarray:
        """Give fixed particles what elements pull at their nodes, less what nodes do to the particles near them.

        Returns the impulse (3,) of planes of symmetry that particles and elements do not book, N s.
        """
        table, column = partition.table, self._columns(partition.particles)
        there = column[self.near] >= 0
        near, nearest = column[self.near[there]], self.nearest[there]
        by_nodes = self.particles.forces_of_others(partition, near)
        driven = np.flatnonzero(drivers >= 0)
        moving = drivers[driven]
        impulse = -by_nodes[:, 3:].sum(axis=0) * kick
        for axis in range(3):
            missing = np.bincount(
                self.elements.node_of, self.elements.forces[:, axis], minlength=self.nodes
            ) - np.bincount(nearest, by_nodes[:, axis], minlength=self.nodes)
            held = self.elements.held[driven, axis] == 1
            impulse[axis] -= missing[driven][held].sum() * kick
            change = np.where(held, 0.0, missing[driven]) / table[MASS, moving] * kick
            np.add.at(table[VX + axis], moving, change)
            np.add.at(table[NEW_X + axis], moving, change * dt)
            np.add.at(self.particles.tables.other[:, MOVED + axis], moving, change)
        return impulse

    def _drivers(self, particles: Particles) -> np.ndarray:
        """The column of the particle that is fixed to each node, or -1."""
        return np.where(self.fixed >= 0, self._columns(particles)[self.fixed], -1)

    def _columns(self, particles: Particles) -> np.ndarray:
        """The column of each particle by its number, -1 of those that have departed."""
        column = np.full(self.count, -1)
        column[particles.number] = np.arange(particles.number.size)
        return column


def _fixed_particles(problem: Problem, nodes: int) -> np.ndarray:
    """The number of the particle that begins at each node, or -1; raises ProblemError without any."""
    position = np.concatenate([body.position for body in problem.bodies])
    place = np.rint(position / (TOGETHER * problem.geometry.spacing)).astype(np.int64)
    _, site = np.unique(place, axis=0, return_inverse=True)
    site = site.ravel()
    at_site = np.full(site.max() + 1, -1)
    at_site[site[nodes:]] = np.arange(nodes, site.size)
    fixed: np.ndarray = at_site[site[:nodes]]
    if (fixed < 0).all():
        raise ProblemError("no particle begins at a node; let particles and mesh meet on common nodes")
    return fixed


def _added(first: StepBalance, second: StepBalance) -> StepBalance:
    """The balances of both methods in one: sums, and the largest speeds and rates."""
    tally = np.add(first.tally, second.tally)
    tally[:MAXIMA] = np.maximum(first.tally, second.tally)[:MAXIMA]
    tally[CULPRIT] = first.tally.culprit if first.tally.fault else second.tally.culprit
    return StepBalance(*map(operator.add, first, second))._replace(tally=Tally(*tally.tolist()))
