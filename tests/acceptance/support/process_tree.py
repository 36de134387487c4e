"""The process tree of a block: all that descends from what it started, orphans included."""

import os
import signal
import uuid
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from tests.service.support.fakes import is_gone, wait_until

MARK = "CRASH_TEST_OF"  # in the environment of every process of the tree


class ProcessTree:
    """The processes that carry a mark in the environment they were started with."""

    def __init__(self, mark: str):
        self._mark = f"{MARK}={mark}".encode()

    def pids(self) -> set[int]:
        """Those that live now; one that has ended and was not waited for has no environment."""
        return {int(entry.name) for entry in Path("/proc").glob("[0-9]*") if self._has(entry)}

    def is_empty(self) -> bool:
        """Whether nothing is left."""
        return not self.pids()

    def left(self) -> set[int]:
        """Those that do not end by themselves; the last helpers of a process see its end, and follow."""
        with suppress(AssertionError):
            wait_until(self.is_empty)
        return self.pids()

    def end(self) -> None:
        """Kill what is left."""
        for pid in self.pids():
            with suppress(ProcessLookupError):
                os.kill(pid, signal.SIGKILL)
        wait_until(self.is_empty)

    def _has(self, entry: Path) -> bool:
        try:
            return self._mark in (entry / "environ").read_bytes().split(b"\0")
        except OSError:  # it ended while we looked, or is somebody else's
            return False


def parent_of(pid: int) -> int:
    """The parent of a process; 0 if it is gone."""
    try:
        return int(Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[1])
    except OSError:
        return 0


def kill_and_wait(pid: int) -> bool:
    """Kill -9 a process, and wait until it has ended; whether it lived until then."""
    if is_gone(pid):
        return False
    try:
        os.kill(pid, signal.SIGKILL)
    except ProcessLookupError:
        return False
    wait_until(lambda: is_gone(pid))
    return True


@contextmanager
def process_tree() -> Iterator[ProcessTree]:
    """Mark what is started in the block; nothing of it outlives the block."""
    mark = uuid.uuid4().hex
    before = os.environ.get(MARK)
    os.environ[MARK] = mark
    tree = ProcessTree(mark)
    try:
        yield tree
    finally:
        if before is None:
            del os.environ[MARK]
        else:
            os.environ[MARK] = before
        tree.end()
