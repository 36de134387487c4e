"""Surfaces that let waves out: dashpots on a body's surface answer its motion as the matter beyond it would.

Lysmer and Kuhlemeyer (1969), J. Eng. Mech. Div. ASCE 95 (EM4), 859. The traction is minus the impedance times the
velocity, rho c of longitudinal waves along the normal and of shear waves across it: plane waves at normal incidence
leave entirely, oblique ones and those along a free surface in part. The impedance is that of undisturbed matter; a
shock has a larger one and is partly sent back.

A node near the surface has the area that the body has there at first, the sum of V grad N, so that the tractions
balance a uniform stress exactly, however the particles stand. Each node is slowed by its own velocity, the mean of
those before and after the step, which takes energy whatever the step. What is given and taken is booked.
"""

import math
from typing import NamedTuple

import numpy as np

from solver.eos import reference_density, reference_sound_speed
from solver.faces import Layer, fold_vectors
from solver.geometry import fill_stencil, internal_force, node_count, node_positions, stencil_size
from solver.jit import kernel
from solver.problem import Absorber, Face, Matter, Problem
from solver.transfer import new_stencil

REACH = 1.5  # cells: nodes nearer to a surface than this may have area there, for any shape


class Dashpots(NamedTuple):
    """The nodes of all absorbing surfaces, n of them."""

    node: np.ndarray  # (n,) indices
    constant: np.ndarray  # (n, 3) area times impedance, N s/m
    impulse: np.ndarray  # (n, 3) given in this step, N s


def absorber(matter: Matter, *, axis: int, side: int, place: float) -> Absorber:
    """A flat surface across an axis at a place (m) through which waves in undisturbed matter leave.

    ``side`` is 1 where the body lies below the place, 0 where it lies above.
    """
    density, sound = reference_density(matter.eos), reference_sound_speed(matter.eos)
    impedance = np.full(3, math.sqrt(density * matter.shear_modulus))
    impedance[axis] = math.sqrt(density * (density * sound**2 + 4.0 / 3.0 * matter.shear_modulus))
    return Absorber(axis, side, place, impedance)


def dashpots(problem: Problem, layers: list[list[Layer]]) -> Dashpots:
    """The nodes of a problem's absorbers between the closed faces of its grid."""
    area = np.zeros((node_count(problem.geometry), 3))
    for body in problem.bodies:
        volume = body.mass / body.density
        _scatter_area(problem.geometry, problem.shape, body.position, volume, area)
    for axis in layers:
        for layer in axis:
            if layer.kind == Face.SYMMETRIC:
                fold_vectors(layer, area)
    constant = np.zeros_like(area)
    place = node_positions(problem.geometry)
    for one in problem.absorbers:
        near = np.abs(place[:, one.axis] - one.place) < REACH * problem.geometry.spacing
        outwards = area[:, one.axis] if one.side == 1 else -area[:, one.axis]
        constant += np.where(near, np.maximum(outwards, 0.0), 0.0)[:, None] * one.impedance
    node = np.flatnonzero(constant.any(axis=1))
    return Dashpots(node, constant[node], np.zeros((node.size, 3)))


@kernel
def _scatter_area(geometry, shape, position, volume, area):
    """Outward area (m, 3) of particles at some places (n, 3): the force of a unit tension, and so none inside."""
    stencil = new_stencil(geometry, shape)
    unit = (1.0, 1.0, 1.0, 0.0, 0.0, 0.0)
    for p in range(volume.size):
        fill_stencil(geometry, shape, position, p, stencil)
        for a in range(stencil_size(geometry, shape)):
            share = internal_force(geometry, unit, stencil.gradient, a)
            for c in range(3):
                area[stencil.node[a], c] += volume[p] * share[c]


@kernel
def absorb(dashpots, nodes, dt, impulse):
    """Forces of the dashpots on nodes whose mass, momentum and force are complete."""
    for k in range(dashpots.node.size):
        i = dashpots.node[k]
        for c in range(3):
            dashpots.impulse[k, c] = 0.0
            if nodes.mass[i] > 0.0:
                constant = dashpots.constant[k, c] * dt
                mean = (nodes.momentum[i, c] + 0.5 * dt * nodes.force[i, c]) / nodes.mass[i]
                given = -constant * mean / (1.0 + 0.5 * constant / nodes.mass[i])
                nodes.force[i, c] += given / dt
                impulse[c] += given
                dashpots.impulse[k, c] = given


@kernel
def energy_absorbed(dashpots, nodes):
    """Minus the work of the impulses in the means of velocities before and mapped back after them, J."""
    energy = 0.0
    for k in range(dashpots.node.size):
        i = dashpots.node[k]
        if nodes.mass[i] > 0.0:
            for c in range(3):
                mean = 0.5 * (nodes.before[i, c] + nodes.momentum[i, c] / nodes.mass[i])
                energy -= dashpots.impulse[k, c] * mean
    return energy
