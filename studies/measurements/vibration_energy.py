"""The motion of a bar's parts against the whole."""

from studies.measurements import Measurement, Reading
from studies.measurements._bar import BarView, energies


def _read(seen: BarView) -> Reading:
    return Reading(energies(seen).vibration, {"resolution": seen.share})


MEASUREMENT = Measurement(
    name="vibration_energy",
    title="Energy of vibration",
    unit="1",
    meaning="kinetic energy of the bar's parts against its centre of mass, over the initial kinetic energy",
    version=1,
    read=_read,
)
