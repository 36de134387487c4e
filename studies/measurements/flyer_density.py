"""The density that particles of the flying plate carry behind the shock."""

from studies.measurements import Measurement, Reading
from studies.measurements._plates import FLYER, PlateView, plateau_mean


def _read(seen: PlateView) -> Reading:
    return plateau_mean(seen, seen.density, (FLYER,))


MEASUREMENT = Measurement(
    name="flyer_density",
    title="Density in the flyer",
    unit="kg m-3",
    meaning="volume-weighted mean of the density that particles carry on the plateau of the flyer",
    version=1,
    read=_read,
)
