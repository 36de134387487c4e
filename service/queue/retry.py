"""Retry: whether a job gets another attempt after one that ended without a result, and when.

Each cause has a budget of attempts. Crashes and stalls are counted together, at one checkpoint: progress beyond it
starts the count anew, and the count is in the row of the job. A lost attempt is never charged to its run, but some runs
crash their worker: jobs that are lost again and again are delayed. Those losses are counted in memory: another
leader, or a restarted one, starts from zero.
"""

import time
from collections.abc import Mapping
from dataclasses import dataclass, replace
from itertools import islice

from service.files.disk_space import Space, names_full_disk
from service.files.lost_results import TooManyLost
from service.records.jobs import Cause, CrashCount, Lease, Stored
from service.store import Store
from service.workers.attempt import Ending
from service.workers.timings import DEFAULT, Timings

# Failed attempts of each cause that end a job; None: attempts of this cause are repeated without limit.
BUDGET: Mapping[Cause, int | None] = {
    Cause.VERDICT: 1,
    Cause.CRASH: 3,
    Cause.MEMORY_LIMIT: 1,
    Cause.TIME_LIMIT: 1,
    Cause.STALLED: 3,
    Cause.ERROR: 1,
    Cause.LOST: None,
}
MOST_LOST_RESULTS = 3  # times that the result of one run may be lost
CRASHES = frozenset({Cause.CRASH, Cause.STALLED})  # in one count

FREE_LOSSES = 3  # in a row, without a delay: a restart, a worker that was replaced
MOST_DOUBLINGS = 10  # more than lead from the first backoff to the longest
DAY = 24 * 3600.0  # time for which losses count: their job may have been cancelled
MOST_DELAYED = 500  # jobs; that many losses are the engine's fault, not the jobs'


@dataclass(frozen=True)
class Retry:
    """The decision about a job whose attempt ended without a result."""

    again: bool  # whether it gets another attempt
    crashes: CrashCount | None  # to be written in its row; None: no crash is counted


def decide(lease: Lease, cause: Cause, step: int | None) -> Retry:
    """Whether a job gets another attempt after one that ended for ``cause``.

    ``step`` is that of the last checkpoint of the attempt; earlier crashes count unless theirs was an earlier one.
    """
    count = None
    failed = 1
    if cause in CRASHES:
        before = lease.crashes if (step or 0) <= (lease.crash_step or 0) else 0
        failed = before + 1
        count = CrashCount(failed, max(step or 0, lease.crash_step or 0))
    budget = BUDGET[cause]
    return Retry(budget is None or failed < budget, count)


def excuse_full_disk(ending: Ending, space: Space) -> Ending:
    """The ending of an attempt, which is not an error of the run if the attempt met a full disk.

    Libraries report it in many ways (a short write, a signal from a mapped file), so no attempt that fails while the
    reserve is used up is charged to its run. If the disk was full at its end too, that says nothing about the run: it
    was lost. If there was space again, the run may be one that never fits, which counts as a crash.
    """
    if ending.cause not in (Cause.ERROR, *CRASHES):
        return ending
    if not (names_full_disk(ending.reason) or space.is_used_up(ending.free)):
        return ending
    space.note_full_disk()
    cause = Cause.LOST if space.is_used_up(ending.free) else Cause.CRASH
    return replace(ending, cause=cause, reason=f"the disk was full: {ending.reason}")


def make_again(store: Store, damaged: Stored) -> bool | None:
    """Have a damaged file made again; False: it no longer counts, None: too many are, for now."""
    try:
        return store.publications.mend(damaged, most=MOST_LOST_RESULTS)
    except TooManyLost:
        return None


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
        self._losses = {id: loss for id, loss in self._losses.items() if now - loss.until < DAY}
        ids = (id for id, loss in self._losses.items() if loss.until > now)
        return tuple(islice(ids, MOST_DELAYED))
