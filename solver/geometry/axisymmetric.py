"""A body of revolution without swirl: coordinates r, z, theta; every extensive quantity is per radian.

The hoop part of the gradient is N / r at the particle, so that a velocity v_r gives the hoop rate sum(v_r N) / r and a
hoop stress pulls its nodes inwards by V sigma_theta N / r: Sulsky and Schreyer (1996), Comput. Methods Appl. Mech.
Eng. 139, 409. Particles never sit on the axis (r = 0), whose nodes are held by the symmetric face.
"""

from typing import NamedTuple

import numpy as np

from solver.geometry import (
    add_velocity_gradient,
    conserved_axes,
    fill_stencil,
    impact_axis,
    internal_force,
    lattice_measure,
    position_in_cells,
    stencil_size,
)
from solver.jit import implements
from solver.shapes import fill_line, width


class Axisymmetric(NamedTuple):
    """A grid of square cells in the r-z half plane; the lower corner has r = 0."""

    lower: np.ndarray  # (3,) m
    spacing: float  # m
    cells: np.ndarray  # (3,) int64, of the domain
    nodes: np.ndarray  # (3,) int64, ghosts included


@implements(stencil_size, Axisymmetric)
def _(geometry, shape):
    return width(shape) ** 2


@implements(fill_stencil, Axisymmetric)
def _(geometry, shape, position, p, stencil):
    weight = stencil.line_weight
    slope = stencil.line_slope
    base1 = fill_line(
        shape, position_in_cells(geometry, position, p, 0), geometry.spacing, stencil, 0
    )
    base2 = fill_line(
        shape, position_in_cells(geometry, position, p, 1), geometry.spacing, stencil, 1
    )
    inverse_radius = 1.0 / position[p, 0]
    count = 0
    for a in range(width(shape)):
        row = (base1 + a) * geometry.nodes[1] + base2
        for b in range(width(shape)):
            both = weight[0, a] * weight[1, b]
            stencil.node[count] = row + b
            stencil.weight[count] = both
            stencil.gradient[count, 0] = slope[0, a] * weight[1, b]
            stencil.gradient[count, 1] = weight[0, a] * slope[1, b]
            stencil.gradient[count, 2] = both * inverse_radius
            count += 1


@implements(internal_force, Axisymmetric)
def _(geometry, stress, gradient, a):
    return (
        stress[0] * gradient[a, 0] + stress[3] * gradient[a, 1] + stress[2] * gradient[a, 2],
        stress[3] * gradient[a, 0] + stress[1] * gradient[a, 1],
        0.0,
    )


@implements(add_velocity_gradient, Axisymmetric)
def _(geometry, velocity_gradient, velocity, i, gradient, a):
    for j in range(2):
        for k in range(2):
            velocity_gradient[j, k] += velocity[i, j] * gradient[a, k]
    velocity_gradient[2, 2] += velocity[i, 0] * gradient[a, 2]


@implements(lattice_measure, Axisymmetric)
def _(geometry, position, spacing):
    return position[0] * spacing[0] * spacing[1]


@implements(conserved_axes, Axisymmetric)
def _(geometry):
    return (0.0, 1.0, 0.0)


@implements(impact_axis, Axisymmetric)
def _(geometry):
    return 1
