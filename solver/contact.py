"""Bodies that meet, each with a velocity field of its own: Bardenhagen, Brackbill and Sulsky (2000), Comput. Methods
Appl. Mech. Eng. 187, 529; Ma (2005), section 2.2.3.

A node that two bodies reach is where they may touch. They do when they approach each other along the normal, and still
would after the step; then they get the impulse that gives both the normal velocity of their common centre of mass, and
along the surface as much of it as Coulomb's friction allows. Bodies that draw apart are left alone. Bodies meet
before their surfaces do, by about a cell: a node cannot tell how far from it a body ends.

The impulse is a force of the step like any other, equal and opposite on the two fields. Bodies that meet give up
kinetic energy of their relative motion that no stress has taken: minus the impulse times the mean of the relative
velocities before and after, accumulated as removed energy. That is why the approach is judged before the forces too:
where these alone would make bodies approach that draw apart, the impulse would do work on them. Without this, slow
elastic bars gained up to 44 % of their energy at the contact; with it they lose a sixth to a third of it. Its price
is that bodies under pressure, whose mapped velocities draw apart at some nodes, creep into each other there, and what
ends that approach later is removed: see docs/theory.md.

Ma (2005), Eqs. 2-27 and 2-28, print the same criterion and impulse with the velocities of the mapping, before the
forces: ``Criterion.MAPPED``. Bodies then approach after a step by what its forces gave, and slow elastic bars stick
(2026-11). Each body's own normal, as printed, would not keep the momentum: both criteria have the shared one.
"""

import math
from typing import NamedTuple

import numpy as np

from solver.jit import device, kernel


class ContactPair(NamedTuple):
    """Two bodies that may touch."""

    impulse: np.ndarray  # (m, 3) that the first got from the second at each node, N s


def empty_pair(nodes):
    """A pair that does not touch, for a number of nodes."""
    return ContactPair(np.zeros((nodes, 3)))


@kernel
def add_contact_forces(first, second, pair, friction, ahead, dt):
    """Contact forces between two fields whose mass, momentum, force and surface are complete.

    The impulse ends the approach that the bodies would have ``ahead`` of now: after the step (dt), or at once (0).

    The normal is that of the difference of the two surfaces, so that both fields see the same one. That of the larger
    surface alone (Lemiale, Nairn and Hurmane 2010, CMES 70, 41) is better where a corner slides on a flat, and
    much worse where two corners pass each other (2026-11). Returns the number of nodes in contact.
    """
    touching = 0
    normal, relative = np.empty(3), np.empty(3)
    for i in range(first.mass.size):
        pair.impulse[i, :] = 0.0
        if first.mass[i] <= 0.0 or second.mass[i] <= 0.0:
            continue
        size = approach = before = 0.0
        for c in range(3):
            normal[c] = first.surface[i, c] - second.surface[i, c]
            size += normal[c] * normal[c]
            relative[c] = _velocity(first, i, c, ahead) - _velocity(second, i, c, ahead)
            approach += relative[c] * normal[c]
            before += (_velocity(first, i, c, 0.0) - _velocity(second, i, c, 0.0)) * normal[c]
        if approach <= 0.0 or before <= 0.0:
            continue
        size = math.sqrt(size)
        approach /= size
        sliding = 0.0
        for c in range(3):
            normal[c] /= size
            relative[c] -= approach * normal[c]
            sliding += relative[c] * relative[c]
        # Coulomb: what stops the sliding, but at most friction times the normal impulse.
        grip = min(1.0, friction * approach / math.sqrt(sliding)) if sliding > 0.0 else 0.0
        reduced = first.mass[i] * second.mass[i] / (first.mass[i] + second.mass[i])
        for c in range(3):
            given = -reduced * (approach * normal[c] + grip * relative[c])
            pair.impulse[i, c] = given
            first.force[i, c] += given / dt
            second.force[i, c] -= given / dt
        touching += 1
    return touching


@device
def _velocity(nodes, i, c, ahead):
    """Velocity after a time without contact."""
    return (nodes.momentum[i, c] + nodes.force[i, c] * ahead) / nodes.mass[i]


@kernel
def energy_removed(first, second, pair):
    """Energy that contact removed: minus the work of its impulses in the mean of old and new velocity; J."""
    energy = 0.0
    for i in range(first.mass.size):
        if first.mass[i] <= 0.0 or second.mass[i] <= 0.0:
            continue
        for c in range(3):
            before = first.before[i, c] - second.before[i, c]
            after = first.momentum[i, c] / first.mass[i] - second.momentum[i, c] / second.mass[i]
            energy -= 0.5 * pair.impulse[i, c] * (before + after)
    return energy
