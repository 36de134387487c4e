"""A problem as a whole: sums over the particles on the grid, whatever their bodies are."""

from dataclasses import dataclass
from typing import Any

import numpy as np


@dataclass(frozen=True)
class WholeView:
    """Living particles; SI."""

    mass: np.ndarray  # (n,) kg
    velocity: np.ndarray  # (n, 3) m/s
    energy: np.ndarray  # (n,) specific internal energy, J/kg
    pressure: np.ndarray  # (n,) with the artificial viscosity, Pa


def view(setting: Any, snapshot: Any) -> WholeView:
    """A state as measurements of the whole see it."""
    p = snapshot.particles
    living = p.alive == 1
    return WholeView(
        mass=p.mass[living],
        velocity=p.velocity[living],
        energy=p.energy[living],
        pressure=p.pressure[living] + p.viscosity[living],
    )
