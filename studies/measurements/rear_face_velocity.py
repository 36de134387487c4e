"""The velocity of a bar's end away from the wall, as a velocity interferometer sees it."""

from studies.measurements import Measurement, Reading
from studies.measurements._bar import BarView, rear_velocity_of


def _read(view: BarView) -> Reading:
    return rear_velocity_of(view)


MEASUREMENT = Measurement(
    name="rear_face_velocity",
    title="Velocity of the rear face",
    unit="m s-1",
    meaning="axial velocity, away from the wall, of the last layer of particles at the end that is away from it",
    version=1,
    read=_read,
)
