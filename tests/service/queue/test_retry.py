"""Retry: budgets of causes, and how long lost jobs are delayed."""

import pytest

from service.queue.retry import BUDGET, FREE_LOSSES, Backoff, decide
from service.records.jobs import Cause
from service.workers.timings import DEFAULT
from tests.service.support.rows import lease_of

LEASE = lease_of()


@pytest.mark.parametrize(
    ("cause", "crashes", "again"),
    [
        (Cause.CRASH, 1, True),
        (Cause.CRASH, 2, False),
        (Cause.STALLED, 1, True),
        (Cause.STALLED, 2, False),
        (Cause.LOST, 99, True),
        (Cause.MEMORY_LIMIT, 0, False),
        (Cause.TIME_LIMIT, 0, False),
        (Cause.ERROR, 0, False),
        (Cause.VERDICT, 0, False),
    ],
)
def test_budget__is_of_each_cause(cause: Cause, crashes: int, again: bool) -> None:
    decision = decide(lease_of(crashes=crashes), cause, None)
    assert decision.again is again
    assert (decision.crashes is None) == (cause not in (Cause.CRASH, Cause.STALLED))
    assert set(BUDGET) == set(Cause)


def test_delay__doubles_to_a_longest_one() -> None:
    backoff = Backoff()
    delays = [backoff.lose(LEASE, None) for _ in range(FREE_LOSSES + 100)]
    assert delays[:FREE_LOSSES] == [0.0] * FREE_LOSSES
    assert delays[FREE_LOSSES : FREE_LOSSES + 4] == [10.0, 20.0, 40.0, 80.0]
    assert set(delays[FREE_LOSSES + 6 :]) == {DEFAULT.backoff_longest}
    assert backoff.delayed() == (LEASE.id,)


def test_count__begins_anew_after_progress_or_another_ending() -> None:
    backoff = Backoff()
    assert {backoff.lose(LEASE, step) for step in range(1, 100)} == {0.0}
    assert [backoff.lose(LEASE, 99) for _ in range(FREE_LOSSES)][-1] == DEFAULT.backoff_first
    backoff.clear(LEASE)
    assert backoff.lose(LEASE, None) == 0.0
