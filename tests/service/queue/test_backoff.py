"""Jobs that were lost again and again: how long they are delayed."""

from service.queue.backoff import FREE_LOSSES, Backoff
from service.records.jobs import Keep, Kind, Lease, State
from service.records.timings import DEFAULT, Timings
from tests.service.support.fakes import run_id

LEASE = Lease(
    id=run_id(1),
    kind=Kind.RUN,
    attempt=1,
    term=1,
    token="0123abcd",
    crashes=0,
    crash_step=None,
    priority=0,
    keep=Keep.FINAL,
    state=State.RUNNING,
    spec={},
    sweep_id=None,
)


def test_delay__doubles_to_a_longest_one() -> None:
    backoff = Backoff()
    delays = [backoff.lose(LEASE, None) for _ in range(FREE_LOSSES + 100)]
    assert delays[:FREE_LOSSES] == [0.0] * FREE_LOSSES
    assert delays[FREE_LOSSES : FREE_LOSSES + 4] == [10.0, 20.0, 40.0, 80.0]
    assert set(delays[FREE_LOSSES + 6 :]) == {DEFAULT.backoff_longest}
    assert backoff.delayed() == (LEASE.id,)


def test_delay__is_over_after_its_seconds() -> None:
    backoff = Backoff(Timings(backoff_first=0.0))
    for _ in range(FREE_LOSSES + 1):
        backoff.lose(LEASE, None)
    assert backoff.delayed() == ()


def test_count__begins_anew_after_progress_or_another_ending() -> None:
    backoff = Backoff()
    assert {backoff.lose(LEASE, step) for step in range(1, 100)} == {0.0}
    assert [backoff.lose(LEASE, 99) for _ in range(FREE_LOSSES)][-1] == DEFAULT.backoff_first
    backoff.clear(LEASE)
    assert backoff.lose(LEASE, None) == 0.0
