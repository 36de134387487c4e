"""One step of the modified update-stress-last scheme, in its ordered stages.

Ma (2005), section 2.2.4. Particles hold x, v, sigma at time n. Nodes hold m, p at n and f at n; then p at n+1;
particles take x, v at n+1; their momentum is mapped back and gives the nodal velocity at n+1, from which strain and
stress at n+1 follow. All weights are those of x at n.

Energy: the forces of stress n change the kinetic energy of the particles by f . (v(n) + v(n+1)) / 2 dt at the nodes,
with v(n) mapped before and v(n+1) mapped back after them. That is, particle by particle, minus the work of its own
stress in the mean of the two velocity gradients, and so the internal energy takes it: half when the forces act, half
in the strain update. Kinetic and internal energy then live at the same time level and their sum is kept to round-off,
whatever the stress is (compatible differencing: Caramana et al. 1998, J. Comput. Phys. 146, 227). Pressure and
temperature want the energy at the time of the density, half a step later; they add that half by prediction, implicit
in the pressure.
"""

from typing import NamedTuple

import numpy as np

from solver.faces import cross_faces, hold_face
from solver.geometry import face_nodes
from solver.jit import kernel
from solver.problem import Body, Face, Problem
from solver.state import Nodes, Particles
from solver.stress import CHUNK, Limits, Tally, chunks_of, update_chunks
from solver.threads import Team
from solver.transfer import move_particles, scatter_state, slab_count, sort_into_slabs


class Stepper:
    """The ordered stages of a step over one problem's arrays."""

    def __init__(self, problem: Problem, nodes: Nodes, limits: Limits, team: Team):
        self.problem = problem
        self.nodes = nodes
        self.limits = limits
        self.team = team
        self.faces = np.array(problem.faces, dtype=np.int64).reshape(3, 2)
        self.held = [
            (axis, side, int(kind), face_nodes(problem.geometry, axis, side))
            for axis in range(3)
            for side, kind in enumerate(problem.faces[axis])
            if kind != Face.FREE and problem.geometry.nodes[axis] > 1
        ]
        self.node_ranges = team.ranges(nodes.mass.size)
        slabs = np.arange(slab_count(problem.geometry))
        self.parities = (slabs[0::2], slabs[1::2])

    def advance(self, stage: "Stage", tally: Tally, dt: float) -> tuple[np.ndarray, int]:
        """Take the particles from n to n+1; returns the impulse (3,) of the faces and the particles they put back."""
        geometry, shape, nodes = self.problem.geometry, self.problem.shape, self.nodes
        heating = self.problem.viscosity.heating
        particles, moved, order, start = stage.particles, stage.moved, stage.order, stage.slab_start
        sort_into_slabs(geometry, particles, order, start)
        shares = self._shares(np.diff(start))

        for slabs in shares:  # m, p, f at n
            self.team.run(
                lambda share: scatter_state(geometry, shape, particles, order, start, share, nodes),
                slabs,
            )
        impulse = self._hold(dt)
        self.team.run(lambda part: solve_momentum(nodes, *part, dt), self.node_ranges)  # v at n+1
        for slabs in shares:  # x, v at n+1
            self.team.run(
                lambda share: move_particles(
                    geometry, shape, particles, moved, order, start, share, nodes, heating, dt
                ),
                slabs,
            )
        self._hold(0.0)
        self.team.run(lambda part: finish_nodes(nodes, *part), self.node_ranges)  # mapped back, n+1
        row = reflected = 0
        for body, (begin, end) in zip(self.problem.bodies, stage.ranges, strict=True):
            self._update_body(body, stage, begin, end, tally, row, dt)  # sigma at n+1
            row += chunks_of(end - begin)
        if tally.outside.any():
            reflected = cross_faces(geometry, self.faces, particles, impulse)
        return impulse, reflected

    def _shares(self, load: np.ndarray) -> list[list[np.ndarray]]:
        """Slabs for each thread: the even ones, and then the odd ones; empty slabs are left out."""
        return [self.team.balanced(load, slabs[load[slabs] > 0]) for slabs in self.parities]

    def _update_body(
        self, body: Body, stage: "Stage", begin: int, end: int, tally: Tally, row: int, dt: float
    ) -> None:
        problem = self.problem

        def update(part: tuple[int, int]) -> None:
            update_chunks(
                problem.geometry,
                problem.shape,
                body.matter,
                problem.viscosity,
                self.limits,
                stage.particles,
                stage.moved,
                begin + part[0],
                begin + part[1],
                self.nodes,
                tally,
                row + part[0] // CHUNK,
                dt,
            )

        self.team.run(update, self.team.ranges(end - begin, CHUNK))

    def _hold(self, dt: float) -> np.ndarray:
        impulse = np.zeros(3)
        for axis, side, kind, index in self.held:
            hold_face(self.nodes, index, axis, side, kind, dt, impulse)
        return impulse


class Stage(NamedTuple):
    """The particle arrays of a step and the scratch that goes with them."""

    particles: Particles
    moved: np.ndarray  # (n, 3) positions at n+1 while those at n are still needed, m
    order: np.ndarray  # (n,) living particles slab by slab
    slab_start: np.ndarray  # (slabs + 1,) where each slab begins in ``order``
    ranges: list[tuple[int, int]]  # (begin, end) of each body


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
def finish_nodes(nodes, begin, end):
    """Velocity of nodes that carry mass, from the momentum mapped back; leaves the nodes clear for the next step."""
    for i in range(begin, end):
        if nodes.mass[i] > 0.0:
            for axis in range(3):
                nodes.velocity[i, axis] = nodes.momentum[i, axis] / nodes.mass[i]
                nodes.momentum[i, axis] = 0.0
            nodes.mass[i] = 0.0
