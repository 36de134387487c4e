"""The nodes of a grid: their fields and where they stand. Allocation and indices only.

Each node has a line of eight numbers in each table, 64 bytes, which is what the memory moves at a time; ``Nodes`` are
views of the columns.
"""

from typing import NamedTuple

import numpy as np

from solver.jit import device
from solver.problem.geometry import AXES, MARGIN, node_count
from solver.state import lines
from solver.steps.space import VELOCITY

BLOCK = 8  # nodes that are looked at together: whether any particle touched them

# Columns of the tables of nodes, where vectors begin. They stand so that a line of mass, momentum and force over the
# mass is one of velocity and acceleration.
MOMENTUM, FORCE = 1, 4  # of state, whose column 0 is the mass
BEFORE, ACCELERATION = 1, 4  # of motion


class Nodes(NamedTuple):
    """Grid fields; of nodes without mass the rest means nothing. In axisymmetry mass and force are per radian."""

    mass: np.ndarray  # (m,) kg
    momentum: np.ndarray  # (m, 3) kg m/s
    force: np.ndarray  # (m, 3) N
    before: np.ndarray  # (m, 3) velocity before the forces of the step, m/s
    velocity: np.ndarray  # (m, 3) m/s
    surface: np.ndarray  # (m, 3) outward area of a body, for contact, m2 (m2 per radian)
    state: np.ndarray  # (m, 8) table of mass, momentum and force
    motion: np.ndarray  # (m, 8) table of before and acceleration
    mapped: np.ndarray  # (m, 8) table of velocity
    # (m, 8) table of ``before`` mapped to the particles and back, for damping of second order, m/s.
    smoothed: np.ndarray
    areas: np.ndarray  # (m, 8) table whose columns of the force are surface


def empty_nodes(count, *, smooth=True, surface=True, sparse=False):
    """Nodes without mass, in whole blocks; columns for damping and contact are left out on request."""
    count = -(-count // BLOCK) * BLOCK
    counts = count, count, count, count if smooth else 0, count if surface else 0
    state, motion, mapped, smoothed, areas = (lines(one, sparse=sparse) for one in counts)
    return Nodes(
        mass=state[:, 0],
        momentum=state[:, MOMENTUM : MOMENTUM + 3],
        force=state[:, FORCE : FORCE + 3],
        before=motion[:, BEFORE : BEFORE + 3],
        velocity=mapped[:, VELOCITY : VELOCITY + 3],
        surface=areas[:, FORCE : FORCE + 3],
        state=state,
        motion=motion,
        mapped=mapped,
        smoothed=smoothed,
        areas=areas,
    )


@device
def node_strides(geometry):
    """From a node to the next along each axis, in indices."""
    return geometry.nodes[1], 1, geometry.nodes[0] * geometry.nodes[1]


@device
def node_place(geometry, node, axis):
    """Where a node stands along an axis with extent, in cells from the lower face."""
    return node // node_strides(geometry)[axis] % geometry.nodes[axis] - MARGIN


def layer_nodes(geometry, axis, side, depth):
    """Indices (n,) of the nodes ``depth`` layers inside a face (-1: its ghosts), ascending; side 0 is the lower one.

    Ghosts of the faces of other axes belong to the layer.
    """
    place = MARGIN + depth if side == 0 else geometry.nodes[axis] - 1 - MARGIN - depth
    strides = node_strides(geometry)
    first, second = (np.arange(geometry.nodes[other]) * strides[other] for other in range(AXES) if other != axis)
    return np.sort(np.add.outer(first, second), axis=None) + place * strides[axis]


def node_positions(geometry):
    """Coordinates of all nodes, (nodes, 3)."""
    index = np.arange(node_count(geometry))
    place = np.stack([node_place(geometry, index, axis) for axis in range(AXES)], axis=1)
    return geometry.lower + geometry.spacing * np.where(geometry.cells > 0, place, 0)
