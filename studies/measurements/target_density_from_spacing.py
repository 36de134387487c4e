"""The density that the distances of particles in the plate at rest give behind the shock."""

from studies.measurements import Measurement, Reading
from studies.measurements._plates import TARGET, PlateView, density_from_spacing


def _read(seen: PlateView) -> Reading:
    return density_from_spacing(seen, TARGET)


MEASUREMENT = Measurement(
    name="target_density_from_spacing",
    title="Density in the target from spacing",
    unit="kg m-3",
    meaning="mass between the outermost layers of the plateau of the target, over the volume between them: what the "
    "positions of particles say, not what they carry",
    version=1,
    read=_read,
)
