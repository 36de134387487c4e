"""Backoff of jobs that are lost again and again: a loss is not charged to a run, but some runs crash their worker.

The counts are kept in memory: another leader, or a restarted one, starts from zero.
"""

import time
from dataclasses import dataclass
from itertools import islice

from service.records.jobs import Lease
from service.records.timings import DEFAULT, Timings

FREE_LOSSES = 3  # in a row: a restart, a worker that was replaced
MOST_DOUBLINGS = 10  # more than lead from the first backoff to the longest
MOST_DELAYED = 500  # jobs; that many losses are the engine's fault, not the jobs'


@dataclass(frozen=True)
class _Loss:
    in_a_row: int  # without a checkpoint in between
    step: int  # step of the last checkpoint
    until: float  # monotonic


class Backoff:
    """Losses by job, and the time at which each may begin again."""

    def __init__(self, timings: Timings = DEFAULT) -> None:
        self._timings = timings
        self._losses: dict[str, _Loss] = {}

    def lose(self, lease: Lease, step: int | None) -> float:
        """Note a loss behind the checkpoint of ``step``; the seconds for which the job is delayed."""
        before = self._losses.get(lease.id, _Loss(0, 0, 0.0))
        furthest = max(step or 0, before.step)
        in_a_row = 1 if furthest > before.step else before.in_a_row + 1
        seconds = 0.0
        if in_a_row > FREE_LOSSES:
            doublings = min(in_a_row - FREE_LOSSES - 1, MOST_DOUBLINGS)
            first, longest = self._timings.backoff_first, self._timings.backoff_longest
            seconds = min(longest, first * 2**doublings)
        self._losses[lease.id] = _Loss(in_a_row, furthest, time.monotonic() + seconds)
        return seconds

    def delay(self, lease: Lease, seconds: float) -> None:
        """Delay a job, however often it was lost."""
        self._losses[lease.id] = _Loss(0, 0, time.monotonic() + seconds)

    def clear(self, lease: Lease) -> None:
        """Forget the losses of a job that ended in another way."""
        self._losses.pop(lease.id, None)

    def delayed(self) -> tuple[str, ...]:
        """Ids of the jobs that must not begin now."""
        now = time.monotonic()
        ids = (id for id, loss in self._losses.items() if loss.until > now)
        return tuple(islice(ids, MOST_DELAYED))
