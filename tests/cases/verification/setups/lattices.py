"""Bodies of particles on a lattice, in the plane or in space, and the faces around them."""

import numpy as np

from solver.matter.laws import Matter
from solver.problem import Body, Face
from solver.problem.geometry import lattice_measure

FREE = (Face.FREE, Face.FREE)
MIRROR = (Face.SYMMETRIC, Face.FREE)  # below, and free above
MIRRORS = (Face.SYMMETRIC, Face.SYMMETRIC)


def middles(count: int, step: float, begin: float = 0.0) -> np.ndarray:
    """Places of ``count`` particles in the middle of steps from ``begin`` on, m."""
    return begin + step * (np.arange(count) + 0.5)


def lattice(*lines: np.ndarray) -> np.ndarray:
    """Points (n, 3) of the lattice of three lines, the last fastest; two lines lie in the plane z = 0."""
    points = np.meshgrid(*lines, *[np.zeros(1)] * (3 - len(lines)), indexing="ij")
    return np.stack([axis.ravel() for axis in points], axis=-1)


def lattice_body(
    matter: Matter,
    geometry: object,
    position: np.ndarray,
    step: tuple[float, float, float],
    *,
    density: float,
    velocity: np.ndarray | float = 0.0,
    name: str = "block",
) -> Body:
    """A body of lattice points (n, 3) with steps (3,), m, at a velocity, m/s: one of all axes, (3,) or (n, 3)."""
    return Body(
        name=name,
        matter=matter,
        position=position,
        velocity=np.zeros(3) + velocity,
        mass=density * np.ones(len(position)) * lattice_measure(geometry, position.T, step),
        density=density,
        spacing=step,
    )
