"""What of a bar's energy is neither motion nor strain."""

from studies.measurements import Measurement, Reading
from studies.measurements._bar import BarView, energies


def _read(seen: BarView) -> Reading:
    """Heat of viscosity and plastic work, what the wall took, and the drift, which the audit has alone."""
    split = energies(seen)
    return Reading(1.0 - split.rigid - split.vibration - split.strain, {"resolution": seen.share})


MEASUREMENT = Measurement(
    name="lost_energy",
    title="Energy lost",
    unit="1",
    meaning="initial kinetic energy that is neither motion nor elastic strain any more, over itself",
    version=1,
    read=_read,
)
