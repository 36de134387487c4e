"""The motion of a bar as a whole."""

from studies.measurements import Measurement, Reading
from studies.measurements._bar import BarView, energies


def _read(seen: BarView) -> Reading:
    return Reading(energies(seen).rigid, {"resolution": seen.share})


MEASUREMENT = Measurement(
    name="rigid_energy",
    title="Energy of rigid motion",
    unit="1",
    meaning="kinetic energy of the bar's motion as a whole along its axis, over the initial kinetic energy",
    version=1,
    read=_read,
)
