"""The elastic energy of a bar."""

from studies.measurements import Measurement, Reading
from studies.measurements._bar import BarView, energies


def _read(seen: BarView) -> Reading:
    return Reading(energies(seen).strain, {"resolution": seen.share})


MEASUREMENT = Measurement(
    name="strain_energy",
    title="Energy of strain",
    unit="1",
    meaning="elastic energy over the initial kinetic one; per mass K (ln r - 1 + 1/r) / rho0 + s:s / 4 G rho with "
    "r = rho / rho0",
    version=1,
    read=_read,
)
