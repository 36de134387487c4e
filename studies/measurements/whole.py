"""Energies, momentum and largest pressure of all that is on the grid: what every problem has."""

from collections.abc import Callable

from studies.measurements import Measurement, Reading
from studies.measurements._whole import WholeView


def _sum(name: str, title: str, unit: str, meaning: str, of: Callable[[WholeView], float]) -> Measurement:
    def read(view: WholeView) -> Reading:
        return Reading(float(of(view)))

    return Measurement(name=name, title=title, unit=unit, meaning=meaning, version=1, read=read)


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
    _momentum(0),
    _momentum(1),
    _momentum(2),
    _sum(
        "largest_pressure",
        "Largest pressure",
        "Pa",
        "largest pressure of a particle on the grid, with the artificial viscosity",
        lambda view: view.pressure.max(),
    ),
)
