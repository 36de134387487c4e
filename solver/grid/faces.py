"""The action of the faces of the grid on the nodes at them.

Behind a closed face lies the mirrored body: odd in the velocity components that the face holds, even in the others. The
shares that particles have in the ghost nodes outside the face are therefore folded onto the nodes as far inside, and
after the forces the ghosts get the mirrored velocities of these. What a face holds on its own nodes and takes from its
ghosts is momentum given by the face, accumulated as its impulse. Faces stand still, so they do no work. A free face
does nothing: its ghosts are nodes like all others.
"""

from typing import NamedTuple

import numpy as np

from solver.grid.nodes import ACCELERATION, BEFORE, BLOCK, FORCE, MOMENTUM, layer_nodes, node_positions
from solver.jit import device, kernel
from solver.problem import Clamp, Face
from solver.problem.geometry import Geometry
from solver.steps.space import VELOCITY

_WALL = int(Face.WALL)

# What a face does at one of its nodes in a step: walls judge anew in each, the others never change.
OPEN = 0  # nothing: the body leaves
CLOSED = 1  # holds the node and mirrors the body
STOPPED = 2  # stops the node, and pulls at nothing: the body draws away, but still moves on towards the wall


class Closed(NamedTuple):
    """The n nodes at all closed faces, axis by axis: on the face, its ghost and the node inside that mirrors it."""

    # (4,) where each axis begins; a node on an edge of the grid is met by each of its axes.
    start: np.ndarray
    axis: np.ndarray  # (n,)
    side: np.ndarray  # (n,) 0 lower, 1 upper
    kind: np.ndarray  # (n,) a Face
    sign: np.ndarray  # (n, 3) -1 for the components of velocity that the face turns round, else 1
    face: np.ndarray  # (n,) indices
    ghost: np.ndarray  # (n,) indices
    inner: np.ndarray  # (n,) indices
    closed: np.ndarray  # (n,) what the face does in this step: OPEN, CLOSED or STOPPED
    mass: np.ndarray  # (n,) of the ghosts before they were folded, kg
    force: np.ndarray  # (n, 3) of the ghosts before they were folded, N
    pull: np.ndarray  # (n,) force times step away from a wall that yet stops the node, kg m/s
    taken: np.ndarray  # (n,) momentum taken from that node, kg m/s
    # (r + 1,) where runs of them begin, within which node, ghost and inner node stay in the same blocks.
    run: np.ndarray
    run_blocks: np.ndarray  # (r, 3) these blocks
    run_start: np.ndarray  # (4,) the first run of each axis
    near: np.ndarray  # (n,) which of them are near a particle in this step, axis by axis
    near_start: np.ndarray  # (4,) where each axis begins in ``near``, and how many there are


def closed_nodes(geometry: Geometry, faces: tuple[tuple[Face, Face], ...], clamp: Clamp) -> Closed:
    """The nodes at the closed faces of a grid."""
    layers = [
        _layer(geometry, axis, side, kind, clamp)
        for axis in range(3)
        for side, kind in enumerate(faces[axis])
        if kind != Face.FREE and geometry.cells[axis] > 0
    ]
    found = {name: np.concatenate([empty, *(layer[name] for layer in layers)]) for name, empty in _NO_LAYER.items()}
    start = np.searchsorted(found["axis"], np.arange(4))
    count = found["axis"].size
    blocks = np.stack([found["face"], found["ghost"], found["inner"]], axis=1) // BLOCK
    changes = np.flatnonzero((np.diff(blocks, axis=0) != 0).any(axis=1)) + 1
    run = np.unique(np.concatenate([changes, start]))
    return Closed(
        start,
        **found,
        run=run,
        run_blocks=blocks[run[:-1]].astype(np.int32),
        run_start=np.searchsorted(run, start),
        mass=np.zeros(count),
        force=np.zeros((count, 3)),
        pull=np.zeros(count),
        taken=np.zeros(count),
        near=np.arange(count),
        near_start=start.copy(),
    )


_NO_LAYER: dict[str, np.ndarray] = {
    **dict.fromkeys(("axis", "side", "kind", "face", "ghost", "inner"), np.zeros(0, np.int64)),
    "sign": np.zeros((0, 3)),
    "closed": np.zeros(0, np.uint8),
}


def _layer(geometry: Geometry, axis: int, side: int, kind: Face, clamp: Clamp) -> dict[str, np.ndarray]:
    """The nodes at one closed face."""
    face = layer_nodes(geometry, axis, side, 0)
    closed = np.full(face.size, CLOSED, np.uint8)
    if kind == Face.FIXED:
        closed[~clamp.holds(node_positions(geometry)[face], axis)] = OPEN
    sign = np.ones((face.size, 3))
    sign[:, slice(None) if kind == Face.FIXED else axis] = -1.0
    return {
        "axis": np.full(face.size, axis),
        "side": np.full(face.size, side),
        "kind": np.full(face.size, int(kind)),
        "sign": sign,
        "face": face,
        "ghost": layer_nodes(geometry, axis, side, -1),
        "inner": layer_nodes(geometry, axis, side, 1),
        "closed": closed,
    }


@device
def _find_near(closed, touched):
    """Note the nodes at closed faces that a particle is near; ``touched`` marks the blocks of nodes."""
    run, blocks, near = closed.run, closed.run_blocks, closed.near
    count = 0
    for axis in range(3):
        closed.near_start[axis] = count
        for r in range(closed.run_start[axis], closed.run_start[axis + 1]):
            if touched[blocks[r, 0]] or touched[blocks[r, 1]] or touched[blocks[r, 2]]:
                for k in range(run[r], run[r + 1]):
                    near[count] = k
                    count += 1
    closed.near_start[3] = count


@kernel
def close_nodes(closed, touched, state, dt, impulse):
    """Fold the ghosts and hold the faces, axis by axis, so that corners are folded once along each.

    ``touched`` marks the blocks of the nodes that particles are near, ``state`` is the nodes' table; what the faces
    give is added to ``impulse`` (3,).
    """
    _find_near(closed, touched)
    near, start = closed.near, closed.near_start
    for axis in range(3):
        for j in range(start[axis], start[axis + 1]):
            if closed.kind[near[j]] == _WALL:
                _judge_wall(closed, near[j], state, dt)
            _fold_state(closed, near[j], state)
        for j in range(start[axis], start[axis + 1]):
            _hold_state(closed, near[j], state, dt, impulse)


@kernel
def close_mapped(closed, state):
    """Fold and hold the momentum mapped back; returns the energy that walls removed by stopping nodes, J."""
    near, start = closed.near, closed.near_start
    energy = 0.0
    for axis in range(3):
        for j in range(start[axis], start[axis + 1]):
            _fold_vector(closed, near[j], state, MOMENTUM)
        for j in range(start[axis], start[axis + 1]):
            energy += _hold_mapped(closed, near[j], state)
    return energy


@kernel
def mirror_nodes(closed, motion, mapped):
    """Ghosts get the mirrored velocities and accelerations of the nodes inside, in the reverse order of the fold."""
    near, start, signs = closed.near, closed.near_start, closed.sign
    for axis in range(2, -1, -1):
        for j in range(start[axis], start[axis + 1]):
            k = near[j]
            if closed.closed[k] == CLOSED:
                g, i = closed.ghost[k], closed.inner[k]
                for c in range(3):
                    sign = signs[k, c]
                    motion[g, BEFORE + c] = sign * motion[i, BEFORE + c]
                    motion[g, ACCELERATION + c] = sign * motion[i, ACCELERATION + c]
                    mapped[g, VELOCITY + c] = sign * mapped[i, VELOCITY + c]


@kernel
def fold_vectors(closed, table, column):
    """One vector of each ghost, from a column of a table on, goes to the node that mirrors it."""
    for k in range(closed.face.size):
        _fold_vector(closed, k, table, column)


@kernel
def mirror_vectors(closed, table, column):
    """The vectors of the ghosts are those of the nodes inside, mirrored; a face's own have no odd part."""
    for axis in range(2, -1, -1):
        for k in range(closed.start[axis], closed.start[axis + 1]):
            if closed.closed[k] == CLOSED:
                g, i, f = closed.ghost[k], closed.inner[k], closed.face[k]
                for c in range(3):
                    if closed.sign[k, c] < 0.0:
                        table[f, column + c] = 0.0
                    table[g, column + c] = closed.sign[k, c] * table[i, column + c]


@kernel
def add_ghost_impulse(closed, motion, dt, impulse):
    """The momentum that the face gives through its ghosts: they move against the force and the mass in them.

    Of m_i a + m_g s a after the fold and f_i + f_g before it, with (m_i + m_g) a = f_i + s f_g, the difference is
    -2 (f_g + m_g a) where the sign s is -1.
    """
    for j in range(closed.near_start[3]):
        k = closed.near[j]
        if closed.closed[k] == CLOSED:
            i = closed.inner[k]
            for c in range(3):
                if closed.sign[k, c] < 0.0:
                    mirrored = closed.mass[k] * motion[i, ACCELERATION + c]
                    impulse[c] -= 2.0 * (closed.force[k, c] + mirrored) * dt


@device
def _judge_wall(closed, k, state, dt):
    """A unilateral wall acts on nodes that would still approach it after the step, and pushes only.

    Closed, it would give -(f + 2 (f_g + m_g a)) dt with the ghost's mass and force and the acceleration a of the node
    that mirrors it, see ``add_ghost_impulse``; where that is a pull, it only stops the node.
    """
    outwards = 1.0 if closed.side[k] == 1 else -1.0
    axis = closed.axis[k]
    i, g, n = closed.face[k], closed.ghost[k], closed.inner[k]
    trial = state[i, MOMENTUM + axis] + state[i, FORCE + axis] * dt
    if trial * outwards < 0.0:
        closed.closed[k] = OPEN
        return
    taken = state[i, FORCE + axis] + 2.0 * state[g, FORCE + axis]
    if state[g, 0] > 0.0:
        both = state[n, 0] + state[g, 0]
        mirrored = (state[n, FORCE + axis] - state[g, FORCE + axis]) / both
        taken += 2.0 * state[g, 0] * mirrored
    closed.closed[k] = CLOSED if taken * outwards >= 0.0 else STOPPED


@device
def _fold_state(closed, k, state):
    """Mass, momentum and force of a ghost go to the node that mirrors it."""
    closed.mass[k] = 0.0
    for c in range(3):
        closed.force[k, c] = 0.0
    if closed.closed[k] == CLOSED:
        g, i = closed.ghost[k], closed.inner[k]
        closed.mass[k] = state[g, 0]
        state[i, 0] += state[g, 0]
        state[g, 0] = 0.0
        for c in range(3):
            sign = closed.sign[k, c]
            closed.force[k, c] = state[g, FORCE + c]
            state[i, MOMENTUM + c] += sign * state[g, MOMENTUM + c]
            state[i, FORCE + c] += sign * state[g, FORCE + c]
            state[g, MOMENTUM + c] = 0.0
            state[g, FORCE + c] = 0.0


@device
def _fold_vector(closed, k, table, column):
    if closed.closed[k] == CLOSED:
        g, i = closed.ghost[k], closed.inner[k]
        for c in range(3):
            table[i, column + c] += closed.sign[k, c] * table[g, column + c]
            table[g, column + c] = 0.0


@device
def _hold_state(closed, k, state, dt, impulse):
    """Zero the held components of momentum and force; the momentum of that force is added to the impulse.

    Ma (2005), section 2.2.4 (2). Where a wall only stops a node, the node's force stays.
    """
    closed.pull[k] = 0.0
    if closed.closed[k] == OPEN:
        return
    inwards = 1.0 if closed.side[k] == 0 else -1.0
    i = closed.face[k]
    for c in range(3):
        if closed.sign[k, c] > 0.0:
            continue
        push = state[i, FORCE + c] * dt
        if closed.closed[k] == STOPPED and push * inwards > 0.0:
            closed.pull[k] = push
            closed.taken[k] = state[i, MOMENTUM + c] + push
            state[i, MOMENTUM + c] = -push
            continue
        impulse[c] -= push
        state[i, MOMENTUM + c] = 0.0
        state[i, FORCE + c] = 0.0


@device
def _hold_mapped(closed, k, state):
    """Zero what a face holds in the momentum mapped back; returns the energy that stopping a pulled node removed, J.

    Such a node has a force and a velocity that its particles do not see: their kinetic energy changes with the
    velocities before the wall, their internal energy with those after it. The difference is recorded.
    """
    if closed.closed[k] == OPEN:
        return 0.0
    energy = 0.0
    i = closed.face[k]
    if closed.pull[k] != 0.0 and state[i, 0] > 0.0:
        missed = closed.taken[k] + state[i, MOMENTUM + closed.axis[k]]
        energy = -0.5 * closed.pull[k] * missed / state[i, 0]
    for c in range(3):
        if closed.sign[k, c] < 0.0:
            state[i, MOMENTUM + c] = 0.0
    return energy
