"""Particles that cross the faces of the box: they leave, or are put back and turned round."""

from solver.jit import device, kernel
from solver.problem import Face

_FREE, _FIXED, _SYMMETRIC = int(Face.FREE), int(Face.FIXED), int(Face.SYMMETRIC)

# The components of a tensor (solver/matter/tensor.py) that name an axis once: a mirror across it negates them.
SHEAR = ((3, 5), (3, 4), (4, 5))


@kernel
def cross_faces(geometry, faces, clamp, particles, impulse):
    """Particles outside the grid: those past a free face die, those past a closed one are put back and turned round.

    A fixed face is free beyond the clamp. At a symmetric face, the axis too, a particle changes places
    with its image in the mirrored body. At a fixed face and at a wall it is no image: its stress stays.

    Returns how many died and how many were put back; adds what these were given to ``impulse`` (3,).
    """
    gone, reflected = 0, 0
    for p in range(particles.mass.size):
        face = exit_face(geometry, particles.position, p)
        while face >= 0 and particles.alive[p]:
            axis = face // 2
            side = face - 2 * axis
            kind = faces[axis, side]
            if kind == _FREE or (kind == _FIXED and not _clamped(clamp, particles.position, p, axis)):
                particles.alive[p] = 0
                gone += 1
            else:
                _put_back(geometry, particles, p, axis, side)
                if kind == _SYMMETRIC:
                    impulse[axis] += _mirror(particles, p, axis)
                else:
                    impulse[axis] += _turn_round(particles, p, axis, side)
                reflected += 1
            face = exit_face(geometry, particles.position, p)
    return gone, reflected


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
    """Mirror a position at a face, strictly inside, whatever the step was."""
    wall = geometry.lower[axis] + side * geometry.cells[axis] * geometry.spacing
    hair = 1e-9 * geometry.spacing
    mirrored = 2.0 * wall - particles.position[p, axis]
    if side == 0:
        particles.position[p, axis] = min(max(mirrored, wall + hair), wall + geometry.spacing)
    else:
        particles.position[p, axis] = max(min(mirrored, wall - hair), wall - geometry.spacing)


@device
def _mirror(particles, p, axis):
    """Mirror position and velocity of a particle; returns the impulse given to it.

    M v and M s M with M = I - 2 n n. At the axis, without swirl, half a turn gives the same.
    """
    normal = particles.velocity[p, axis]
    particles.velocity[p, axis] = -normal
    for component in SHEAR[axis]:
        particles.deviator[p, component] = -particles.deviator[p, component]
    return -2.0 * normal * particles.mass[p]


@device
def _turn_round(particles, p, axis, side):
    """Reverse the velocity of a particle that still moves outwards; returns the impulse given to the particle."""
    normal = particles.velocity[p, axis]
    if (side == 0 and normal < 0.0) or (side == 1 and normal > 0.0):
        particles.velocity[p, axis] = -normal
        return -2.0 * normal * particles.mass[p]
    return 0.0


@device
def exit_face(geometry, position, p):
    """The face through which particle ``p`` of ``position`` (n, 3) lies outside the grid, as 2 axis + side, or -1."""
    inverse = 1.0 / geometry.spacing
    for axis in range(3):
        last = geometry.cells[axis]
        if last > 0:
            place = (position[p, axis] - geometry.lower[axis]) * inverse
            if place < 0.0:
                return 2 * axis
            if place >= last:
                return 2 * axis + 1
    return -1
