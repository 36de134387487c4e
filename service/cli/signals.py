"""Ctrl-C and SIGTERM as requests that a loop checks.

The exception that Python raises on a signal can be lost: raised while a finalizer or a callback of the garbage
collector runs (a client of Dask has one), it is printed and forgotten. So the handler only notes the request, and wakes
the waiting thread.
"""

import atexit
import os
import select
import signal
import sys
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from queue import Empty, SimpleQueue
from types import FrameType

ASKS = (signal.SIGINT, signal.SIGTERM)
SLICE = 0.25  # s; a signal that comes just before a wait begins does not end it, so none is longer
KILLED_BY = 128  # a shell's exit status of a process that a signal ended: this and its number


class EndRequest:
    def __init__(self) -> None:
        # Its ``put`` may interrupt a ``get`` of the same thread; that of an Event would wait for ever.
        self._signals: SimpleQueue[signal.Signals] = SimpleQueue()
        self._first: signal.Signals | None = None
        self.alarm: SimpleQueue[bool] = SimpleQueue()  # true: asked; false: left without

    def ask(self, number: int, frame: FrameType | None = None) -> None:
        """Record the request to end; this is the signal handler."""
        self._signals.put(signal.Signals(number))
        self.alarm.put(True)

    def asked(self, *, wait: float = 0.0) -> signal.Signals | None:
        """The first request to end, or None if none arrives within ``wait`` seconds."""
        end = time.monotonic() + wait
        while self._first is None:
            left = end - time.monotonic()
            try:
                self._first = self._signals.get(timeout=min(max(left, 0.0), SLICE))
            except Empty:
                if left <= 0.0:
                    break
        return self._first

    def raise_if_requested(self, *, wait: float = 0.0) -> None:
        """Wait for ``wait`` seconds; on a request to end, raise the exception that ends the program."""
        requested = self.asked(wait=wait)
        if requested is signal.SIGINT:
            raise KeyboardInterrupt
        if requested is not None:
            raise SystemExit(KILLED_BY + requested)

    def go(self) -> None:
        """On a request to end, end the process here with status 0 without waiting for its threads.

        For the last line of a program that has closed what it opened: the interpreter would join
        every thread, and one may be busy for minutes, or wait for a disk.
        """
        if self.asked() is not None:
            atexit._run_exitfuncs()  # what is registered there is not about threads
            for stream in (sys.stdout, sys.stderr):
                with suppress(OSError, ValueError):  # its reader has ended
                    stream.flush()
            os._exit(0)


@contextmanager
def handling_end_signals(*, end_within: float | None = None) -> Iterator[EndRequest]:
    """Turn Ctrl-C and SIGTERM into requests to end within the block.

    A signal that is ignored (``nohup``, a job in the background) stays so; in other threads than the main one nothing
    changes. With ``end_within`` the process ends with status 0 that many seconds after the first request if it still
    runs, in the block or after it: for programs that may be killed at any moment, as the service may.
    """
    end_request = EndRequest()
    if threading.current_thread() is not threading.main_thread():
        yield end_request
        return
    before = {number: signal.getsignal(number) for number in ASKS}
    handled = [number for number in ASKS if before[number] not in (signal.SIG_IGN, None)]
    if end_within is not None:
        watch = threading.Thread(target=_end_after, args=(end_request.alarm, end_within), daemon=True)
        watch.start()
    for number in handled:
        signal.signal(number, end_request.ask)
    try:
        yield end_request
    finally:
        for number in handled:
            signal.signal(number, before[number])
        if end_request.asked() is None:
            end_request.alarm.put(False)


def _end_after(alarm: "SimpleQueue[bool]", seconds: float) -> None:
    """Wait for the first request to end, then end the process after the time limit."""
    if not alarm.get():
        return
    time.sleep(seconds)
    try:
        if select.select([], [2], [], 0.0)[1]:  # else a write could block for ever
            os.write(2, b"closing took too long; the next start cleans up\n")
    finally:
        os._exit(0)
