"""Everything on the grid, whatever its bodies are: energies, momentum and the largest pressure of any problem."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from studies.measurements import Measurement, Reading, View

if TYPE_CHECKING:
    from solver.state import Snapshot


@dataclass(frozen=True)
class WholeView(View):
    """Living particles; SI."""

    mass: np.ndarray  # (n,) kg
    velocity: np.ndarray  # (n, 3) m/s
    energy: np.ndarray  # (n,) specific internal energy, J/kg
    pressure: np.ndarray  # (n,) with the artificial viscosity, Pa


def view(snapshot: "Snapshot") -> WholeView:
    """A state as measurements of the whole see it."""
    p = snapshot.particles
    living = p.alive == 1
    return WholeView(
        mass=p.mass[living],
        velocity=p.velocity[living],
        energy=p.energy[living],
        pressure=p.pressure[living] + p.viscosity[living],
    )


def _sum(name: str, title: str, unit: str, meaning: str, of: Callable[[WholeView], float]) -> Measurement:
    def read(view: WholeView) -> Reading:
        return Reading(float(of(view)))

    return Measurement(name=name, title=title, unit=unit, meaning=meaning, definition=read)


def _momentum(axis: int) -> Measurement:
    letter = "xyz"[axis]
    return _sum(
        f"momentum_{letter}",
        f"Momentum along {letter}",
        "kg m s-1",
        f"momentum of the particles on the grid along {letter}",
        lambda view: (view.mass * view.velocity[:, axis]).sum(),
    )


MEASUREMENT = (
    _sum(
        "kinetic_energy",
        "Kinetic energy",
        "J",
        "kinetic energy of the particles on the grid",
        lambda view: 0.5 * (view.mass * (view.velocity**2).sum(axis=1)).sum(),
    ),
    _sum(
        "internal_energy",
        "Internal energy",
        "J",
        "internal energy of the particles on the grid, the chemical energy of explosives included",
        lambda view: (view.mass * view.energy).sum(),
    ),
    *map(_momentum, range(3)),
    _sum(
        "largest_pressure",
        "Largest pressure",
        "Pa",
        "largest pressure of a particle on the grid, with the artificial viscosity",
        lambda view: view.pressure.max(),
    ),
)
