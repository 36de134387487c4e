"""Pressures between two particles that are no part of the matter: artificial viscosity and artificial stress."""

from solver.jit import device
from solver.sph.smoothing import height
from solver.vectors import maximum, minimum

SOFTENING = 0.01  # of h^2, added to the squared distance: Monaghan (1992), section 4.1


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


@device
def tensile_part(smoothing, pressure, density):
    """R = e |p| / rho^2 of a particle in tension, 0 in compression: Monaghan (2000), J. Comput. Phys. 159, 290."""
    return smoothing.tensile * maximum(-pressure, 0.0) / (density * density)


@device
def repulsion(smoothing, dimensions, q):
    """(W(r) / W(spacing))^4, which the artificial stress is multiplied by: Monaghan (2000), Eq. 3.1, n = 4."""
    part = height(smoothing.function, dimensions, q)
    part = part / height(smoothing.function, dimensions, 1.0 / smoothing.ratio)
    square = part * part
    return square * square
