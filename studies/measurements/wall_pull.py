"""The largest pull of a wall on a bar; a unilateral wall must not pull."""

import math

from studies.measurements import History, Measurement, Reading
from studies.measurements._bar import LOADED
from studies.measurements._push import MOMENTUM, push_of


def _read(history: History) -> Reading:
    """The largest mean pull between two observations over the largest push."""
    push = push_of(history)
    if push is None:
        return LOADED
    if not push.rates.size or push.impulse.max() <= 0.0:
        return Reading(math.nan, flags=("not_touched",))
    return Reading(max(0.0, float(-push.rates.min())) / float(push.rates.max()))


MEASUREMENT = Measurement(
    name="wall_pull",
    title="Largest pull of the wall",
    unit="1",
    meaning="largest pull of the wall on the bar between two observations, over its largest push",
    version=1,
    read=_read,
    follows=(MOMENTUM,),
)
