"""Exact flows of an ideal gas: Riemann's problem (Sod 1978) and Noh's implosion (1987), without units."""

import math
from dataclasses import dataclass

import numpy as np
from scipy.optimize import brentq

SOD_GAMMA = 1.4
NOH_GAMMA = 5.0 / 3.0


@dataclass(frozen=True)
class Gas:
    """A uniform state at rest or in motion."""

    density: float
    velocity: float
    pressure: float

    def energy(self, gamma: float) -> float:
        """Specific internal energy."""
        return self.pressure / ((gamma - 1.0) * self.density)

    def sound_speed(self, gamma: float) -> float:
        """Sound speed."""
        return math.sqrt(gamma * self.pressure / self.density)


# Sod (1978), J. Comput. Phys. 27, 1: the two halves of the tube.
SOD = (Gas(1.0, 0.0, 1.0), Gas(0.125, 0.0, 0.1))


@dataclass(frozen=True)
class Riemann:
    """A Riemann problem with a rarefaction on the left and a shock on the right; x from the membrane."""

    gamma: float
    left: Gas
    right: Gas
    pressure: float  # between the waves
    velocity: float  # between the waves
    left_density: float  # between rarefaction and contact
    right_density: float  # between contact and shock
    head: float  # speeds of rarefaction head and tail, contact and shock
    tail: float
    contact: float
    shock: float

    def density(self, x: np.ndarray, time: float) -> np.ndarray:
        """Density at places x at a time."""
        g = self.gamma
        speed = np.asarray(x) / time
        c = self.left.sound_speed(g)
        inside = 2.0 / (g + 1.0) + (g - 1.0) / ((g + 1.0) * c) * (self.left.velocity - speed)
        fan = self.left.density * np.maximum(inside, 0.0) ** (2.0 / (g - 1.0))
        return np.select(
            [speed < self.head, speed < self.tail, speed < self.contact, speed < self.shock],
            [np.full_like(speed, self.left.density), fan, self.left_density, self.right_density],
            self.right.density,
        )


def riemann(left: Gas, right: Gas, gamma: float) -> Riemann:
    """The solution for a rarefaction to the left and a shock to the right: Toro (2009), section 4.2.

    Sod's tube: p* = 0.30313, u* = 0.92745, densities 0.42632 and 0.26557, shock 1.75216:

    >>> sod = riemann(*SOD, SOD_GAMMA)
    >>> [round(x, 5) for x in (sod.pressure, sod.velocity, sod.left_density, sod.right_density, sod.shock)]
    [0.30313, 0.92745, 0.42632, 0.26557, 1.75216]
    >>> float(sod.density(np.array([0.0]), 1.0)[0].round(5))  # at the membrane, behind the tail
    0.42632
    """

    def left_velocity(p: float) -> float:
        c = left.sound_speed(gamma)
        ratio = (p / left.pressure) ** ((gamma - 1.0) / (2.0 * gamma))
        return left.velocity + 2.0 * c / (gamma - 1.0) * (1.0 - ratio)

    def right_velocity(p: float) -> float:
        a = 2.0 / ((gamma + 1.0) * right.density)
        b = (gamma - 1.0) / (gamma + 1.0) * right.pressure
        return right.velocity + (p - right.pressure) * math.sqrt(a / (p + b))

    p = float(brentq(lambda p: left_velocity(p) - right_velocity(p), right.pressure, left.pressure, xtol=1e-15))
    u = right_velocity(p)
    k = (gamma - 1.0) / (gamma + 1.0)
    strength = p / right.pressure
    left_density = left.density * (p / left.pressure) ** (1.0 / gamma)
    c = right.sound_speed(gamma)
    shock = right.velocity + c * math.sqrt((gamma + 1.0) / (2.0 * gamma) * strength + (gamma - 1.0) / (2.0 * gamma))
    return Riemann(
        gamma=gamma,
        left=left,
        right=right,
        pressure=p,
        velocity=u,
        left_density=left_density,
        right_density=right.density * (strength + k) / (k * strength + 1.0),
        head=left.velocity - left.sound_speed(gamma),
        tail=u - math.sqrt(gamma * p / left_density),
        contact=u,
        shock=shock,
    )


@dataclass(frozen=True)
class Noh:
    """Cold gas of density 1 and speed 1 that flows to a plane, an axis or a point: Noh (1987), J. Comput. Phys. 72, 78.

    The front runs outwards with (gamma - 1) / 2; behind it the gas rests with density ((gamma + 1) / (gamma - 1))^d and
    pressure density (gamma - 1) / 2. Gamma 5/3: a third of the speed, and densities 4, 16 and 64:

    >>> [round(Noh(dimensions).density, 9) for dimensions in (1, 2, 3)]
    [4.0, 16.0, 64.0]
    >>> round(Noh(1).front, 9), round(Noh(1).pressure, 9), round(Noh(3).ahead(0.2, 0.6), 9)
    (0.333333333, 1.333333333, 16.0)
    """

    dimensions: int  # 1 plane, 2 axis, 3 point
    gamma: float = NOH_GAMMA

    @property
    def front(self) -> float:
        """Speed of the shock."""
        return 0.5 * (self.gamma - 1.0)

    @property
    def density(self) -> float:
        """Density behind the shock."""
        return ((self.gamma + 1.0) / (self.gamma - 1.0)) ** self.dimensions

    @property
    def pressure(self) -> float:
        """Pressure behind the shock."""
        return self.density * 0.5 * (self.gamma - 1.0)

    def ahead(self, radius: float, time: float) -> float:
        """Density ahead of the shock."""
        return (1.0 + time / radius) ** (self.dimensions - 1)
