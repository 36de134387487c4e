"""Symmetric tensors of second order as six components: 11, 22, 33, 12, 23, 31.

Stress deviators and strain increments are tuples of six numbers, or vectors, inside kernels and rows of (n, 6) arrays
outside. A velocity gradient is three rows of three, v_j,k at [j][k]; that of a plane or of a body of revolution, which
neither shears nor turns out of the plane 1-2, is of a type of its own, because that saves a tenth of a step.
Shear components are tensor components, not engineering strains.
"""

from typing import NamedTuple

from solver.jit import device, generic, overridable
from solver.vectors import sqrt


class PlaneGradient(NamedTuple):
    """The rows of a velocity gradient whose components 13, 23, 31 and 32 are zero; 1/s."""

    first: tuple[float, float, float]
    second: tuple[float, float, float]
    third: tuple[float, float, float]

    def symmetric(self):
        none = self[1][2]
        shear = 0.5 * (self[0][1] + self[1][0])
        return (self[0][0], self[1][1], self[2][2], shear, none, none)

    def volume_ratio(self, dt):
        a, b = 1.0 + self[0][0] * dt, self[0][1] * dt
        d, e = self[1][0] * dt, 1.0 + self[1][1] * dt
        return (a * e - b * d) * (1.0 + self[2][2] * dt)

    def turned(self, a, dt):
        # A turn by the angle phi with tan(phi / 2) = half: half the difference of 11 and 22, and 12, turn by 2 phi.
        half = 0.25 * dt * (self[1][0] - self[0][1])
        square = half * half
        inverse = 1.0 / (1.0 + square)
        cos, sin = (1.0 - square) * inverse, 2.0 * half * inverse
        cos2, sin2 = cos * cos - sin * sin, 2.0 * sin * cos
        mean, part = 0.5 * (a[0] + a[1]), 0.5 * (a[0] - a[1])
        swing = part * cos2 - a[3] * sin2
        return (mean + swing, mean - swing, a[2], part * sin2 + a[3] * cos2, a[4], a[5])


@device
def contract(a, b):
    """Double contraction a : b of two symmetric tensors."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2] + 2.0 * (a[3] * b[3] + a[4] * b[4] + a[5] * b[5])


@device
def equivalent_stress(deviator):
    """Von Mises stress sqrt(3/2 s:s) of a deviator."""
    return sqrt(1.5 * contract(deviator, deviator))


@device
def equivalent_strain(deviator):
    """Von Mises strain sqrt(2/3 e:e) of a deviator."""
    return sqrt(2.0 / 3.0 * contract(deviator, deviator))


@device
def scaled(a, factor):
    """The tensor times a number."""
    return (a[0] * factor, a[1] * factor, a[2] * factor, a[3] * factor, a[4] * factor, a[5] * factor)


@device
def added(a, b, factor):
    """a + factor b."""
    return (
        a[0] + factor * b[0],
        a[1] + factor * b[1],
        a[2] + factor * b[2],
        a[3] + factor * b[3],
        a[4] + factor * b[4],
        a[5] + factor * b[5],
    )


@overridable
def symmetric(gradient):
    """Symmetric part of a velocity gradient."""
    return (
        gradient[0][0],
        gradient[1][1],
        gradient[2][2],
        0.5 * (gradient[0][1] + gradient[1][0]),
        0.5 * (gradient[1][2] + gradient[2][1]),
        0.5 * (gradient[2][0] + gradient[0][2]),
    )


@device
def strain_increment(gradient, dt):
    """Symmetric part of a velocity gradient times dt, and its trace."""
    strain = scaled(symmetric(gradient), dt)
    return strain, strain[0] + strain[1] + strain[2]


@overridable
def volume_ratio(gradient, dt):
    """det(I + L dt): what the step x + v dt does to a volume, exactly."""
    a, b, c = 1.0 + gradient[0][0] * dt, gradient[0][1] * dt, gradient[0][2] * dt
    d, e, f = gradient[1][0] * dt, 1.0 + gradient[1][1] * dt, gradient[1][2] * dt
    g, h, i = gradient[2][0] * dt, gradient[2][1] * dt, 1.0 + gradient[2][2] * dt
    return a * (e * i - f * h) - b * (d * i - f * g) + c * (d * h - e * g)


@device
def deviator(a, trace):
    """a - trace/3 I."""
    mean = trace * (1.0 / 3.0)
    return (a[0] - mean, a[1] - mean, a[2] - mean, a[3], a[4], a[5])


@device
def spin_increment(gradient, dt):
    """Axial vector of the antisymmetric part of a velocity gradient times dt: rotations about 1, 2, 3."""
    return (
        0.5 * dt * (gradient[2][1] - gradient[1][2]),
        0.5 * dt * (gradient[0][2] - gradient[2][0]),
        0.5 * dt * (gradient[1][0] - gradient[0][1]),
    )


class Jaumann(NamedTuple):
    """The stress rate of matter that turns: Ma (2005), Eq. 2-17."""

    def transported(self, gradient, a, dt):
        return turned(gradient, a, dt)


class Unturned(NamedTuple):
    """The rate of the stress components in space, as if matter did not turn: Ma (2005), Eq. 2-16."""

    def transported(self, gradient, a, dt):
        return a


@generic
def transported(stress_rate, gradient, a, dt):
    """A deviator after dt without straining, as a rate of stress has it."""


@overridable
def turned(gradient, a, dt):
    """A tensor rotated by the spin of a velocity gradient over dt: see ``rotated``."""
    return rotated(a, spin_increment(gradient, dt))


@device
def rotated(a, spin):
    """R a R^T with the rotation of the midpoint rule, R = (I - W/2)^-1 (I + W/2).

    The Jaumann rate integrated so that a rigid rotation of any size keeps the invariants to round-off: Hughes and
    Winget (1980), Int. J. Numer. Meth. Eng. 15, 1862. For small spin it is a + W a - a W, Ma (2005), Eq. 2-41.
    """
    # Rodrigues form of the Cayley transform: R = I + (W + W W / 2) * 4 / (4 + |w|^2).
    x, y, z = spin
    k = 4.0 / (4.0 + x * x + y * y + z * z)
    r11 = 1.0 - 0.5 * k * (y * y + z * z)
    r22 = 1.0 - 0.5 * k * (z * z + x * x)
    r33 = 1.0 - 0.5 * k * (x * x + y * y)
    r12 = k * (0.5 * x * y - z)
    r21 = k * (0.5 * x * y + z)
    r13 = k * (0.5 * x * z + y)
    r31 = k * (0.5 * x * z - y)
    r23 = k * (0.5 * y * z - x)
    r32 = k * (0.5 * y * z + x)
    a11, a22, a33, a12, a23, a31 = a
    # b = R a
    b11 = r11 * a11 + r12 * a12 + r13 * a31
    b12 = r11 * a12 + r12 * a22 + r13 * a23
    b13 = r11 * a31 + r12 * a23 + r13 * a33
    b21 = r21 * a11 + r22 * a12 + r23 * a31
    b22 = r21 * a12 + r22 * a22 + r23 * a23
    b23 = r21 * a31 + r22 * a23 + r23 * a33
    b31 = r31 * a11 + r32 * a12 + r33 * a31
    b32 = r31 * a12 + r32 * a22 + r33 * a23
    b33 = r31 * a31 + r32 * a23 + r33 * a33
    return (
        b11 * r11 + b12 * r12 + b13 * r13,
        b21 * r21 + b22 * r22 + b23 * r23,
        b31 * r31 + b32 * r32 + b33 * r33,
        b11 * r21 + b12 * r22 + b13 * r23,
        b21 * r31 + b22 * r32 + b23 * r33,
        b31 * r11 + b32 * r12 + b33 * r13,
    )
