"""Place and velocity of a bar's end away from the wall, as an interferometer sees them.

The velocity is that of the motion. Velocities of particles have parts that the grid does not move them with: of single
layers behind a front they differed from the motion by 3 to 5 % with two and three particles a cell (2026-11-23).
"""

import math

import numpy as np

from studies.measurements import History, Measurement, Reading
from studies.measurements._bar import LOST, BarView, rear_of

PLACE = "rear_face_place"


def _place(view: BarView) -> Reading:
    return rear_of(view)


def _velocity(history: History) -> Reading:
    """The mean velocity since the last observation, uncertain by its change in that time."""
    at, place = history.times[-3:], history.values[PLACE][-3:]
    if np.isnan(place).any():
        return LOST
    velocities = np.diff(place) / np.diff(at)
    if not velocities.size:
        return Reading(math.nan, flags=("one_observation",))
    return Reading(float(velocities[-1]), {"sampling": float(np.ptp(velocities))})


MEASUREMENT = (
    Measurement(
        name=PLACE,
        title="Place of the rear face",
        unit="m",
        meaning="mean distance from the wall of the last layer of particles, at the end that is away from it",
        version=1,
        read=_place,
    ),
    Measurement(
        name="rear_face_velocity",
        title="Velocity of the rear face",
        unit="m s-1",
        meaning="velocity, away from the wall, with which the rear face has moved since the observation before",
        version=1,
        read=_velocity,
        follows=(PLACE,),
    ),
)
