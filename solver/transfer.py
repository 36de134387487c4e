"""Particles to nodes and back: written once for every geometry and shape.

Scatter runs slab by slab along the first axis, even slabs and then odd ones. Slabs of the same parity share no node,
so threads never meet, and a node receives its sum in an order that depends on the particles alone: one thread and
many give the same bits. Particles are assigned to slabs anew in each step, so nothing can drift out of its slab.
"""

import numpy as np

from solver.geometry import (
    Stencil,
    add_velocity_gradient,
    fill_stencil,
    internal_force,
    position_in_cells,
    stencil_size,
)
from solver.jit import device, kernel
from solver.shapes import width

# Columns of cells in a slab. Its particles touch at most the node left of it and three right of its first ones: two
# more columns than the slab has, so slabs of one parity, eight columns apart, never share a node.
SLAB_COLUMNS = 4


def slab_count(geometry):
    """Slabs that cover the first axis."""
    return -(-(geometry.nodes[0] - 1) // SLAB_COLUMNS)


@device
def new_stencil(geometry, shape):
    """Scratch for one particle after another."""
    size = stencil_size(geometry, shape)
    return Stencil(
        np.empty(size, np.int64),
        np.empty(size),
        np.empty((size, 3)),
        np.empty((3, width(shape))),
        np.empty((3, width(shape))),
    )


@kernel
def sort_into_slabs(geometry, particles, begin, end, order, slab_start):
    """Counting sort of the living particles begin..end by slab, stable; fills ``order`` and ``slab_start``.

    ``order`` has room for them, ``slab_start`` (slabs + 1,) tells where each slab begins in it.
    """
    slab_start[:] = 0
    for p in range(begin, end):
        if particles.alive[p]:
            column = int(position_in_cells(geometry, particles.position, p, 0))
            slab_start[column // SLAB_COLUMNS + 1] += 1
    for slab in range(slab_start.size - 1):
        slab_start[slab + 1] += slab_start[slab]
    place = slab_start[:-1].copy()
    for p in range(begin, end):
        if particles.alive[p]:
            slab = int(position_in_cells(geometry, particles.position, p, 0)) // SLAB_COLUMNS
            order[place[slab]] = p
            place[slab] += 1


@device
def total_stress(particles, p, heating):
    """Stress of a particle with ``heating`` times its artificial viscosity, six components in Pa."""
    isotropic = -(particles.pressure[p] + heating * particles.viscosity[p])
    return (
        particles.deviator[p, 0] + isotropic,
        particles.deviator[p, 1] + isotropic,
        particles.deviator[p, 2] + isotropic,
        particles.deviator[p, 3],
        particles.deviator[p, 4],
        particles.deviator[p, 5],
    )


@kernel
def scatter_state(geometry, shape, particles, order, slab_start, slabs, nodes):
    """Mass, momentum and internal force of the particles of some slabs: Ma (2005), Eqs. 2-29 to 2-31."""
    for slab in slabs:
        _scatter_state(
            geometry, shape, particles, order, slab_start[slab], slab_start[slab + 1], nodes
        )


@device
def _scatter_state(geometry, shape, particles, order, begin, end, nodes):
    stencil = new_stencil(geometry, shape)
    for place in range(begin, end):
        p = order[place]
        fill_stencil(geometry, shape, particles.position, p, stencil)
        mass = particles.mass[p]
        volume = mass / particles.density[p]
        stress = total_stress(particles, p, 1.0)
        for a in range(stencil_size(geometry, shape)):
            i = stencil.node[a]
            share = stencil.weight[a] * mass
            force = internal_force(geometry, stress, stencil.gradient, a)
            nodes.mass[i] += share
            for axis in range(3):
                nodes.momentum[i, axis] += share * particles.velocity[p, axis]
                nodes.force[i, axis] -= volume * force[axis]


@kernel
def move_particles(
    geometry, shape, particles, order, slab_start, slabs, moved, nodes, work, damping, dt, lost
):
    """New velocities (FLIP) and positions, and the new momentum back onto the nodes: Ma (2005), Eqs. 2-33 to 2-37.

    The internal energy takes the part ``work[0]`` of the work of the stress in the velocities before the forces
    (``work[1]`` times that of the viscosity). New positions go to ``moved`` (n, 3): the strain update that follows
    still uses the weights of the old ones. ``damping`` is (part of the step, order); to ``lost`` (slabs, 4) are added
    the momentum and, last, the energy that it took from each slab.
    """
    for slab in slabs:
        begin, end = slab_start[slab], slab_start[slab + 1]
        _move(
            geometry,
            shape,
            particles,
            moved,
            order,
            begin,
            end,
            nodes,
            work,
            damping,
            dt,
            lost[slab],
        )


@device
def _move(geometry, shape, particles, moved, order, begin, end, nodes, work, damping, dt, lost):
    stencil = new_stencil(geometry, shape)
    drift = np.empty(3)
    kick = np.empty(3)
    for place in range(begin, end):
        p = order[place]
        fill_stencil(geometry, shape, particles.position, p, stencil)
        drift[:] = 0.0
        kick[:] = 0.0
        stress = total_stress(particles, p, work[1])
        power = 0.0  # of the stress in the velocities before the forces, W/m3
        for a in range(stencil_size(geometry, shape)):
            i = stencil.node[a]
            for axis in range(3):
                drift[axis] += stencil.weight[a] * nodes.velocity[i, axis]
                kick[axis] += stencil.weight[a] * nodes.acceleration[i, axis]
            force = internal_force(geometry, stress, stencil.gradient, a)
            power += (
                force[0] * nodes.before[i, 0]
                + force[1] * nodes.before[i, 1]
                + force[2] * nodes.before[i, 2]
            )
        particles.energy[p] += work[0] * power * dt / particles.density[p]
        if damping[0] > 0.0:
            _damp(geometry, shape, particles, p, nodes, stencil, damping, kick, dt, lost)
        for axis in range(3):
            particles.velocity[p, axis] += kick[axis] * dt
            moved[p, axis] = particles.position[p, axis] + drift[axis] * dt
        for a in range(stencil_size(geometry, shape)):
            i = stencil.node[a]
            share = stencil.weight[a] * particles.mass[p]
            for axis in range(3):
                nodes.momentum[i, axis] += share * particles.velocity[p, axis]


@device
def _damp(geometry, shape, particles, p, nodes, stencil, damping, kick, dt, lost):
    """Take the part ``damping[0]`` of (1 - P)^order v from the velocity of a particle, through its kick (3,).

    Its share of the kinetic energy is that in the mean of old and new velocity, as the work of the forces is.
    """
    for axis in range(3):
        noise = particles.velocity[p, axis]
        for a in range(stencil_size(geometry, shape)):
            i = stencil.node[a]
            noise -= stencil.weight[a] * damping[1] * nodes.before[i, axis]
            noise += stencil.weight[a] * (damping[1] - 1.0) * nodes.smooth[i, axis]
        change = -damping[0] * noise
        mean = particles.velocity[p, axis] + 0.5 * (kick[axis] * dt + change)
        lost[axis] -= particles.mass[p] * change
        lost[3] -= particles.mass[p] * mean * change
        kick[axis] += change / dt


@kernel
def scatter_smoothed(geometry, shape, particles, order, slab_start, slabs, nodes):
    """Momentum of particles that move with the nodes' velocities before the forces, onto ``nodes.smooth``."""
    stencil = new_stencil(geometry, shape)
    for slab in slabs:
        for place in range(slab_start[slab], slab_start[slab + 1]):
            p = order[place]
            fill_stencil(geometry, shape, particles.position, p, stencil)
            for axis in range(3):
                mean = 0.0
                for a in range(stencil_size(geometry, shape)):
                    mean += stencil.weight[a] * nodes.before[stencil.node[a], axis]
                for a in range(stencil_size(geometry, shape)):
                    share = stencil.weight[a] * particles.mass[p]
                    nodes.smooth[stencil.node[a], axis] += share * mean


@device
def gather_velocity_gradient(geometry, shape, position, p, nodes, stencil, gradient):
    """Velocity gradient (3, 3) at particle ``p`` from the nodal velocities: Ma (2005), Eqs. 2-38, 2-39."""
    fill_stencil(geometry, shape, position, p, stencil)
    gradient[:, :] = 0.0
    for a in range(stencil_size(geometry, shape)):
        i = stencil.node[a]
        add_velocity_gradient(geometry, gradient, nodes.velocity, i, stencil.gradient, a)
