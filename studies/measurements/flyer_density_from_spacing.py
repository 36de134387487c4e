"""The density that the distances of particles in the flying plate give behind the shock."""

from studies.measurements import Measurement, Reading
from studies.measurements._plates import FLYER, PlateView, density_from_spacing


def _read(seen: PlateView) -> Reading:
    return density_from_spacing(seen, FLYER)


MEASUREMENT = Measurement(
    name="flyer_density_from_spacing",
    title="Density in the flyer from spacing",
    unit="kg m-3",
    meaning="mass between the outermost layers of the plateau of the flyer, over the volume between them: what the "
    "positions of particles say, not what they carry",
    version=1,
    read=_read,
)
