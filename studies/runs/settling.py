"""Whether a measurement has settled: its growth within the last window of time, against a share of its value."""

import math
from collections.abc import Sequence

import numpy as np

from studies.measurements import Reading
from studies.quantities.measured import CLOSED_ON_AXIS, STILL_COMING
from studies.scenarios import ObservationRate

# A particle moves its edge by a third to half of a cell when it comes loose: what varies by less has settled whatever
# the share of the value.
SETTLED_IN_CELLS = 0.25


def growth(times: Sequence[float], values: Sequence[float], rate: ObservationRate, *, from_nothing: bool) -> float:
    """Range of the values within the last window (s); NaN before one has passed, and without a present value.

    ``from_nothing``: a length that was not there yet, as a hole, has grown from zero.
    """
    # Observations are up to a step late; half of an interval leaves as many of them in every window.
    begin = times[-1] - rate.window + 0.5 * rate.interval
    earlier = [index for index, at in enumerate(times) if at <= begin]
    if not earlier:
        return math.nan
    inside = np.array(values[earlier[-1] :])
    if from_nothing:
        inside[:-1] = np.nan_to_num(inside[:-1])
    return float(np.ptp(inside))


def has_settled(last: Reading, growth: float, passed: float, rate: ObservationRate, cell: float) -> bool:
    """Two windows at least, and a growth within the last one below a share of the value or a quarter of a cell (m).

    ``passed`` (s) is the time since the stage began. A hole that a film still closes has not settled, whose diameter
    leaps when the film has flown away, and nothing has to which debris still comes.
    """
    if passed < 2.0 * rate.window or {CLOSED_ON_AXIS, STILL_COMING} & {*last.flags}:
        return False
    return growth < max(rate.growth * abs(last.value), SETTLED_IN_CELLS * cell)
