"""What the faces of the grid do: to the nodes on them, and to particles that cross them.

Faces stand still, so they do no work; the momentum that they give is booked as an impulse.
"""

from solver.geometry import exit_face
from solver.jit import device, kernel
from solver.problem import Face

_FREE, _FIXED, _WALL = int(Face.FREE), int(Face.FIXED), int(Face.WALL)


@kernel
def hold_face(nodes, index, axis, side, kind, dt, impulse):
    """Zero what a face holds, in momentum and force alike; the momentum that its force would have given is booked.

    Ma (2005), section 2.2.4 (2). Stationary faces do no work. A unilateral wall holds only nodes that would still
    approach it after the step, so it never pulls.
    """
    for i in index:
        for component in range(3):
            if kind != _FIXED and component != axis:
                continue
            if kind == _WALL:
                outward = nodes.momentum[i, axis] + nodes.force[i, axis] * dt
                if (outward > 0.0) == (side == 0):
                    continue
            push = nodes.force[i, component] * dt
            if kind == _WALL and push != 0.0 and (push > 0.0) == (side == 0):
                nodes.momentum[
                    i, component
                ] = -push  # stopped by the wall, and pushed off it by the body alone
                continue
            impulse[component] -= push
            nodes.momentum[i, component] = 0.0
            nodes.force[i, component] = 0.0


@kernel
def cross_faces(geometry, faces, particles, impulse):
    """Particles outside the grid: those past a free face die, those past a closed one are put back and turned round.

    Returns how many were put back; adds what they were given to ``impulse`` (3,).
    """
    reflected = 0
    for p in range(particles.mass.size):
        face = exit_face(geometry, particles.position, p)
        while face >= 0 and particles.alive[p]:
            axis = face // 2
            side = face - 2 * axis
            if faces[axis, side] == _FREE:
                particles.alive[p] = 0
            else:
                _put_back(geometry, particles, p, axis, side)
                impulse[axis] += _turn_round(particles, p, axis, side)
                reflected += 1
            face = exit_face(geometry, particles.position, p)
    return reflected


@device
def _put_back(geometry, particles, p, axis, side):
    """Mirror a position at a face, at least a hair inside, whatever the step was."""
    wall = geometry.lower[axis] + side * (geometry.nodes[axis] - 1) * geometry.spacing
    hair = 1e-9 * geometry.spacing
    mirrored = 2.0 * wall - particles.position[p, axis]
    if side == 0:
        particles.position[p, axis] = min(max(mirrored, wall + hair), wall + geometry.spacing)
    else:
        particles.position[p, axis] = max(min(mirrored, wall - hair), wall - geometry.spacing)


@device
def _turn_round(particles, p, axis, side):
    """Reverse a velocity that still points outwards; returns the impulse given to the particle."""
    normal = particles.velocity[p, axis]
    if (side == 0 and normal < 0.0) or (side == 1 and normal > 0.0):
        particles.velocity[p, axis] = -normal
        return -2.0 * normal * particles.mass[p]
    return 0.0
