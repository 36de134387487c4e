"""The arrays of a simulation: particles, nodes, and the picture of both that leaves the solver. Allocation only."""

from typing import NamedTuple

import numpy as np


class Particles(NamedTuple):
    """Material points, n of them, sorted body by body. In axisymmetry mass is per radian."""

    position: np.ndarray  # (n, 3) m
    velocity: np.ndarray  # (n, 3) m/s
    mass: np.ndarray  # (n,) kg
    density: np.ndarray  # (n,) kg/m3
    energy: np.ndarray  # (n,) specific internal energy at the time level of the velocity, J/kg
    pressure: np.ndarray  # (n,) Pa, of the equation of state after the tensile floor
    viscosity: np.ndarray  # (n,) Pa, artificial, not negative
    deviator: np.ndarray  # (n, 6) Pa, components 11 22 33 12 23 31
    plastic_strain: np.ndarray  # (n,)
    temperature: np.ndarray  # (n,) K
    damage: np.ndarray  # (n,) 0 whole .. 1 failed
    number: np.ndarray  # (n,) permanent, int64
    alive: np.ndarray  # (n,) 1 on the grid, 0 once it has left, uint8


class Nodes(NamedTuple):
    """Grid fields; of nodes without mass the rest means nothing. In axisymmetry mass and force are per radian."""

    mass: np.ndarray  # (m,) kg
    momentum: np.ndarray  # (m, 3) kg m/s
    force: np.ndarray  # (m, 3) N
    before: np.ndarray  # (m, 3) velocity before the forces of the step, m/s
    velocity: np.ndarray  # (m, 3) m/s
    acceleration: np.ndarray  # (m, 3) m/s2
    smooth: (
        np.ndarray
    )  # (m, 3) ``before`` mapped to the particles and back, for damping of second order, m/s
    surface: np.ndarray  # (m, 3) outward area of a body, for contact, m2 (m2 per radian)


class Snapshot(NamedTuple):
    """A state at rest on one time level, for observers and files; arrays are views, copy to keep."""

    time: float  # s
    step: int
    particles: Particles
    body: np.ndarray  # (n,) index of each particle's body


def empty_particles(count):
    """Particles at rest, without stress."""
    return Particles(
        position=np.zeros((count, 3)),
        velocity=np.zeros((count, 3)),
        mass=np.zeros(count),
        density=np.zeros(count),
        energy=np.zeros(count),
        pressure=np.zeros(count),
        viscosity=np.zeros(count),
        deviator=np.zeros((count, 6)),
        plastic_strain=np.zeros(count),
        temperature=np.zeros(count),
        damage=np.zeros(count),
        number=np.arange(count, dtype=np.int64),
        alive=np.ones(count, dtype=np.uint8),
    )


def empty_nodes(count):
    """Nodes without mass."""
    return Nodes(
        mass=np.zeros(count),
        momentum=np.zeros((count, 3)),
        force=np.zeros((count, 3)),
        before=np.zeros((count, 3)),
        velocity=np.zeros((count, 3)),
        acceleration=np.zeros((count, 3)),
        smooth=np.zeros((count, 3)),
        surface=np.zeros((count, 3)),
    )


def joined(parts):
    """Particles of several bodies behind one another, numbered anew."""
    fields = {
        name: np.concatenate([getattr(part, name) for part in parts]) for name in Particles._fields
    }
    fields["number"] = np.arange(fields["mass"].size, dtype=np.int64)
    return Particles(**fields)


def selected(particles, index):
    """The particles at the given places, as new contiguous arrays."""
    return Particles(*(np.ascontiguousarray(field[index]) for field in particles))
