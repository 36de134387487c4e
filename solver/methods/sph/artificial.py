"""Forces between two particles that are no part of the matter: artificial viscosity and artificial stress."""

import numpy as np

from solver.jit import device
from solver.methods.sph.neighbours import row, rows
from solver.methods.sph.smoothing import height
from solver.state import DENSITY, PRESSURE, S11, S12, S22, S23, S31, S33
from solver.vectors import minimum, spread

SOFTENING = 0.01  # of h^2, added to the squared distance: Monaghan (1992)


@device
def approach(along, squared, length):
    """mu = h v.x / (r^2 + 0.01 h^2) in m/s of two particles that approach, 0 of others; ``along`` is v.x."""
    return minimum(along, 0.0) * length / (squared + SOFTENING * length * length)


@device
def pair_viscosity(viscosity, mu, sound_speed, density):
    """Pi = (-a c mu + b mu^2) / rho with the means of both particles: Monaghan (1992), Annu. Rev. Astron. Astrophys.
    30, 543, Eqs. 4.1 and 4.2; Pa m6/kg2.
    """
    return mu * (viscosity.quadratic * mu - viscosity.linear * sound_speed) / density


def tensile_part(smoothing, table):
    """R = e max(s, 0) / rho^2 along each principal axis of the stresses s of the particles of a table; (n, 6).

    Gray, Monaghan and Swift (2001), Comput. Methods Appl. Mech. Eng. 190, 6641, in three dimensions;
    where all stresses are alike, Monaghan (2000), J. Comput. Phys. 159, 290. A pull along an axis is opposed along it.
    """
    stress = table[[S11, S12, S31, S12, S22, S23, S31, S23, S33]].T.reshape(-1, 3, 3)
    stress = stress - table[PRESSURE][:, None, None] * np.eye(3)
    principal, axes = np.linalg.eigh(stress)
    over = smoothing.tensile / np.square(table[DENSITY])
    pulled = np.maximum(principal, 0.0) * over[:, None]
    part = np.einsum("nij,nj,nkj->nik", axes, pulled, axes)
    return part[:, [0, 1, 2, 0, 1, 2], [0, 1, 2, 1, 2, 0]]


@device
def opposed(smoothing, dimensions, tensile, i, neighbours, k, q, gx, gy, gz):
    """The force R f grad W of the artificial stresses of both particles of eight pairs, that keeps them apart."""
    if smoothing.tensile > 0.0:
        own, near = row(tensile, i), rows(tensile, neighbours, k)
        part = repulsion(smoothing, dimensions, q)
        r11, r22, r33 = own[0] + near[0], own[1] + near[1], own[2] + near[2]
        r12, r23, r31 = own[3] + near[3], own[4] + near[4], own[5] + near[5]
        return (
            part * (r11 * gx + r12 * gy + r31 * gz),
            part * (r12 * gx + r22 * gy + r23 * gz),
            part * (r31 * gx + r23 * gy + r33 * gz),
        )
    none = spread(0.0)
    return none, none, none


@device
def repulsion(smoothing, dimensions, q):
    """(W(r) / W(spacing))^4, which the artificial stress is multiplied by: Monaghan (2000), Eq. 3.1, n = 4."""
    part = height(smoothing.function, dimensions, q)
    part = part / height(smoothing.function, dimensions, 1.0 / smoothing.ratio)
    square = part * part
    return square * square
