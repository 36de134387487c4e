"""The section of a running run: renewed a few times a minute, at little of its time."""

from pathlib import Path

import pytest

from studies.sections.section import SectionRecorder, Watched

MOST = 0.02  # share of the time of a run


class Sections(SectionRecorder):
    """Takes some time to be written."""

    def __init__(self, clock: list[float], seconds: float):
        self.clock, self.seconds, self.written = clock, seconds, list[float]()

    def save_now(self, snapshot: object, path: Path) -> None:
        self.written.append(self.clock[0])
        self.clock[0] += self.seconds


@pytest.mark.parametrize("seconds", [0.05, 1.0, 5.0])
def test_section__is_renewed_a_few_times_a_minute_at_little_of_the_time(seconds: float, tmp_path: Path) -> None:
    """Of a run that is observed each second; a section takes so many."""
    clock = [0.0]
    watched, sections = Watched(tmp_path / "section-now.npz", lambda: clock[0]), Sections(clock, seconds)
    while clock[0] < 2000.0:
        clock[0] += 1.0
        watched.see(sections, None)  # type: ignore[arg-type]
    assert watched.spent < MOST * clock[0]
    assert sections.written[0] <= 6.0
    if seconds == 0.05:
        assert 3 <= sum(time < 60.0 for time in sections.written) <= 6
