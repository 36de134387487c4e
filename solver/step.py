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

import itertools
from collections.abc import Iterator
from typing import Any, NamedTuple

import numpy as np

from solver.absorb import absorb, dashpots, energy_absorbed
from solver.contact import empty_meeting, energy_taken, meet, scatter_surface
from solver.faces import (
    Layer,
    book_ghosts,
    closed_layers,
    cross_faces,
    fold_state,
    fold_vectors,
    hold_mapped,
    hold_state,
    judge_wall,
    mirror_vectors,
    mirror_velocity,
)
from solver.geometry import node_count
from solver.jit import kernel
from solver.problem import Body, Face, Problem, Scheme
from solver.state import Nodes, Particles, empty_nodes
from solver.stress import BAD_POSITION, CHUNK, Limits, Tally, chunks_of, update_chunks
from solver.threads import Team
from solver.transfer import (
    move_particles,
    scatter_smoothed,
    scatter_state,
    slab_count,
    sort_into_slabs,
)


class Stage(NamedTuple):
    """The particle arrays of a step and the scratch that goes with them."""

    particles: Particles
    moved: np.ndarray  # (n, 3) positions at n+1 while those at n are still needed, m
    order: np.ndarray  # (n,) living particles, field by field and in it slab by slab
    ranges: list[tuple[int, int]]  # (begin, end) of each body


class Booked(NamedTuple):
    """What one step gave or took from outside the equations of motion."""

    impulse: (
        np.ndarray
    )  # (3,) given by faces and absorbers, to nodes or in what damping does next to them, N s
    energy: float  # taken by damping, walls and absorbers, J
    contact: float  # taken by contact between bodies, J
    reflected: int  # particles put back at closed faces


class Field:
    """One velocity field: its nodes, the closed faces around them, and which bodies move in it."""

    def __init__(self, problem: Problem, bodies: slice):
        self.nodes = empty_nodes(node_count(problem.geometry))
        self.layers = closed_layers(problem.geometry, problem.faces, problem.clamp)
        slabs = slab_count(problem.geometry)
        self.slab_start = np.zeros(slabs + 1, np.int64)
        self.lost = np.zeros((slabs, 4))
        self.bodies = bodies
        ours = range(len(problem.bodies))[bodies]
        self.dashpots = [
            dashpots(problem, one, self.layers) for one in problem.absorbers if one.body in ours
        ]

    def walls(self) -> Iterator[Layer]:
        """The layers, axis by axis."""
        for axis in self.layers:
            yield from axis

    def close(self, dt: float, impulse: np.ndarray) -> None:
        """Fold the ghosts and hold the faces, axis by axis, so that corners are folded once along each."""
        for axis in self.layers:
            for layer in axis:
                if layer.kind == Face.WALL:
                    judge_wall(layer, self.nodes, dt)
                fold_state(layer, self.nodes)
            for layer in axis:
                hold_state(layer, self.nodes, dt, impulse)

    def absorb(self, dt: float, impulse: np.ndarray) -> None:
        """Forces of the absorbing surfaces."""
        for surface in self.dashpots:
            absorb(surface, self.nodes, dt, impulse)

    def close_mapped(self) -> float:
        """The same for the momentum mapped back; returns the energy that walls and absorbers took, J."""
        energy = 0.0
        for axis in self.layers:
            for layer in axis:
                fold_vectors(layer, self.nodes.momentum)
            for layer in axis:
                energy += hold_mapped(layer, self.nodes)
        for surface in self.dashpots:
            energy += energy_absorbed(surface, self.nodes)
        return energy

    def mirror(self) -> None:
        """Velocities of the ghosts, in the reverse order of the fold."""
        for axis in reversed(self.layers):
            for layer in axis:
                mirror_velocity(layer, self.nodes)


class Stepper:
    """The ordered stages of a step over one problem's arrays."""

    def __init__(self, problem: Problem, limits: Limits, team: Team):
        self.problem = problem
        self.limits = limits
        self.team = team
        self.faces = np.array(problem.faces, dtype=np.int64).reshape(3, 2)
        bodies = len(problem.bodies)
        apart = bodies if problem.contact else 1  # contact asks for a field a body
        self.fields = [
            Field(problem, slice(i, i + 1) if problem.contact else slice(0, bodies))
            for i in range(apart)
        ]
        self.pairs = [
            (first, second, empty_meeting(node_count(problem.geometry)))
            for first, second in itertools.combinations(range(apart), 2)
        ]
        self.node_ranges = team.ranges(node_count(problem.geometry))
        slabs = np.arange(slab_count(problem.geometry))
        self.parities = (slabs[0::2], slabs[1::2])

    def advance(self, stage: Stage, tally: Tally, dt: float) -> Booked:
        """Take the particles from n to n+1."""
        scheme, impulse = self.problem.scheme, np.zeros(3)
        self._sort(stage)
        if scheme == Scheme.USF:
            self._update_first(stage, tally, dt)
        energy, contact = self._move(stage, dt, impulse)
        if scheme == Scheme.USF:
            stage.particles.position[:] = stage.moved
            _find_nowhere(stage.moved, tally)
        else:
            self._update(stage, tally, dt, keep=0)  # sigma at n+1
        reflected = 0
        if tally.outside.any():
            reflected = cross_faces(
                self.problem.geometry, self.faces, self.problem.clamp, stage.particles, impulse
            )
        return Booked(impulse, energy, contact, reflected)

    def _sort(self, stage: Stage) -> None:
        for field in self.fields:
            begin, end = _span(stage, field)
            sort_into_slabs(
                self.problem.geometry,
                stage.particles,
                begin,
                end,
                stage.order[begin:end],
                field.slab_start,
            )

    def _update_first(self, stage: Stage, tally: Tally, dt: float) -> None:
        """Stress at n+1 from the nodal velocities at n; the nodes are clear again."""
        for field in self.fields:
            self._scatter(field, stage)
            field.close(0.0, np.zeros(3))
            self._on_nodes(solve_momentum, field.nodes, 0.0)
            field.mirror()
            self._on_nodes(clear_nodes, field.nodes)
        stage.moved[:] = stage.particles.position
        self._update(stage, tally, dt, keep=1)
        tally.outside[:] = 1  # they move after this: every step looks

    def _move(self, stage: Stage, dt: float, impulse: np.ndarray) -> tuple[float, float]:
        """x, v at n+1, and the nodal velocities that the strain takes.

        Returns the energy that damping, walls and absorbers took, and what contact took.
        """
        problem, energy, contact = self.problem, 0.0, 0.0
        part = -np.expm1(-problem.damping.rate * dt)
        damping = (float(part), float(problem.damping.order))
        halves = 0.0 if problem.scheme == Scheme.USF else 0.5
        work = (halves, problem.viscosity.heating)
        for field in self.fields:
            self._scatter(field, stage)  # m, p, f at n
            field.close(dt, impulse)
            field.absorb(dt, impulse)
        self._meet(stage, dt)
        for field in self.fields:
            self._on_nodes(solve_momentum, field.nodes, dt)  # v at n+1
            field.mirror()
            for layer in field.walls():
                book_ghosts(layer, field.nodes, dt, impulse)
            if damping[0] > 0.0 and damping[1] == 2.0:
                self._smooth(field, stage)
        for field in self.fields:
            field.lost[:] = 0.0
            self._over_slabs(
                move_particles,
                field,
                stage,
                stage.moved,
                field.nodes,
                work,
                damping,
                dt,
                field.lost,
            )
            impulse -= field.lost[:, :3].sum(axis=0)
            energy += float(field.lost[:, 3].sum())
            energy += field.close_mapped()
            if problem.scheme == Scheme.MUSL:
                self._on_nodes(take_mapped, field.nodes)
                field.mirror()
        for first, second, meeting in self.pairs:
            contact += energy_taken(self.fields[first].nodes, self.fields[second].nodes, meeting)
        for field in self.fields:
            self._on_nodes(clear_nodes, field.nodes)
        return energy, contact

    def _meet(self, stage: Stage, dt: float) -> None:
        """Contact forces between the bodies, pair after pair."""
        contact = self.problem.contact
        if contact is None:
            return
        for field in self.fields:
            self._scatter_surface(field, stage)
        for first, second, meeting in self.pairs:
            nodes, others = self.fields[first].nodes, self.fields[second].nodes
            meet(nodes, others, meeting, contact.friction, dt)

    def _scatter_surface(self, field: Field, stage: Stage) -> None:
        field.nodes.surface[:] = 0.0
        self._over_slabs(scatter_surface, field, stage, field.nodes.surface)
        for axis in field.layers:
            for layer in axis:
                fold_vectors(layer, field.nodes.surface)
            for layer in axis:
                mirror_vectors(layer, field.nodes.surface)

    def _scatter(self, field: Field, stage: Stage) -> None:
        self._over_slabs(scatter_state, field, stage, field.nodes)

    def _smooth(self, field: Field, stage: Stage) -> None:
        """The nodal velocities seen through the particles once more."""
        field.nodes.smooth[:] = 0.0
        self._over_slabs(scatter_smoothed, field, stage, field.nodes)
        for layer in field.walls():
            fold_vectors(layer, field.nodes.smooth)
        self._on_nodes(divide_smooth, field.nodes)
        for axis in reversed(field.layers):
            for layer in axis:
                mirror_vectors(layer, field.nodes.smooth)

    def _update(self, stage: Stage, tally: Tally, dt: float, *, keep: int) -> None:
        row = 0
        for field in self.fields:
            pairs = list(zip(self.problem.bodies, stage.ranges, strict=True))[field.bodies]
            for body, (begin, end) in pairs:
                self._update_body(body, field.nodes, stage, begin, end, tally, row, dt, keep)
                row += chunks_of(end - begin)

    def _update_body(
        self,
        body: Body,
        nodes: Nodes,
        stage: Stage,
        begin: int,
        end: int,
        tally: Tally,
        row: int,
        dt: float,
        keep: int,
    ) -> None:
        def update(part: tuple[int, int]) -> None:
            update_chunks(
                self.problem.geometry,
                self.problem.shape,
                body.matter,
                self.problem.viscosity,
                self.limits,
                stage.particles,
                stage.moved,
                begin + part[0],
                begin + part[1],
                nodes,
                tally,
                row + part[0] // CHUNK,
                dt,
                keep,
            )

        self.team.run(update, self.team.ranges(end - begin, CHUNK))

    def _over_slabs(self, work: Any, field: Field, stage: Stage, *arguments: Any) -> None:
        """A kernel over the particles of a field, slab by slab."""
        begin, end = _span(stage, field)
        order = stage.order[begin:end]
        for slabs in self._shares(field):
            self.team.run(
                lambda share: work(
                    self.problem.geometry,
                    self.problem.shape,
                    stage.particles,
                    order,
                    field.slab_start,
                    share,
                    *arguments,
                ),
                slabs,
            )

    def _shares(self, field: Field) -> list[list[np.ndarray]]:
        """Slabs for each thread: the even ones, and then the odd ones; empty slabs are left out."""
        load = np.diff(field.slab_start)
        return [self.team.balanced(load, slabs[load[slabs] > 0]) for slabs in self.parities]

    def _on_nodes(self, work: Any, nodes: Nodes, *arguments: float) -> None:
        self.team.run(lambda part: work(nodes, *part, *arguments), self.node_ranges)


def _find_nowhere(position: np.ndarray, tally: Tally) -> None:
    """Report a place that is no number: with USF particles move after all else has been looked at."""
    nowhere = np.flatnonzero(~np.isfinite(position).all(axis=1))
    if nowhere.size and not tally.fault.any():
        tally.fault[0], tally.culprit[0], tally.value[0] = BAD_POSITION, nowhere[0], np.nan


def _span(stage: Stage, field: Field) -> tuple[int, int]:
    """Where the particles of a field's bodies begin and end."""
    ranges = stage.ranges[field.bodies]
    return ranges[0][0], ranges[-1][1]


@kernel
def solve_momentum(nodes, begin, end, dt):
    """p(n+1) = p(n) + f dt, as velocity and acceleration; leaves momentum and force clear for the mapping back."""
    for i in range(begin, end):
        if nodes.mass[i] > 0.0:
            for axis in range(3):
                acceleration = nodes.force[i, axis] / nodes.mass[i]
                nodes.before[i, axis] = nodes.momentum[i, axis] / nodes.mass[i]
                nodes.acceleration[i, axis] = acceleration
                nodes.velocity[i, axis] = nodes.before[i, axis] + acceleration * dt
                nodes.momentum[i, axis] = 0.0
                nodes.force[i, axis] = 0.0


@kernel
def divide_smooth(nodes, begin, end):
    """Mapped momentum of the smoothed velocities becomes their velocity."""
    for i in range(begin, end):
        if nodes.mass[i] > 0.0:
            for axis in range(3):
                nodes.smooth[i, axis] /= nodes.mass[i]


@kernel
def take_mapped(nodes, begin, end):
    """Velocity of nodes that carry mass, from the momentum mapped back."""
    for i in range(begin, end):
        if nodes.mass[i] > 0.0:
            for axis in range(3):
                nodes.velocity[i, axis] = nodes.momentum[i, axis] / nodes.mass[i]


@kernel
def clear_nodes(nodes, begin, end):
    """No mass and no momentum, for the next mapping."""
    for i in range(begin, end):
        if nodes.mass[i] > 0.0:
            nodes.mass[i] = 0.0
            for axis in range(3):
                nodes.momentum[i, axis] = 0.0
