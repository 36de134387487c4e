"""Whether a projectile goes through a plate."""

import math

from studies.measurements import Measurement, Reading
from studies.measurements._plug import PlugView, mean_velocity

NAME = "perforated"


def _read(view: PlugView) -> Reading:
    """1, 0, or no value while the projectile still goes into a plate that is not open."""
    speed = mean_velocity(view, view.projectile)
    if speed <= 0.0:
        return Reading(0.0)
    if view.is_open():
        return Reading(1.0)
    if speed <= mean_velocity(view, view.ring()):
        return Reading(0.0)
    return Reading(math.nan, flags=("undecided",))


MEASUREMENT = Measurement(
    name=NAME,
    title="Perforated",
    unit="1",
    meaning="1 where the plate that has not failed and hangs together with the rim is nowhere nearer to the axis than "
    "0.9 radii of the projectile, and the projectile flies forward; 0 where it does not, or where it is no faster than "
    "the plate between 0.75 and 1.25 diameters from the axis; else undecided: the run ends too early",
    version=1,
    read=_read,
    is_outcome=True,
)
