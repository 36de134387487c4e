"""Warm processes: they have imported what computing needs, and compute attempt after attempt.

``service.workers.warm_process`` is such a process, and describes the messages. It dies with this process: its stdin
ends, and the system kills it with the thread that started it, even if compiled code blocks all of its own threads.
"""

import json
import logging
import os
import selectors
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from dataclasses import asdict
from pathlib import Path

from service.workers.attempt import Attempt, Order, Report
from service.workers.timings import DEFAULT

log = logging.getLogger(__name__)


# Attempts of one process: imports and kernels cost 1.1 s, and a hundred small runs leave 1 MB behind (2026-11).
MOST_ATTEMPTS = 500

# One thread in each run: a sweep fills the cores with runs. Read when numba and BLAS are imported. Without the name of
# a scheduler Dask, where it is installed, imports that of a cluster when xarray writes a cube.
SINGLE_THREAD = {
    **dict.fromkeys(("NUMBA_NUM_THREADS", "OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"), "1"),
    "DASK_SCHEDULER": "synchronous",
}


class WarmProcess:
    """The parent's side of a warm process."""

    def __init__(self, *modules: str) -> None:
        """Start it; it imports the modules while it waits for its first attempt."""
        self._process = subprocess.Popen(
            [sys.executable, "-P", "-m", "service.workers.warm_process", *modules],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            cwd="/",
            env=environment(),
            start_new_session=True,
            bufsize=0,
        )
        self.attempts = 0  # computed so far
        self._partial_line = b""
        self._unsent = bytearray()
        assert self._process.stdin is not None
        assert self._process.stdout is not None
        self._stdin, self._stdout = self._process.stdin, self._process.stdout
        os.set_blocking(self._stdin.fileno(), False)
        self._selector = selectors.DefaultSelector()
        self._selector.register(self._stdout, selectors.EVENT_READ)

    def compute(self, attempt: Attempt) -> None:
        self.attempts += 1
        self.send({"attempt": attempt})

    def send(self, message: Order) -> None:
        """Send a message as far as the process reads now; ``receive`` sends the rest."""
        self._unsent += json.dumps(message, default=asdict).encode() + b"\n"
        self._go_on_sending()

    def _go_on_sending(self) -> None:
        try:
            while self._unsent and (written := self._stdin.write(self._unsent)):
                del self._unsent[:written]
        except BrokenPipeError:  # it has ended, which the supervisor will notice
            self._unsent.clear()
        is_registered = self._stdin in self._selector.get_map()
        if self._unsent and not is_registered:
            self._selector.register(self._stdin, selectors.EVENT_WRITE)
        elif is_registered and not self._unsent:
            self._selector.unregister(self._stdin)

    def receive(self, seconds: float) -> list[Report]:
        """The messages that arrive within ``seconds``; returns early when data is sent or read."""
        if not self._selector.get_map():  # its stdout has ended
            time.sleep(seconds)
            return []
        ready = [key.fileobj for key, _ in self._selector.select(seconds)]
        if self._stdin in ready:
            self._go_on_sending()
        if self._stdout not in ready:
            return []
        chunk = os.read(self._stdout.fileno(), 1 << 16)
        if not chunk:
            self._selector.unregister(self._stdout)
        *lines, self._partial_line = (self._partial_line + chunk).split(b"\n")
        return [json.loads(line) for line in lines]

    def has_more(self) -> bool:
        """Whether there is a message now; a fork of the process may keep its stdout open."""
        return any(key.fileobj is self._stdout for key, _ in self._selector.select(0.0))

    def is_alive(self) -> bool:
        """Whether it has not ended; an ended process is not reaped, so that its id stays taken."""
        flags = os.WEXITED | os.WNOHANG | os.WNOWAIT
        return os.waitid(os.P_PID, self._process.pid, flags) is None

    def data(self) -> int:
        """Bytes of data that it holds, as its limit counts them."""
        pages = Path(f"/proc/{self._process.pid}/statm").read_text().split()[5]
        return int(pages) * os.sysconf("SC_PAGE_SIZE")

    def processor_seconds(self) -> float:
        """Time of all of its threads on a processor."""
        # The name of the program, in brackets, may hold spaces; proc(5): fields 14 and 15.
        fields = Path(f"/proc/{self._process.pid}/stat").read_text().rpartition(")")[2].split()
        return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")

    def end(self, kill_wait: float) -> int | None:
        """Kill it and everything that it started; its status, None: it has not ended ``kill_wait`` seconds later."""
        with suppress(ProcessLookupError):  # nothing is left
            os.killpg(self._process.pid, signal.SIGKILL)
        self._selector.close()
        self._stdin.close()
        self._stdout.close()
        try:
            return self._process.wait(kill_wait)
        except subprocess.TimeoutExpired:
            log.warning("the process %s was killed but has not ended", self._process.pid)
            return None


class Slot:
    """A place for one attempt at a time, and the warm process that waits there for the next one.

    Used by one thread: its processes end with the thread that started them.
    """

    def __init__(self, kill_wait: float = DEFAULT.kill_wait, ready: list[WarmProcess] | None = None) -> None:
        self._kill_wait = kill_wait
        self._ready = ready or []  # started before; shared by the slots of an engine
        self._idle: WarmProcess | None = None

    def acquire(self) -> WarmProcess:
        """The process that waits for an attempt, or a new one."""
        process, self._idle = self._idle, None
        if process is None:
            with suppress(IndexError):
                process = self._ready.pop()
        if process is not None:
            if process.is_alive():
                return process
            process.end(self._kill_wait)
        return WarmProcess()

    def release(self, process: WarmProcess) -> None:
        """Keep a clean process for the next attempt, unless it has computed enough of them."""
        if process.attempts < MOST_ATTEMPTS:
            self._idle = process
        else:
            process.end(self._kill_wait)

    def close(self) -> None:
        """End the process that waits."""
        process, self._idle = self._idle, None
        if process is not None:
            process.end(self._kill_wait)


@contextmanager
def preloading(*modules: str) -> Iterator[list[WarmProcess]]:
    """A process that imports the modules during the block, in a list from which an engine takes it."""
    ready = [WarmProcess(*modules)]
    try:
        yield ready
    finally:
        for process in ready:
            process.end(DEFAULT.kill_wait)


def environment() -> dict[str, str]:
    """This process's environment, with one thread, the same modules, and a trace when the interpreter dies."""
    path = os.pathsep.join(os.path.abspath(entry) for entry in sys.path)
    return {**os.environ, **SINGLE_THREAD, "PYTHONPATH": path, "PYTHONFAULTHANDLER": "1"}
