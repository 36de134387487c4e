"""Warm processes: they have imported what computing needs, and take order after order.

``service.workers.warm_process`` is such a process, and says which words the two exchange. It dies with us: its stdin
ends, and the system kills it with the thread that started it, even if compiled code blocks all of its own.
"""

import json
import logging
import os
import selectors
import signal
import subprocess
import sys
import time
from collections.abc import Mapping
from contextlib import suppress
from dataclasses import asdict
from pathlib import Path
from typing import Any

from service.records.attempt import Attempt

log = logging.getLogger(__name__)

Words = Mapping[str, Any]

ORDERS_OF_A_CHILD = 100  # imports take a second or so: a hundredth of that each
KILL_SECONDS = 30.0  # for a killed process to go: one that waits for a dead mount does not

# One thread in each run: a sweep fills the cores with runs. Read when numba and BLAS are imported.
SINGLE_THREAD = dict.fromkeys(
    ("NUMBA_NUM_THREADS", "OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"), "1"
)


class Child:
    """A process that takes orders."""

    def __init__(self) -> None:
        self._process = subprocess.Popen(
            [sys.executable, "-P", "-m", "service.workers.warm_process"],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            cwd="/",
            env=_environment(),
            start_new_session=True,
            bufsize=0,
        )
        self.orders = 0  # taken so far
        self._rest = b""  # begin of a line
        self._unsaid = bytearray()  # what it has not listened to yet
        assert self._process.stdin is not None
        assert self._process.stdout is not None
        self._stdin, self._stdout = self._process.stdin, self._process.stdout
        os.set_blocking(self._stdin.fileno(), False)
        self._selector = selectors.DefaultSelector()
        self._selector.register(self._stdout, selectors.EVENT_READ)

    def take(self, ticket: Attempt) -> None:
        """Give it an order."""
        self.orders += 1
        self.say({"order": asdict(ticket)})

    def say(self, words: Words) -> None:
        """Say a line to it, as soon as it listens: ``hear`` goes on with what it does not take now."""
        self._unsaid += json.dumps(words).encode() + b"\n"
        self._go_on_saying()

    def _go_on_saying(self) -> None:
        try:
            while self._unsaid and (written := self._stdin.write(self._unsaid)):
                del self._unsaid[:written]
        except BrokenPipeError:  # it is gone; whoever asks for its end will see
            self._unsaid.clear()
        is_watched = self._stdin in self._selector.get_map()
        if self._unsaid and not is_watched:
            self._selector.register(self._stdin, selectors.EVENT_WRITE)
        elif is_watched and not self._unsaid:
            self._selector.unregister(self._stdin)

    def hear(self, seconds: float) -> list[Words]:
        """What it says within so many seconds, as soon as it says or takes something."""
        if not self._selector.get_map():  # its stdout has ended
            time.sleep(seconds)
            return []
        ready = self._ready(seconds)
        if self._stdin in ready:
            self._go_on_saying()
        if self._stdout not in ready:
            return []
        chunk = os.read(self._stdout.fileno(), 1 << 16)
        if not chunk:
            self._selector.unregister(self._stdout)
        *lines, self._rest = (self._rest + chunk).split(b"\n")
        return [json.loads(line) for line in lines]

    def has_more(self) -> bool:
        """Whether there is something to hear now; what it forked may keep its stdout open."""
        return self._stdout in self._ready(0.0)

    def _ready(self, seconds: float) -> list[Any]:
        """Those of its pipes that can be read or written within so many seconds."""
        return [key.fileobj for key, _ in self._selector.select(seconds)]

    def is_alive(self) -> bool:
        """Whether it has not ended; one that has is not waited for, so that its id stays taken."""
        flags = os.WEXITED | os.WNOHANG | os.WNOWAIT
        return os.waitid(os.P_PID, self._process.pid, flags) is None

    def data(self) -> int:
        """Bytes of data that it holds, as the limit counts them; 0 if nobody says."""
        try:
            pages = Path(f"/proc/{self._process.pid}/statm").read_text().split()[5]
        except (OSError, IndexError):
            return 0
        return int(pages) * os.sysconf("SC_PAGE_SIZE")

    def dismiss(self) -> None:
        """Let it go; it has no order and will leave at once."""
        self._stdin.close()
        self.end()

    def end(self) -> int | None:
        """End it, and everything that it started; its status, None: it does not go, though it was killed."""
        with suppress(ProcessLookupError):  # nothing is left
            os.killpg(self._process.pid, signal.SIGKILL)
        self._selector.close()
        self._stdin.close()
        self._stdout.close()
        try:
            return self._process.wait(KILL_SECONDS)
        except subprocess.TimeoutExpired:
            log.warning("the process %s was killed, and does not end", self._process.pid)
            return None


class Slot:
    """A place for one attempt at a time, and the process that waits there for the next one.

    To be used by one thread: its processes end with the thread that started them.
    """

    def __init__(self) -> None:
        self._idle: Child | None = None

    def acquire(self) -> Child:
        """The process that waits for an order, or a new one."""
        child, self._idle = self._idle, None
        if child is not None and not child.is_alive():
            child.end()
            child = None
        return child or Child()

    def release(self, child: Child) -> None:
        """Keep a process whose order has ended well for the next one, unless it has taken enough of them."""
        if child.orders < ORDERS_OF_A_CHILD:
            self._idle = child
        else:
            child.end()

    def close(self) -> None:
        """End the process that has no order."""
        child, self._idle = self._idle, None
        if child is not None:
            child.dismiss()


def _environment() -> dict[str, str]:
    """Ours, one thread, the same modules, and a trace in the log when the interpreter dies."""
    path = os.pathsep.join(os.path.abspath(entry) for entry in sys.path)
    return {**os.environ, **SINGLE_THREAD, "PYTHONPATH": path, "PYTHONFAULTHANDLER": "1"}
