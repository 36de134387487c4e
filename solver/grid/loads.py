"""Loads: tractions on surfaces of bodies, and gravity; their work adds to the energy.

A traction is a pressure p(t) on the flat end of a body. Nodes near the end have its area, the sum of V grad N as with
contact and absorbing surfaces: minus the pressure times it is their force. The end is where the outermost particles
are, so that the load follows the body. Gravity is the weight of a node's mass. Both are forces of the step like the
internal ones, so that faces fold and hold them.

Their work is that of their impulses in the mean of the velocities before and after the step.
"""

import numpy as np

from solver.grid.nodes import FORCE, Nodes, node_positions
from solver.grid.transfer import scatter_surface
from solver.problem import Body, Problem, Traction, mean_pressure
from solver.problem.geometry import node_count
from solver.state import MASS, X, lines
from solver.steps.space import new_pack

REACH = 2.0  # cells on either side of an end: its nodes, for any shape


class Loads:
    """The loads on the bodies of a velocity field."""

    def __init__(self, problem: Problem, bodies: range):
        self.problem = problem
        self.gravity = np.array(problem.gravity)
        self.tractions = [load for load in problem.tractions if load.body in bodies]
        self.is_idle = not self.tractions and not self.gravity.any()
        if self.is_idle:
            return
        self.table = lines(-(-node_count(problem.geometry) // 8) * 8)
        self.areas = np.zeros_like(self.table)
        self.touched = np.zeros(self.table.shape[0] // 8, np.uint8)
        self.place = node_positions(problem.geometry)
        self.pack = new_pack()

    def add(self, nodes: Nodes, table: np.ndarray, shares: np.ndarray, *, time: float, dt: float) -> np.ndarray:
        """Add the loads of a step to the forces, before faces fold them; returns their impulse (3,), N s.

        ``table`` has the particles, ``shares`` (shares, bodies, 2) where those of each body begin and end.
        """
        forces = self.table[:, FORCE : FORCE + 3]
        np.multiply(nodes.mass[:, None], self.gravity, out=forces)
        for load in self.tractions:
            pressure = mean_pressure(load, time, time + dt)
            if pressure:
                near, area = self._area(load, table, shares[:, load.body])
                forces[near, load.axis] -= pressure * area
        nodes.force[:] += forces
        impulse: np.ndarray = dt * forces.sum(axis=0)
        return impulse

    def _area(self, load: Traction, table: np.ndarray, ranges: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Nodes near the end of a body, and their outward area along its axis, m2 (per radian in axisymmetry)."""
        body: Body = self.problem.bodies[load.body]
        sign = 1.0 if load.side else -1.0
        ends = [
            (sign * table[X + load.axis, begin:end][table[MASS, begin:end] > 0.0]).max(initial=-np.inf)
            for begin, end in ranges
        ]
        place = sign * (max(ends) + 0.5 * body.spacing[load.axis])
        self.areas[:] = 0.0
        for begin, end in ranges:
            problem, span = self.problem, np.array([[begin, end]])
            scatter_surface(problem.geometry, problem.shape, self.pack, table, span, self.areas, self.touched)
        reach = REACH * self.problem.geometry.spacing
        near = np.flatnonzero(np.abs(self.place[:, load.axis] - place) < reach)
        return near, self.areas[near, FORCE + load.axis]

    def work(self, nodes: Nodes, dt: float) -> float:
        """Work of the loads in a step whose new momentum is mapped back, J; after the faces folded them."""
        held = nodes.mass > 0.0
        after = nodes.momentum[held] / nodes.mass[held, None]
        mean = 0.5 * (nodes.before[held] + after)
        return float((self.table[held, FORCE : FORCE + 3] * mean).sum() * dt)
