"""A box in space: coordinates x, y, z."""

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


class Cartesian3D(NamedTuple):
    """A grid of cubes."""

    lower: np.ndarray  # (3,) m
    spacing: float  # m
    cells: np.ndarray  # (3,) int64, of the domain
    nodes: np.ndarray  # (3,) int64, ghosts included


@implements(stencil_size, Cartesian3D)
def _(geometry, shape):
    return width(shape) ** 3


@implements(fill_stencil, Cartesian3D)
def _(geometry, shape, position, p, stencil):
    weight = stencil.line_weight
    slope = stencil.line_slope
    base1 = fill_line(
        shape, position_in_cells(geometry, position, p, 0), geometry.spacing, stencil, 0
    )
    base2 = fill_line(
        shape, position_in_cells(geometry, position, p, 1), geometry.spacing, stencil, 1
    )
    base3 = fill_line(
        shape, position_in_cells(geometry, position, p, 2), geometry.spacing, stencil, 2
    )
    count = 0
    for a in range(width(shape)):
        for b in range(width(shape)):
            row = ((base1 + a) * geometry.nodes[1] + base2 + b) * geometry.nodes[2] + base3
            flat = weight[0, a] * weight[1, b]
            flat1 = slope[0, a] * weight[1, b]
            flat2 = weight[0, a] * slope[1, b]
            for c in range(width(shape)):
                stencil.node[count] = row + c
                stencil.weight[count] = flat * weight[2, c]
                stencil.gradient[count, 0] = flat1 * weight[2, c]
                stencil.gradient[count, 1] = flat2 * weight[2, c]
                stencil.gradient[count, 2] = flat * slope[2, c]
                count += 1


@implements(internal_force, Cartesian3D)
def _(geometry, stress, gradient, a):
    return (
        stress[0] * gradient[a, 0] + stress[3] * gradient[a, 1] + stress[5] * gradient[a, 2],
        stress[3] * gradient[a, 0] + stress[1] * gradient[a, 1] + stress[4] * gradient[a, 2],
        stress[5] * gradient[a, 0] + stress[4] * gradient[a, 1] + stress[2] * gradient[a, 2],
    )


@implements(add_velocity_gradient, Cartesian3D)
def _(geometry, velocity_gradient, velocity, i, gradient, a):
    for j in range(3):
        for k in range(3):
            velocity_gradient[j, k] += velocity[i, j] * gradient[a, k]


@implements(lattice_measure, Cartesian3D)
def _(geometry, position, spacing):
    return spacing[0] * spacing[1] * spacing[2]


@implements(conserved_axes, Cartesian3D)
def _(geometry):
    return (1.0, 1.0, 1.0)


@implements(impact_axis, Cartesian3D)
def _(geometry):
    return 2
