"""Jobs that were lost again and again rest a while, each time longer: a loss costs a run nothing, but
one that takes its worker along must not keep everybody busy.

Kept in memory: another service that takes over, or our next life, begins anew.
"""

import time
from dataclasses import dataclass
from itertools import islice

from service.records.jobs import Claim

FREE = 3  # losses in a row that are followed by no rest: a restart, a worker that was replaced
FIRST_SECONDS, LONGEST_SECONDS = 10.0, 600.0
DOUBLINGS = 10  # more than it takes to come from one to the other
MOST = 500  # that are passed over at once; so many losses are the engine's matter, not the jobs'


@dataclass(frozen=True)
class _Loss:
    in_a_row: int  # without a checkpoint in between
    step: int  # of the last checkpoint
    until: float  # monotonic


class Rests:
    """Who was lost how often, and rests until when."""

    def __init__(self) -> None:
        self._losses: dict[str, _Loss] = {}

    def lose(self, claim: Claim, step: int | None) -> float:
        """Note a loss at a checkpoint; the seconds that the job will rest."""
        before = self._losses.get(claim.id, _Loss(0, 0, 0.0))
        furthest = max(step or 0, before.step)
        in_a_row = 1 if furthest > before.step else before.in_a_row + 1
        seconds = 0.0
        if in_a_row > FREE:
            seconds = min(LONGEST_SECONDS, FIRST_SECONDS * 2 ** min(in_a_row - FREE - 1, DOUBLINGS))
        self._losses[claim.id] = _Loss(in_a_row, furthest, time.monotonic() + seconds)
        return seconds

    def rest(self, claim: Claim, seconds: float) -> None:
        """Let a job rest so many seconds, however often it was lost."""
        self._losses[claim.id] = _Loss(0, 0, time.monotonic() + seconds)

    def end(self, claim: Claim) -> None:
        """It ended in another way."""
        self._losses.pop(claim.id, None)

    def resting(self) -> tuple[str, ...]:
        """Jobs that should not be begun now."""
        now = time.monotonic()
        found = (id for id, loss in self._losses.items() if loss.until > now)
        return tuple(islice(found, MOST))
