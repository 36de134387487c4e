"""The time at which a projectile meets a plate."""

import math

import numpy as np

from studies.measurements import History, Measurement, Reading
from studies.measurements.projectile_velocity import NAME as VELOCITY

LOST = 1e-3  # of the impact speed: more than round-off and waves of one particle


def _read(history: History) -> Reading:
    """Where the line through the first two observations that show a loss meets the impact speed."""
    times, velocity = history.times, history.values[VELOCITY]
    late = np.flatnonzero(velocity < (1.0 - LOST) * velocity[0])
    if late.size < 2 or late[0] == 0:
        return Reading(math.nan, flags=("no_contact",))
    first = int(late[0])
    slope = (velocity[first + 1] - velocity[first]) / (times[first + 1] - times[first])
    before, after = times[max(first - 2, 0)], times[first]
    onset = after + (velocity[0] - velocity[first]) / slope if slope < 0.0 else before
    return Reading(float(np.clip(onset, before, after)), {"sampling": float(after - times[first - 1])})


MEASUREMENT = Measurement(
    name="first_contact",
    title="First contact",
    unit="s",
    meaning="time from which on the projectile slows down: where the line through the velocities of the first two "
    "observations that show a loss of more than 0.1 % meets the impact speed, at most two observations earlier",
    version=1,
    read=_read,
    follows=(VELOCITY,),
)
