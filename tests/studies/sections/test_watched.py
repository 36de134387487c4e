"""The section of a running run: renewed a few times a minute, at little of its time."""

from pathlib import Path

from studies.sections.section import SectionRecorder, Watched

MOST = 0.02  # share of the time of a run


class Sections(SectionRecorder):
    """Takes some time to be written."""

    def __init__(self, clock: list[float], seconds: float):
        self.clock, self.seconds, self.written = clock, seconds, list[float]()

    def save_now(self, snapshot: object, path: Path) -> None:
        self.written.append(self.clock[0])
        self.clock[0] += self.seconds


def written(seconds: float, lasting: float, tmp_path: Path) -> tuple[list[float], float]:
    """When sections that take so many seconds are written, of a run that is observed each second; and the share."""
    clock = [0.0]
    watched, sections = Watched(tmp_path / "section-now.npz", lambda: clock[0]), Sections(clock, seconds)
    while clock[0] < lasting:
        clock[0] += 1.0
        watched.see(sections, None)  # type: ignore[arg-type]
    return sections.written, watched.spent / clock[0]


def test_section__is_renewed_a_few_times_a_minute(tmp_path: Path) -> None:
    times, _ = written(0.05, 60.0, tmp_path)
    assert 3 <= len(times) <= 6
    assert times[0] <= 6.0


def test_section__takes_at_most_two_hundredths_of_the_time(tmp_path: Path) -> None:
    for seconds in (0.05, 1.0, 5.0):
        times, share = written(seconds, 2000.0, tmp_path)
        assert times
        assert share < MOST
