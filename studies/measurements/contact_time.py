"""The time for which a bar stays at the wall."""

import math

import numpy as np

from studies.measurements import History, Measurement, Reading
from studies.measurements._bar import LOADED
from studies.measurements._push import MOMENTUM, push_of

WHOLE = 0.99  # of the impulse: the time over which the mean push is taken
END = 0.5  # of the mean push: a front that the grid smears evenly does not move it


def _read(history: History) -> Reading:
    """When the push falls below half of its mean for the last time, interpolated between observations."""
    push = push_of(history)
    if push is None:
        return LOADED
    if push.rates.size < 2 or push.impulse.max() <= 0.0:
        return Reading(math.nan, flags=("in_contact",))
    whole = int(np.argmax(push.impulse >= WHOLE * push.impulse[-1]))
    level = END * push.impulse[whole] / (push.at[whole] - push.at[0])
    last = int(np.flatnonzero(push.rates >= level)[-1])
    if last + 1 == push.rates.size:
        return Reading(math.nan, flags=("in_contact",))
    before, after = push.rates[last], push.rates[last + 1]
    interval = push.times[last + 1] - push.times[last]
    end = push.times[last] + (before - level) / (before - after) * interval
    return Reading(float(end - push.at[0]), {"sampling": float(interval)})


MEASUREMENT = Measurement(
    name="contact_time",
    title="Contact time",
    unit="s",
    meaning="time from the first touch until the wall's push falls, for the last time, below half of its mean; the "
    "mean is that over the time in which 99 % of the impulse is given",
    version=1,
    read=_read,
    follows=(MOMENTUM,),
)
