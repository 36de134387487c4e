"""The velocity between the shocks of two colliding plates."""

from studies.measurements import Measurement, Reading
from studies.measurements._plates import FLYER, TARGET, PlateView, plateau_mean


def _read(view: PlateView) -> Reading:
    return plateau_mean(view, view.velocity, (FLYER, TARGET))


MEASUREMENT = Measurement(
    name="plateau_velocity",
    title="Plateau velocity",
    unit="m s-1",
    meaning="volume-weighted mean velocity between the shocks, without three cells at the interface and the outer 20 % "
    "on each side",
    version=1,
    read=_read,
)
