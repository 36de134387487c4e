"""The pressure between the shocks of two colliding plates."""

from studies.measurements import Measurement, Reading
from studies.measurements._plates import FLYER, TARGET, PlateView, plateau_mean


def _read(view: PlateView) -> Reading:
    return plateau_mean(view, view.pressure, (FLYER, TARGET))


MEASUREMENT = Measurement(
    name="plateau_pressure",
    title="Plateau pressure",
    unit="Pa",
    meaning="volume-weighted mean pressure between the shocks, without three cells at the interface and the outer 20 % "
    "on each side",
    version=1,
    read=_read,
)
