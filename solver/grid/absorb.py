"""Surfaces that let waves out: dashpots on a body's surface answer its motion as the matter beyond it would.

Lysmer and Kuhlemeyer (1969), J. Eng. Mech. Div. ASCE 95 (EM4), 859. The traction is minus the impedance times the
velocity, rho c of longitudinal waves along the normal and of shear waves across it: plane elastic waves at normal
incidence leave entirely, oblique ones and those along a free surface in part. Where matter yields its waves are slower,
and a shock is faster: both are partly sent back. Nothing holds the body in its place once the waves have left.

A node near the surface has the area that the body has there at first, the sum of V grad N, so that the tractions
balance a uniform stress: to round-off where the lattice fits the grid, else to 0.1 % with splines and GIMP and to 3 %
with linear shapes. Each node is slowed by its own velocity, the mean of those before and after the step, so that the
dashpots alone would remove energy whatever the step. Where the body has drawn back, or thin debris flies through, they
let go. Their impulse and the energy they remove are accumulated.
"""

import math
from typing import NamedTuple

import numpy as np

from solver.errors import ProblemError
from solver.grid.faces import Closed, fold_vectors
from solver.grid.nodes import FORCE, empty_nodes, node_positions
from solver.grid.transfer import scatter_surface
from solver.jit import device, kernel
from solver.matter.eos import reference_density, reference_sound_speed
from solver.matter.laws import Matter
from solver.problem import Absorber, Face, Problem
from solver.problem.geometry import node_count
from solver.state import empty_table, views
from solver.steps.space import new_pack

REACH = 1.5  # cells: nodes nearer to a surface than this may have area there, for any shape

ROUND_OFF = 1e-9  # of the largest area

# Of a node's mass with the body in place: dashpots hold it fully from the one on, and not at all below the other. A
# surface that has drawn back by a third of a cell leaves the nodes on it half of their mass. Nodes beyond it have
# little mass and are let go of sooner: with splines a quarter of the area at a third of a cell, with linear shapes up
# to half of it at a twentieth.
HELD, LET_GO = 0.5, 0.25


class Dashpots(NamedTuple):
    """The nodes of an absorbing surface, n of them."""

    node: np.ndarray  # (n,) indices
    full: np.ndarray  # (n,) mass with the body in place, kg
    constant: np.ndarray  # (n, 3) area times impedance, N s/m
    impulse: np.ndarray  # (n, 3) given in this step, N s


def absorber(matter: Matter, *, body: int, axis: int, side: int, place: float) -> Absorber:
    """A flat surface of a body across an axis at a place (m) through which waves in undisturbed matter leave.

    ``side`` is 1 where the body lies below the place, 0 where it lies above.
    """
    density, sound = reference_density(matter.eos), reference_sound_speed(matter.eos)
    impedance = np.full(3, math.sqrt(density * matter.shear_modulus))
    impedance[axis] = math.sqrt(density * (density * sound**2 + 4.0 / 3.0 * matter.shear_modulus))
    return Absorber(body, axis, side, place, impedance)


def dashpots(problem: Problem, absorber: Absorber, closed: Closed) -> Dashpots:
    """The nodes of an absorber between the closed faces of its grid; raises ProblemError where there is no surface."""
    body = problem.bodies[absorber.body]
    found = empty_nodes(node_count(problem.geometry))
    table = empty_table(body.mass.size)
    particles = views(table)
    particles.position[:], particles.mass[:] = body.position, body.mass
    particles.density[:] = body.density
    ranges = np.array([[0, body.mass.size]])
    touched = np.zeros(found.mass.size, np.uint8)
    pack = new_pack()
    scatter_surface(problem.geometry, problem.shape, pack, table, ranges, found.state, touched)
    full, area = found.mass, found.force
    mirrors = closed.kind == Face.SYMMETRIC
    for axis in range(3):  # one after another: the ghosts of an edge are folded along each
        across = mirrors & (closed.axis == axis)
        np.add.at(full, closed.inner[across], full[closed.ghost[across]])
    fold_vectors(closed._replace(closed=mirrors.astype(np.uint8)), found.state, FORCE)
    distance = np.abs(node_positions(problem.geometry)[:, absorber.axis] - absorber.place)
    area = area[: distance.size]
    outwards = area[:, absorber.axis] if absorber.side == 1 else -area[:, absorber.axis]
    near = distance < REACH * problem.geometry.spacing
    node = np.flatnonzero(near & (outwards > ROUND_OFF * np.abs(area).max()))
    if not node.size:
        raise ProblemError(
            f"body {body.name!r} has no surface at {absorber.place:g} m on axis {absorber.axis} that could absorb"
        )
    constant = outwards[node, None] * absorber.impedance
    return Dashpots(node, full[node], constant, np.zeros((node.size, 3)))


@kernel
def absorb(dashpots, nodes, dt, impulse):
    """Forces of the dashpots on nodes whose mass, momentum and force are complete."""
    for k in range(dashpots.node.size):
        i = dashpots.node[k]
        for c in range(3):
            dashpots.impulse[k, c] = 0.0
            held = _held(nodes.mass[i] / dashpots.full[k])
            if held > 0.0:
                constant = held * dashpots.constant[k, c] * dt
                mean = (nodes.momentum[i, c] + 0.5 * dt * nodes.force[i, c]) / nodes.mass[i]
                given = -constant * mean / (1.0 + 0.5 * constant / nodes.mass[i])
                nodes.force[i, c] += given / dt
                impulse[c] += given
                dashpots.impulse[k, c] = given


@device
def _held(filled):
    """The part of a dashpot that acts on a node which holds the part ``filled`` of its mass."""
    return min(max((filled - LET_GO) / (HELD - LET_GO), 0.0), 1.0)


@kernel
def energy_absorbed(dashpots, nodes):
    """Energy that the dashpots removed: minus the work of their impulses in the mean of old and new velocity; J."""
    energy = 0.0
    for k in range(dashpots.node.size):
        i = dashpots.node[k]
        if nodes.mass[i] > 0.0:
            for c in range(3):
                mean = 0.5 * (nodes.before[i, c] + nodes.momentum[i, c] / nodes.mass[i])
                energy -= dashpots.impulse[k, c] * mean
    return energy
