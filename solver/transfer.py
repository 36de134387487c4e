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

# Columns of cells in a slab: at least the width of any stencil, so that slabs of one parity never share a node.
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
def sort_into_slabs(geometry, particles, order, slab_start):
    """Counting sort of living particles by slab, stable; fills ``order`` (n,) and ``slab_start`` (slabs + 1,)."""
    slab_start[:] = 0
    for p in range(particles.mass.size):
        if particles.alive[p]:
            column = int(position_in_cells(geometry, particles.position, p, 0))
            slab_start[column // SLAB_COLUMNS + 1] += 1
    for slab in range(slab_start.size - 1):
        slab_start[slab + 1] += slab_start[slab]
    place = slab_start[:-1].copy()
    for p in range(particles.mass.size):
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
def move_particles(geometry, shape, particles, moved, order, slab_start, slabs, nodes, heating, dt):
    """New velocities (FLIP) and positions, and the new momentum back onto the nodes: Ma (2005), Eqs. 2-33 to 2-37.

    The internal energy takes the work of the stress in the velocities before the forces: the first half of the
    step's (``heating`` times that of the viscosity). New positions go to ``moved`` (n, 3): the strain update that
    follows still uses the weights of the old ones.
    """
    for slab in slabs:
        begin, end = slab_start[slab], slab_start[slab + 1]
        _move(geometry, shape, particles, moved, order, begin, end, nodes, heating, dt)


@device
def _move(geometry, shape, particles, moved, order, begin, end, nodes, heating, dt):
    stencil = new_stencil(geometry, shape)
    drift = np.empty(3)
    kick = np.empty(3)
    for place in range(begin, end):
        p = order[place]
        fill_stencil(geometry, shape, particles.position, p, stencil)
        drift[:] = 0.0
        kick[:] = 0.0
        stress = total_stress(particles, p, heating)
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
        particles.energy[p] += 0.5 * power * dt / particles.density[p]
        for axis in range(3):
            particles.velocity[p, axis] += kick[axis] * dt
            moved[p, axis] = particles.position[p, axis] + drift[axis] * dt
        for a in range(stencil_size(geometry, shape)):
            i = stencil.node[a]
            share = stencil.weight[a] * particles.mass[p]
            for axis in range(3):
                nodes.momentum[i, axis] += share * particles.velocity[p, axis]


@device
def gather_velocity_gradient(geometry, shape, position, p, nodes, stencil, gradient):
    """Velocity gradient (3, 3) at particle ``p`` from the nodal velocities: Ma (2005), Eqs. 2-38, 2-39."""
    fill_stencil(geometry, shape, position, p, stencil)
    gradient[:, :] = 0.0
    for a in range(stencil_size(geometry, shape)):
        i = stencil.node[a]
        add_velocity_gradient(geometry, gradient, nodes.velocity, i, stencil.gradient, a)
