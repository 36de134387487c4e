"""The push of a wall on a bar, from the history of the bar's momentum: nothing else acts along its axis."""

from dataclasses import dataclass

import numpy as np

from studies.measurements import History

MOMENTUM = "rebound_momentum"


@dataclass(frozen=True)
class Push:
    """Mean push of a wall between observations."""

    times: np.ndarray  # (n - 1,) of the middles of the intervals, s
    rates: np.ndarray  # (n - 1,) share of the bar's initial momentum per second; negative: a pull
    impulse: np.ndarray  # (n,) so far, share of the initial momentum
    at: np.ndarray  # (n,) times of the observations, s


def push_of(history: History) -> Push | None:
    """The push between each two observations, empty before the second; None of a loaded bar, which has no momentum."""
    momentum, at = history.values[MOMENTUM], history.times
    if np.isnan(momentum).any():
        return None
    return Push(
        times=0.5 * (at[1:] + at[:-1]), rates=np.diff(momentum) / np.diff(at), impulse=momentum - momentum[0], at=at
    )
