"""The clock of a stall: what counts as progress, and for how long."""

import pytest

from service.workers.supervisor import StallClock


def watched(clock: StallClock, seconds: int, *, busy: float = 0.0, has_steps: bool = True) -> float:
    """Seconds of silence, at most so many, until it has stalled; inf: it has not."""
    begin = clock.used
    for second in range(1, seconds + 1):
        clock.pass_by(1.0)
        if clock.has_run_out(used=begin + busy * second, has_steps=has_steps):
            return second
    return float("inf")


@pytest.mark.parametrize(
    ("longest", "busy", "has_steps", "stalls_after"),
    [
        (1, 0.0, True, 61),  # frozen: the least limit
        (30, 0.0, True, 301),  # of long steps: ten times their interval
        (1, 1.0, True, 601),  # busy within one step
        (30, 0.5, True, 3001),
        (0, 0.1, False, float("inf")),  # compiles, builds a problem, or publishes
        (0, 0.005, False, 61),  # waits, and looks around now and then
    ],
)
def test_stall__is_silence_of_ten_intervals(longest: int, busy: float, has_steps: bool, stalls_after: float) -> None:
    clock = StallClock(60.0)
    assert watched(clock, longest, has_steps=False) == float("inf")
    clock.hear()
    assert watched(clock, 4000, busy=busy, has_steps=has_steps) == stalls_after


def test_stall__does_not_count_time_in_which_nobody_watched() -> None:
    clock = StallClock(60.0)
    for _ in range(50):
        clock.pass_by(3600.0)
    assert not clock.has_run_out(used=0.0, has_steps=True)
