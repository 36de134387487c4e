"""Attempts in warm processes of this one, and what is read of them."""

import json
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from typing import Any

from service.records.jobs import AttemptProgress, Kind
from service.workers.attempt import Attempt, Ending, Publication
from service.workers.supervisor import SendProgress, Supervisor
from service.workers.timings import DEFAULT, Timings
from service.workers.warm import Slot
from studies.runs.run import RunSpec
from tests.service.support.fakes import run_id, wait_until
from tests.service.support.targets import MEBIBYTE, FakeRun

SLOT = Slot()  # of all attempts in this process
LIMIT = 1024 * MEBIBYTE  # of memory; imports of the tests' targets take a tenth of it
NO_PAUSE = replace(DEFAULT, broken_worker_pause=0.0)
TARGETS = "tests.service.support.targets"


def attempt_at(folder: Path, behaviour: str = "fine", *, limit: float = 120.0, **more: Any) -> Attempt:
    """An attempt at a run that behaves as named."""
    run = FakeRun(run_id(1), {"behaviour": behaviour, **more})
    folder.mkdir(parents=True, exist_ok=True)
    directory = str(folder / "a1-token")
    return Attempt(directory, Kind.RUN, directory, run.as_json(), limit, TARGETS)


def with_checkpoint(folder: Path, **more: Any) -> Attempt:
    """An attempt at a run of many steps that writes a checkpoint."""
    return replace(attempt_at(folder, **more), checkpoint=str(folder / "checkpoint"))


def published(attempt: Attempt) -> Publication:
    """What an attempt to publish a sweep gets."""
    assert "outcomes" in attempt.spec
    return attempt.spec


def computed(attempt: Attempt) -> RunSpec:
    """What an attempt to compute a run gets."""
    assert "parameters" in attempt.spec
    return attempt.spec


def ignore(_progress: AttemptProgress) -> None:
    """Ignore progress."""


def supervise(attempt: Attempt, send: SendProgress = ignore, timings: Timings = NO_PAUSE) -> Ending:
    """Compute an attempt here and now."""
    return Supervisor(attempt, send, timings).run(SLOT)


class RunningAttempt:
    """An attempt under way in a thread."""

    def __init__(self, attempt: Attempt, timings: Timings = NO_PAUSE):
        self.attempt = attempt
        self.progress: list[AttemptProgress] = []
        self.supervisor = Supervisor(attempt, self.progress.append, timings)
        self._endings: list[Ending] = []
        self._thread = threading.Thread(target=self._run)
        self._thread.start()

    def _run(self) -> None:
        self._endings.append(self.supervisor.run(SLOT))

    def is_over(self) -> bool:
        """Whether it has ended, though its thread may not have."""
        return bool(self._endings)

    def end(self) -> Ending:
        """How it ended, once its thread is gone, with which a waiting process goes."""
        self._thread.join(120)
        ending = self._endings[0]
        task = Path(f"/proc/self/task/{self._thread.native_id}")  # a little longer than the thread
        wait_until(lambda: not task.exists(), pause=0.01)
        return ending

    def pid(self, name: str = "pid") -> int:
        """The process, or another one that wrote its id into a file of that name."""
        file = Path(self.attempt.directory) / name
        return int(wait_until(lambda: file.is_file() and file.read_text()))


@contextmanager
def under_way(attempt: Attempt, timings: Timings = NO_PAUSE) -> Iterator[RunningAttempt]:
    """An attempt that is stopped at the latest when the block ends."""
    running = RunningAttempt(attempt, timings)
    try:
        yield running
    finally:
        running.supervisor.stop()
        running.end()


def result_of(ending: Ending) -> dict[str, Any]:
    plain: dict[str, Any] = json.loads(Path(ending.files[0].path).read_text())
    return plain


def surroundings(ending: Ending) -> dict[str, Any]:
    provenance: dict[str, Any] = result_of(ending)["provenance"]
    return provenance


def process_of(ending: Ending) -> int:
    return int(surroundings(ending)["process"])


def log_of(attempt: Attempt) -> str:
    return (Path(attempt.directory) / "log.txt").read_text()
