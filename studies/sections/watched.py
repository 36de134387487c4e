"""The last section of a running run, in a file that its page shows: renewed a few times a minute."""

import time
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path

from solver.state import Snapshot
from studies.sections.section import SectionRecorder

FIRST, AGAIN = 5.0, 15.0  # s after the begin, and between two
SHARE = 0.01  # of the time of a run that it takes at most


class Watched:
    """Keeps the last section; what that took decides when the next one is due."""

    def __init__(self, file: Path, clock: Callable[[], float] = time.perf_counter):
        self._file, self._clock = file, clock
        self._due = clock() + FIRST
        self.spent = 0.0  # s

    def see(self, sections: SectionRecorder, snapshot: Snapshot) -> None:
        """Keep the section of a state if it is due; without effect where there is no space."""
        begin = self._clock()
        if begin < self._due:
            return
        with suppress(OSError):
            sections.save_now(snapshot, self._file)
        took = self._clock() - begin
        self.spent += took
        self._due = begin + took + max(AGAIN, took / SHARE)
