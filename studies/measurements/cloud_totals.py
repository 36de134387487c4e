"""Mass, momentum and energy before and behind a plate."""

from collections.abc import Callable

import numpy as np

from studies.measurements import Measurement, Reading
from studies.measurements._cloud import CloudView, total_reading

Of = Callable[[CloudView], np.ndarray]

PLACES: dict[str, Callable[[CloudView, float], np.ndarray]] = {"behind": CloudView.behind, "before": CloudView.before}


def _mass(view: CloudView) -> np.ndarray:
    return view.mass


def _momentum(view: CloudView) -> np.ndarray:
    return view.mass * view.axial_velocity


def _kinetic(view: CloudView) -> np.ndarray:
    return 0.5 * view.mass * (view.axial_velocity**2 + view.transverse_velocity**2)


def _internal(view: CloudView) -> np.ndarray:
    return view.mass * view.energy


TOTALS: tuple[tuple[str, str, str, Of], ...] = (
    ("mass", "Mass", "kg", _mass),
    ("momentum", "Axial momentum", "N s", _momentum),
    ("kinetic_energy", "Kinetic energy", "J", _kinetic),
    ("internal_energy", "Internal energy", "J", _internal),
)


def _measurement(name: str, title: str, unit: str, of: Of, place: str) -> Measurement:
    def read(view: CloudView) -> Reading:
        return total_reading(view, of(view), PLACES[place])

    return Measurement(
        name=f"{name}_{place}",
        title=f"{title} {place} the plate",
        unit=unit,
        meaning=f"{title.lower()} of all matter {place} the plate's original surfaces, the lips of the hole and what "
        "departed from the grid included, of whole bodies",
        version=2,
        read=read,
    )


MEASUREMENT = tuple(_measurement(*total, place) for total in TOTALS for place in PLACES)
