"""Mean axial velocity of a projectile at a time."""

from studies.measurements import Measurement, Reading
from studies.measurements._plug import PlugView, mean_velocity

NAME = "projectile_velocity"


def _read(view: PlugView) -> Reading:
    return Reading(mean_velocity(view, view.projectile))


MEASUREMENT = Measurement(
    name=NAME,
    title="Velocity of the projectile",
    unit="m s-1",
    meaning="mass-weighted mean axial velocity of the projectile at the time of the observation",
    version=1,
    read=_read,
)
