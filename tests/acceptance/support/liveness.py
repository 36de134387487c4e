"""How long a service takes to say that it is alive, while somebody else keeps it busy."""

import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager
from http.client import HTTPConnection, HTTPException

PAUSE_SECONDS = 0.02
PATIENCE_SECONDS = 30.0


class LivenessProbe:
    """Another client, which asks ``/livez`` again and again, each time over a new connection."""

    def __init__(self, port: int):
        self._port = port
        self._stopped = threading.Event()
        self.slowest = 0.0  # s, of all answers
        self.statuses: list[int | str] = []  # of each answer, or the name of what was met instead

    def ask(self) -> None:
        """Ask until it is told to stop."""
        while True:
            begin = time.monotonic()
            self.statuses.append(self._status())
            self.slowest = max(self.slowest, time.monotonic() - begin)
            if self._stopped.wait(PAUSE_SECONDS):
                return

    def stop(self) -> None:
        self._stopped.set()

    def refusals(self) -> set[int | str]:
        """Whatever was answered that is not 200."""
        return {status for status in self.statuses if status != 200}

    def _status(self) -> int | str:
        connection = HTTPConnection("127.0.0.1", self._port, timeout=PATIENCE_SECONDS)
        try:
            connection.request("GET", "/livez")
            return connection.getresponse().status
        except (OSError, HTTPException) as error:
            return type(error).__name__
        finally:
            connection.close()


@contextmanager
def probing(port: int) -> Iterator[LivenessProbe]:
    """Ask until the end of the block."""
    probe = LivenessProbe(port)
    thread = threading.Thread(target=probe.ask)
    thread.start()
    try:
        yield probe
    finally:
        probe.stop()
        thread.join()
