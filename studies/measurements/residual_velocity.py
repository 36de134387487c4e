"""The velocity that a plate leaves to a projectile."""

import math

import numpy as np

from studies.measurements import History, Measurement, Reading
from studies.measurements.perforated import NAME as PERFORATED
from studies.measurements.projectile_velocity import NAME as VELOCITY

LAST = 0.1  # of the time so far: over it the velocity has to be constant
CONSTANT = 0.01  # of the impact speed


def _read(history: History) -> Reading:
    perforated, velocity = history.values[PERFORATED][-1], history.values[VELOCITY]
    if math.isnan(perforated):
        return Reading(math.nan, flags=("undecided",))
    if perforated == 0.0:
        return Reading(0.0)
    late = velocity[history.times >= (1.0 - LAST) * history.times[-1]]
    change = float(np.ptp(late))
    flags = ("in_contact",) if change > CONSTANT * velocity[0] else ()
    return Reading(float(velocity[-1]), {"sampling": change}, flags)


MEASUREMENT = Measurement(
    name="residual_velocity",
    title="Residual velocity",
    unit="m s-1",
    meaning="mass-weighted mean axial velocity of the projectile at the end of the run where it perforates the plate, "
    "0 where it does not; uncertain by its range over the last tenth of the run; in contact where that is more than "
    "1 % of the impact speed",
    version=1,
    read=_read,
    follows=(PERFORATED, VELOCITY),
)
