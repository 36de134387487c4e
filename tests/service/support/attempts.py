"""Attempts in warm processes of this one: orders, and what is seen of them."""

import json
import threading
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from typing import Any

from service.records.attempt import Attempt, Ending
from service.records.jobs import Kind
from service.workers.supervisor import Supervisor, Tell
from service.workers.warm import Slot
from tests.service.support.fakes import run_id, wait_until
from tests.service.support.targets import MEBIBYTE, Run

SLOT = Slot()  # of all attempts in this process
LIMIT = 1024 * MEBIBYTE  # of memory; imports of the tests' targets take a tenth of it


def ticket(folder: Path, behaviour: str = "fine", *, limit: float = 120.0, **more: Any) -> Attempt:
    run = Run(run_id(1), {"behaviour": behaviour, **more})
    folder.mkdir(parents=True, exist_ok=True)
    directory = str(folder / "a1-token")
    targets = "tests.service.support.targets"
    return Attempt(directory, Kind.RUN, directory, run.as_json(), limit, targets)


def kept(folder: Path, **more: Any) -> Attempt:
    """A run of many steps that keeps a checkpoint."""
    return replace(ticket(folder, **more), checkpoint=str(folder / "checkpoint"))


def nobody(_words: Mapping[str, Any]) -> None:
    """Nobody listens."""


def supervise(order: Attempt, tell: Tell) -> Ending:
    """Compute an attempt here and now."""
    return Supervisor(order, tell).run(SLOT)


class RunningAttempt:
    """An attempt under way in a thread."""

    def __init__(self, order: Attempt):
        self.order = order
        self.told: list[Mapping[str, Any]] = []
        self.supervisor = Supervisor(order, self.told.append)
        self._endings: list[Ending] = []
        self._thread = threading.Thread(target=self._run)
        self._thread.start()

    def _run(self) -> None:
        self._endings.append(self.supervisor.run(SLOT))

    def is_over(self) -> bool:
        """Whether it has ended, though its thread may not have."""
        return bool(self._endings)

    def end(self) -> Ending:
        """How it ended, as soon as it has and its thread is gone, with which a process that it kept goes."""
        self._thread.join(120)
        ending = self._endings[0]
        task = Path(f"/proc/self/task/{self._thread.native_id}")  # a little longer than the thread
        wait_until(lambda: not task.exists(), pause=0.01)
        return ending

    def pid(self, name: str = "pid") -> int:
        """The process, or another one that wrote its id into a file of that name."""
        file = Path(self.order.directory) / name
        return int(wait_until(lambda: file.is_file() and file.read_text()))


@contextmanager
def under_way(order: Attempt) -> Iterator[RunningAttempt]:
    """An attempt that is stopped at the latest when the block ends."""
    attempt = RunningAttempt(order)
    try:
        yield attempt
    finally:
        attempt.supervisor.stop()
        attempt.end()


def answer(ending: Ending) -> dict[str, Any]:
    """What result.json says."""
    plain: dict[str, Any] = json.loads(Path(ending.files[0].path).read_text())
    return plain


def seen(ending: Ending) -> dict[str, Any]:
    """What a run saw of its process."""
    provenance: dict[str, Any] = answer(ending)["provenance"]
    return provenance


def log_of(order: Attempt) -> str:
    return (Path(order.directory) / "log.txt").read_text()
