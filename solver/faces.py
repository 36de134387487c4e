"""What the faces of the grid do: to the nodes at them, and to particles that cross them.

Behind a closed face lies the mirrored body: odd in the velocity components that the face holds, even in the others.
The shares that particles have in the ghost nodes outside the face are therefore folded onto the nodes as far inside,
and after the forces the ghosts get the mirrored velocities of these. What a face holds on its own nodes and takes from
its ghosts is momentum given by the face, booked as an impulse. Faces stand still, so they do no work. A free face does
nothing: its ghosts are nodes like all others.
"""

from typing import Any, NamedTuple

import numpy as np

from solver.geometry import exit_face, layer_nodes, node_positions
from solver.jit import device, kernel
from solver.problem import Clamp, Face

_FREE, _FIXED, _SYMMETRIC = int(Face.FREE), int(Face.FIXED), int(Face.SYMMETRIC)

# The components of a tensor (solver/tensor.py) that name an axis once: a mirror across it negates them.
_SHEAR = ((3, 5), (3, 4), (4, 5))

# What a face does at one of its nodes in a step: walls judge anew in each, the others never change.
OPEN = 0  # nothing: the body leaves
CLOSED = 1  # holds the node and mirrors the body
STOPPED = 2  # stops the node, and pulls at nothing: the body draws away, but still moves on towards the wall


class Layer(NamedTuple):
    """The nodes at one closed face: on it, its ghosts and the nodes inside that mirror them; n of each."""

    axis: int
    side: int  # 0 lower, 1 upper
    kind: int  # a Face
    sign: np.ndarray  # (3,) -1 for the components of velocity that the face turns round, else 1
    face: np.ndarray  # (n,) indices
    ghost: np.ndarray  # (n,) indices
    inner: np.ndarray  # (n,) indices
    closed: np.ndarray  # (n,) what the face does in this step: OPEN, CLOSED or STOPPED
    mass: np.ndarray  # (n,) of the ghosts before they were folded, kg
    force: np.ndarray  # (n, 3) of the ghosts before they were folded, N
    pull: np.ndarray  # (n,) force times step away from a wall that yet stops the node, kg m/s
    taken: np.ndarray  # (n,) momentum taken from that node, kg m/s


def closed_layers(
    geometry: Any, faces: tuple[tuple[Face, Face], ...], clamp: Clamp
) -> list[list[Layer]]:
    """The closed faces of each axis with extent."""
    return [
        [
            _layer(geometry, axis, side, kind, clamp)
            for side, kind in enumerate(faces[axis])
            if kind != Face.FREE
        ]
        for axis in range(3)
        if geometry.cells[axis] > 0
    ]


def _layer(geometry: Any, axis: int, side: int, kind: Face, clamp: Clamp) -> Layer:
    face = layer_nodes(geometry, axis, side, 0)
    closed = np.full(face.size, CLOSED, np.uint8)
    if kind == Face.FIXED:
        along = np.arange(3) != axis
        place = node_positions(geometry)[face][:, along]
        beyond = (place < clamp.lower[along]) | (place > clamp.upper[along])
        closed[beyond.any(axis=1)] = OPEN
    sign = np.ones(3)
    sign[slice(None) if kind == Face.FIXED else axis] = -1.0
    return Layer(
        axis,
        side,
        int(kind),
        sign,
        face,
        layer_nodes(geometry, axis, side, -1),
        layer_nodes(geometry, axis, side, 1),
        closed,
        np.zeros(face.size),
        np.zeros((face.size, 3)),
        np.zeros(face.size),
        np.zeros(face.size),
    )


@kernel
def judge_wall(layer, nodes, dt):
    """A unilateral wall acts on nodes that would still approach it after the step, and pushes only.

    Closed, it would give -(f + 2 (f_g + m_g a)) dt with the ghost's mass and force and the acceleration a of the node
    that mirrors it, see ``book_ghosts``; where that is a pull, it only stops the node.
    """
    outwards = 1.0 if layer.side == 1 else -1.0
    axis = layer.axis
    for k in range(layer.face.size):
        i, g, n = layer.face[k], layer.ghost[k], layer.inner[k]
        trial = nodes.momentum[i, axis] + nodes.force[i, axis] * dt
        if trial * outwards < 0.0:
            layer.closed[k] = OPEN
            continue
        taken = nodes.force[i, axis] + 2.0 * nodes.force[g, axis]
        if nodes.mass[g] > 0.0:
            both = nodes.mass[n] + nodes.mass[g]
            mirrored = (nodes.force[n, axis] - nodes.force[g, axis]) / both
            taken += 2.0 * nodes.mass[g] * mirrored
        layer.closed[k] = CLOSED if taken * outwards >= 0.0 else STOPPED


@kernel
def fold_state(layer, nodes):
    """Mass, momentum and force of the ghosts go to the nodes that mirror them."""
    for k in range(layer.face.size):
        if layer.closed[k] == CLOSED:
            g, i = layer.ghost[k], layer.inner[k]
            layer.mass[k] = nodes.mass[g]
            nodes.mass[i] += nodes.mass[g]
            nodes.mass[g] = 0.0
            for c in range(3):
                nodes.momentum[i, c] += layer.sign[c] * nodes.momentum[g, c]
                nodes.momentum[g, c] = 0.0
                layer.force[k, c] = nodes.force[g, c]
                nodes.force[i, c] += layer.sign[c] * nodes.force[g, c]
                nodes.force[g, c] = 0.0
        else:
            layer.mass[k] = 0.0
            layer.force[k, :] = 0.0


@kernel
def fold_vectors(layer, vectors):
    """One vector (m, 3) of each ghost goes to the node that mirrors it."""
    for k in range(layer.face.size):
        if layer.closed[k] == CLOSED:
            g, i = layer.ghost[k], layer.inner[k]
            for c in range(3):
                vectors[i, c] += layer.sign[c] * vectors[g, c]
                vectors[g, c] = 0.0


@kernel
def mirror_vectors(layer, vectors):
    """The vectors (m, 3) of the ghosts are those of the nodes inside, mirrored; a face's own have no odd part."""
    for k in range(layer.face.size):
        if layer.closed[k] == CLOSED:
            g, i, f = layer.ghost[k], layer.inner[k], layer.face[k]
            for c in range(3):
                if layer.sign[c] < 0.0:
                    vectors[f, c] = 0.0
                vectors[g, c] = layer.sign[c] * vectors[i, c]


@kernel
def hold_state(layer, nodes, dt, impulse):
    """Zero what a face holds, in momentum and force alike; the momentum that its force would have given is booked.

    Ma (2005), section 2.2.4 (2). Where a wall only stops a node, the node's force stays.
    """
    inwards = 1.0 if layer.side == 0 else -1.0
    for k in range(layer.face.size):
        layer.pull[k] = 0.0
        if layer.closed[k] == OPEN:
            continue
        i = layer.face[k]
        for c in range(3):
            if layer.sign[c] > 0.0:
                continue
            push = nodes.force[i, c] * dt
            if layer.closed[k] == STOPPED and push * inwards > 0.0:
                layer.pull[k] = push
                layer.taken[k] = nodes.momentum[i, c] + push
                nodes.momentum[i, c] = -push
                continue
            impulse[c] -= push
            nodes.momentum[i, c] = 0.0
            nodes.force[i, c] = 0.0


@kernel
def hold_mapped(layer, nodes):
    """Zero what a face holds in the momentum mapped back; returns the energy that stopping pulled nodes took, J.

    Such a node has a force and a velocity that its particles do not see: their kinetic energy changes with the
    velocities before the wall, their internal energy with those after it. The difference is booked.
    """
    energy = 0.0
    for k in range(layer.face.size):
        if layer.closed[k] == OPEN:
            continue
        i = layer.face[k]
        if layer.pull[k] != 0.0 and nodes.mass[i] > 0.0:
            missed = layer.taken[k] + nodes.momentum[i, layer.axis]
            energy -= 0.5 * layer.pull[k] * missed / nodes.mass[i]
        for c in range(3):
            if layer.sign[c] < 0.0:
                nodes.momentum[i, c] = 0.0
    return energy


@kernel
def mirror_velocity(layer, nodes):
    """Ghosts get the mirrored velocities and accelerations of the nodes inside."""
    for k in range(layer.face.size):
        if layer.closed[k] == CLOSED:
            g, i = layer.ghost[k], layer.inner[k]
            for c in range(3):
                nodes.before[g, c] = layer.sign[c] * nodes.before[i, c]
                nodes.velocity[g, c] = layer.sign[c] * nodes.velocity[i, c]
                nodes.acceleration[g, c] = layer.sign[c] * nodes.acceleration[i, c]


@kernel
def book_ghosts(layer, nodes, dt, impulse):
    """The momentum that the face gives through its ghosts: they move against the force and the mass in them.

    Of m_i a + m_g s a after the fold and f_i + f_g before it, with (m_i + m_g) a = f_i + s f_g, the difference is
    -2 (f_g + m_g a) where the sign s is -1.
    """
    for k in range(layer.face.size):
        if layer.closed[k] == CLOSED:
            i = layer.inner[k]
            for c in range(3):
                if layer.sign[c] < 0.0:
                    mirrored = layer.mass[k] * nodes.acceleration[i, c]
                    impulse[c] -= 2.0 * (layer.force[k, c] + mirrored) * dt


@kernel
def cross_faces(geometry, faces, clamp, particles, impulse):
    """Particles outside the grid: those past a free face die, those past a closed one are put back and turned round.

    A fixed face is free beyond the clamp. At a symmetric face, the axis too, a particle changes places
    with its image in the mirrored body. At a fixed face and at a wall it is no image: its stress stays.

    Returns how many were put back; adds what they were given to ``impulse`` (3,).
    """
    reflected = 0
    for p in range(particles.mass.size):
        face = exit_face(geometry, particles.position, p)
        while face >= 0 and particles.alive[p]:
            axis = face // 2
            side = face - 2 * axis
            kind = faces[axis, side]
            if kind == _FREE or (
                kind == _FIXED and not _clamped(clamp, particles.position, p, axis)
            ):
                particles.alive[p] = 0
            else:
                _put_back(geometry, particles, p, axis, side)
                if kind == _SYMMETRIC:
                    impulse[axis] += _mirror(particles, p, axis)
                else:
                    impulse[axis] += _turn_round(particles, p, axis, side)
                reflected += 1
            face = exit_face(geometry, particles.position, p)
    return reflected


@device
def _clamped(clamp, position, p, axis):
    """Whether a particle past a face of an axis left within the clamp: its place along the face decides."""
    for other in range(3):
        if other != axis:
            place = position[p, other]
            if place < clamp.lower[other] or place > clamp.upper[other]:
                return False
    return True


@device
def _put_back(geometry, particles, p, axis, side):
    """Mirror a position at a face, at least a hair inside, whatever the step was."""
    wall = geometry.lower[axis] + side * geometry.cells[axis] * geometry.spacing
    hair = 1e-9 * geometry.spacing
    mirrored = 2.0 * wall - particles.position[p, axis]
    if side == 0:
        particles.position[p, axis] = min(max(mirrored, wall + hair), wall + geometry.spacing)
    else:
        particles.position[p, axis] = max(min(mirrored, wall - hair), wall - geometry.spacing)


@device
def _mirror(particles, p, axis):
    """Make a particle its image, whichever way it flies; returns the impulse given to it.

    M v and M s M with M = I - 2 n n. At the axis, without swirl, half a turn gives the same.
    """
    normal = particles.velocity[p, axis]
    particles.velocity[p, axis] = -normal
    for component in _SHEAR[axis]:
        particles.deviator[p, component] = -particles.deviator[p, component]
    return -2.0 * normal * particles.mass[p]


@device
def _turn_round(particles, p, axis, side):
    """Reverse a velocity that still points outwards; returns the impulse given to the particle."""
    normal = particles.velocity[p, axis]
    if (side == 0 and normal < 0.0) or (side == 1 and normal > 0.0):
        particles.velocity[p, axis] = -normal
        return -2.0 * normal * particles.mass[p]
    return 0.0
