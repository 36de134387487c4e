"""The density that particles of the plate at rest carry behind the shock."""

from studies.measurements import Measurement, Reading
from studies.measurements._plates import TARGET, PlateView, plateau_mean


def _read(seen: PlateView) -> Reading:
    return plateau_mean(seen, seen.density, (TARGET,))


MEASUREMENT = Measurement(
    name="target_density",
    title="Density in the target",
    unit="kg m-3",
    meaning="volume-weighted mean of the density that particles carry on the plateau of the target",
    version=1,
    read=_read,
)
