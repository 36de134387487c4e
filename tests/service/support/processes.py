"""Processes of tests: free ports, shell commands, all that descends from a block, and their ends by id."""

import os
import random
import signal
import socket
import subprocess
import sys
import uuid
from collections.abc import Iterator, Mapping
from contextlib import contextmanager, suppress
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path
from unittest.mock import patch

import psutil

from tests.service.support.fakes import is_gone, wait_until

ROOT = Path(__file__).parents[3]
MARK = "CRASH_TEST_OF"  # in the environment of every process of a tree
patiently = partial(wait_until, seconds=180.0)  # what imports Dask starts slowly on a busy machine


def free_port() -> int:
    """Below those that the system gives to whoever asks for any: nobody gets it meanwhile."""
    while True:
        port = random.SystemRandom().randrange(10_000, 32_000)
        with socket.socket() as candidate, suppress(OSError):  # it is taken
            candidate.bind(("127.0.0.1", port))
            return port


def environment() -> dict[str, str]:
    """With the commands of this Python first, and this checkout of whipple."""
    path = os.pathsep.join([str(Path(sys.executable).parent), os.environ["PATH"]])
    return {**os.environ, "PATH": path, "PYTHONPATH": str(ROOT)}


def family(pid: int) -> list[int]:
    """A process and all that descend from it."""
    with suppress(psutil.NoSuchProcess):
        return [pid, *(child.pid for child in psutil.Process(pid).children(recursive=True))]
    return [pid]


def parent_of(pid: int) -> int:
    return psutil.Process(pid).ppid()


@dataclass
class ShellProcess:
    """A shell command in a session of its own, and what it says."""

    command: str
    folder: Path
    name: str
    more: Mapping[str, str] = field(default_factory=dict)  # environment
    descendants: set[int] = field(default_factory=set)  # ids of all that descended from it

    def __post_init__(self) -> None:
        self.log_file = self.folder / f"{self.name}.log"
        command = self.command.rstrip().replace("\ndask ", "\nexec dask ")
        with self.log_file.open("ab") as log:
            self.process = subprocess.Popen(
                # A test that is killed leaves no process that computes on.
                ["setpriv", "--pdeathsig", "KILL", "bash", "-c", command],
                cwd=self.folder,
                env={**environment(), **self.more},
                stdout=log,
                stderr=log,
                start_new_session=True,
            )

    def look(self) -> list[int]:
        """It, and what descends from it now."""
        pids = family(self.process.pid)
        self.descendants |= set(pids)
        return pids

    def kill(self) -> None:
        """Kill -9 all of it, as when a machine goes; what it had started must follow by itself."""
        self.look()
        for pid in family(self.process.pid):
            with suppress(ProcessLookupError):
                os.kill(pid, signal.SIGKILL)
        self.process.wait(60)

    def is_dead(self) -> bool:
        """Whether it has ended itself."""
        return self.process.poll() is not None or is_gone(self.process.pid)

    def is_gone(self) -> bool:
        """Whether nothing is left of it and of all that it was seen to have started."""
        return all(is_gone(pid) for pid in self.descendants | {self.process.pid})


class ProcessTree:
    """All that descends from what a block started, orphans included: a mark in the environment that they began with."""

    def __init__(self, mark: str):
        self._mark = f"{MARK}={mark}".encode()

    def pids(self) -> set[int]:
        """Those that live now; one that has ended and was not waited for has no environment."""
        return {int(entry.name) for entry in Path("/proc").glob("[0-9]*") if self._has(entry)}

    def left(self) -> set[int]:
        """Those that do not end by themselves; the last helpers of a process see its end, and follow."""
        with suppress(AssertionError):
            wait_until(lambda: not self.pids())
        return self.pids()

    def end(self) -> None:
        for pid in self.pids():
            kill_and_wait(pid)
        wait_until(lambda: not self.pids())

    def _has(self, entry: Path) -> bool:
        try:
            return self._mark in (entry / "environ").read_bytes().split(b"\0")
        except OSError:  # it ended while we looked, or is somebody else's
            return False


@contextmanager
def process_tree() -> Iterator[ProcessTree]:
    """Mark what is started in the block; nothing of it outlives the block."""
    mark = uuid.uuid4().hex
    tree = ProcessTree(mark)
    try:
        with patch.dict(os.environ, {MARK: mark}):
            yield tree
    finally:
        tree.end()


@contextmanager
def unmarked() -> Iterator[None]:
    """Start processes without the mark of a tree in the block, so that they outlive every tree."""
    with patch.dict(os.environ):
        os.environ.pop(MARK, None)
        yield


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
