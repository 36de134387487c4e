"""Particles to nodes and back: written once for every geometry and shape.

Particles come in packs: eight at a time their weights are found and what they give or got is computed, one at a time
they meet their nodes, whose eight numbers are one vector. A kernel takes the particles of one share of a body; shares
add to tables of their own, which are then summed in a fixed order, so that one thread and many give the same bits.
"""

from typing import NamedTuple

from solver.grid.nodes import node_strides
from solver.grid.shapes import weights, width
from solver.grid.stencils import scatter, scatter_weighted, set_sources
from solver.jit import device, implements, kernel
from solver.matter.tensor import contract, scaled, symmetric
from solver.problem.geometry import MARGIN, Axisymmetric, Cartesian3D, dimensions, hoop_factor, unpacked
from solver.state import DENSITY, ENERGY, MASS, NEW_X, NEW_Y, NEW_Z, PRESSURE, VISCOSITY, VX, VY, VZ, X, Y, Z
from solver.steps.space import (
    PACK,
    WIDEST,
    columns,
    deviators_of,
    find_nodes,
    gather,
    opened,
    set_columns,
    velocity_gradient,
)
from solver.vectors import LANES, bare, first_lanes, load, spread, store, store_whole, total, where


@implements(find_nodes, Cartesian3D)
@implements(find_nodes, Axisymmetric)
def find_nodes_on_grid(geometry, shape, table, start, stop, pack):
    inverse = 1.0 / geometry.spacing
    lanes = first_lanes(LANES)
    for p in range(start, stop, LANES):
        k = p - start
        node = spread(0.0)
        for axis in range(dimensions(geometry)):
            place = (load(table, X + axis, p, first_lanes(stop - p)) - geometry.lower[axis]) * inverse
            first, values, slopes = weights(shape, place + MARGIN)
            node = node + first * float(node_strides(geometry)[axis])
            for a in range(width(shape)):
                store(pack.weight, axis * WIDEST + a, k, values[a], lanes)
                store(pack.slope, axis * WIDEST + a, k, slopes[a] * inverse, lanes)
        store_whole(pack.first, k, node)


@device
def stress_of(table, p, lanes, heating):
    """Stress of eight particles with ``heating`` times their artificial viscosity, six components in Pa."""
    isotropic = -(load(table, PRESSURE, p, lanes) + heating * load(table, VISCOSITY, p, lanes))
    s11, s22, s33, s12, s23, s31 = deviators_of(table, p, lanes)
    return s11 + isotropic, s22 + isotropic, s33 + isotropic, s12, s23, s31


@kernel
def scatter_state(geometry, shape, pack, table, ranges, nodes, touched):
    """Mass, momentum and internal force of particles: Ma (2005), Eqs. 2-29 to 2-31.

    ``ranges`` (b, 2) are the places of the particles of each body; ``touched`` notes the blocks of nodes.
    """
    geometry = unpacked(geometry)
    pack = opened(pack)
    table, nodes, touched = bare(table), bare(nodes), bare(touched)
    for body in range(ranges.shape[0]):
        begin, end = ranges[body, 0], ranges[body, 1]
        for start in range(begin, end, PACK):
            stop = min(start + PACK, end)
            find_nodes(geometry, shape, table, start, stop, pack)
            for p in range(start, stop, LANES):
                lanes = first_lanes(stop - p)
                mass = load(table, MASS, p, lanes)
                volume = mass / load(table, DENSITY, p, lanes)
                momentum = (
                    mass * load(table, VX, p, lanes),
                    mass * load(table, VY, p, lanes),
                    mass * load(table, VZ, p, lanes),
                )
                force = scaled(stress_of(table, p, lanes, 1.0), -volume)
                hoop = hoop_factor(geometry, load(table, X, p, lanes))
                set_sources(geometry, pack.lines, p - start, mass, momentum, force, hoop)
            for k in range(stop - start):
                scatter(geometry, shape, k, pack, nodes, touched)


@kernel
def scatter_surface(geometry, shape, pack, table, ranges, nodes, touched):
    """Mass, and in the place of the force the outward area: sum of V grad N, m2 (m2 per radian).

    It is the force of a unit tension turned round, and so vanishes inside a body in either geometry.
    """
    geometry = unpacked(geometry)
    pack = opened(pack)
    table, nodes, touched = bare(table), bare(nodes), bare(touched)
    none = spread(0.0)
    for body in range(ranges.shape[0]):
        begin, end = ranges[body, 0], ranges[body, 1]
        for start in range(begin, end, PACK):
            stop = min(start + PACK, end)
            find_nodes(geometry, shape, table, start, stop, pack)
            for p in range(start, stop, LANES):
                lanes = first_lanes(stop - p)
                mass = load(table, MASS, p, lanes)
                volume = mass / load(table, DENSITY, p, lanes)
                hoop = hoop_factor(geometry, load(table, X, p, lanes))
                unit = (volume, volume, volume, none, none, none)
                set_sources(geometry, pack.lines, p - start, mass, (none, none, none), unit, hoop)
            for k in range(stop - start):
                scatter(geometry, shape, k, pack, nodes, touched)


class StepWork(NamedTuple):
    """Parts of the work of stress and viscosity that go into the internal energy in a step."""

    part: float  # of the stress' work in the velocities before the forces
    heating: float  # of the viscosity's work: 1 heats, 0 does not


class StepDamping(NamedTuple):
    """The damping of a step."""

    part: float  # of the velocity that differs from the smoothed one, 0..1
    order: float  # 1 or 2: how often the velocity is smoothed


@kernel
def move_particles(geometry, shape, pack, table, ranges, motion, smoothed, mapped, work, damping, dt, lost):
    """New velocities (FLIP) and positions, and the new momentum back onto the nodes: Ma (2005), Eqs. 2-33 to 2-37.

    The internal energy takes the part ``work.part`` of the work of the stress in the velocities before the forces
    (``work.heating`` times that of the viscosity). New positions go to rows of their own: the strain update that
    follows still uses the weights of the old ones. Momentum (3) and energy that the damping takes are added to ``lost``
    (4,). The momentum of the particles goes to the table ``mapped``.
    """
    geometry = unpacked(geometry)
    pack = opened(pack)
    table, motion, mapped = bare(table), bare(motion), bare(mapped)
    smoothed = bare(smoothed)
    none = spread(0.0)
    for body in range(ranges.shape[0]):
        begin, end = ranges[body, 0], ranges[body, 1]
        for start in range(begin, end, PACK):
            stop = min(start + PACK, end)
            find_nodes(geometry, shape, table, start, stop, pack)
            for k in range(stop - start):
                gather(geometry, shape, k, pack, motion, pack.lines)
            if damping.part > 0.0 and damping.order > 1.0:
                for k in range(stop - start):
                    gather(geometry, shape, k, pack, smoothed, pack.smooth)
            for p in range(start, stop, LANES):
                k = p - start
                lanes = first_lanes(stop - p)
                mass = load(table, MASS, p, lanes)
                lanes = lanes & (mass > 0.0)  # what has left the grid stays as it was
                density = load(table, DENSITY, p, lanes)
                old = (load(table, VX, p, lanes), load(table, VY, p, lanes), load(table, VZ, p, lanes))
                x = load(table, X, p, lanes)
                seen = columns(pack.lines, k)
                gradient = velocity_gradient(geometry, pack.lines, k, hoop_factor(geometry, x))
                stress = stress_of(table, p, lanes, work.heating)
                power = contract(stress, symmetric(gradient))
                energy = load(table, ENERGY, p, lanes) + work.part * power * dt / density
                store(table, ENERGY, p, energy, lanes)
                kick = (seen[4] * dt, seen[5] * dt, seen[6] * dt)
                change = (none, none, none)
                if damping.part > 0.0:
                    change = damped(old, seen, columns(pack.smooth, k), damping)
                    for axis in range(3):
                        taken = where(lanes, -mass * change[axis], 0.0)
                        mean = old[axis] + 0.5 * (kick[axis] + change[axis])
                        lost[axis] += total(taken)
                        lost[3] += total(where(lanes, taken * mean, 0.0))
                new = (old[0] + kick[0] + change[0], old[1] + kick[1] + change[1], old[2] + kick[2] + change[2])
                store(table, VX, p, new[0], lanes)
                store(table, VY, p, new[1], lanes)
                store(table, VZ, p, new[2], lanes)
                y, z = load(table, Y, p, lanes), load(table, Z, p, lanes)
                store(table, NEW_X, p, x + (seen[1] + kick[0]) * dt, lanes)
                store(table, NEW_Y, p, y + (seen[2] + kick[1]) * dt, lanes)
                store(table, NEW_Z, p, z + (seen[3] + kick[2]) * dt, lanes)
                momentum = mass * new[0], mass * new[1], mass * new[2]
                set_columns(pack.lines, k, none, *momentum, none, none, none, none)
            for k in range(stop - start):
                scatter_weighted(geometry, shape, k, pack, mapped)


@device
def damped(velocity, seen, smooth, damping):
    """Minus the part ``damping.part`` of (1 - P)^order v: the change of eight velocities by damping, (3,).

    ``seen`` has P v, ``smooth`` P P v. Its part of the kinetic energy is that in the mean of old and new velocity, as
    the work of the forces is.
    """
    part, order = damping.part, damping.order
    return (
        -part * (velocity[0] - order * seen[1] + (order - 1.0) * smooth[1]),
        -part * (velocity[1] - order * seen[2] + (order - 1.0) * smooth[2]),
        -part * (velocity[2] - order * seen[3] + (order - 1.0) * smooth[3]),
    )


@kernel
def scatter_smoothed(geometry, shape, pack, table, ranges, motion, smoothed):
    """Momentum of particles that move with the nodes' velocities before the forces, onto the table ``smoothed``."""
    geometry = unpacked(geometry)
    pack = opened(pack)
    table, motion, smoothed = bare(table), bare(motion), bare(smoothed)
    none = spread(0.0)
    for body in range(ranges.shape[0]):
        begin, end = ranges[body, 0], ranges[body, 1]
        for start in range(begin, end, PACK):
            stop = min(start + PACK, end)
            find_nodes(geometry, shape, table, start, stop, pack)
            for k in range(stop - start):
                gather(geometry, shape, k, pack, motion, pack.lines)
            for p in range(start, stop, LANES):
                k = p - start
                mass = load(table, MASS, p, first_lanes(stop - p))
                seen = columns(pack.lines, k)
                momentum = mass * seen[1], mass * seen[2], mass * seen[3]
                set_columns(pack.lines, k, none, *momentum, none, none, none, none)
            for k in range(stop - start):
                scatter_weighted(geometry, shape, k, pack, smoothed)
