"""The engine of this machine: threads, each with a warm process that computes one attempt at a time."""

import logging
import threading
import time
from contextlib import closing
from queue import SimpleQueue

from service.records.jobs import AttemptProgress
from service.workers.attempt import Attempt, Ended, Ending, Inbox, ProgressMessage
from service.workers.supervisor import Supervisor
from service.workers.timings import DEFAULT, Timings
from service.workers.warm import Slot, WarmProcess

log = logging.getLogger(__name__)


class LocalEngine:
    """``protocol.Engine`` on this machine; its processes end with this one, however it ends."""

    def __init__(self, workers: int, inbox: Inbox, timings: Timings = DEFAULT, ready: list[WarmProcess] | None = None):
        """``ready``: processes that were started before, for the first attempts."""
        self._inbox = inbox
        self._ready = ready
        self._timings = timings
        self._submitted: SimpleQueue[str | None] = SimpleQueue()  # keys; None ends a thread
        self._under_way: dict[str, Supervisor] = {}  # by key
        self._threads = [
            threading.Thread(target=self._work, name=f"slot-{number}", daemon=True) for number in range(workers)
        ]
        for thread in self._threads:
            thread.start()

    def slots(self) -> int:
        return len(self._threads)

    def submit(self, attempt: Attempt) -> None:
        def send(progress: AttemptProgress) -> None:
            self._inbox.put(ProgressMessage(attempt.key, progress))

        self._under_way[attempt.key] = Supervisor(attempt, send, self._timings)
        self._submitted.put(attempt.key)

    def stop(self, keys: list[str]) -> None:
        """Ask for the end of attempts, also of those that wait for a slot."""
        under_way = self._under_way.copy()
        for key in keys:
            if key in under_way:
                under_way[key].stop()

    def attempts(self) -> set[str]:
        """Keys of the attempts under way; those of an earlier life ended with it."""
        return set(self._under_way.copy())

    def follow(self, key: str) -> None:
        """Report an attempt that is not under way here as lost."""
        if key not in self._under_way:
            ending = Ending.lost("Gone", "the process that computed it has ended")
            self._inbox.put(Ended(key, ending))

    def forget(self, keys: list[str]) -> None:
        """Do nothing: ended attempts are forgotten already."""

    def close(self, leave_seconds: float | None) -> None:
        """End all processes; also with None, as they cannot outlive this one."""
        seconds = self._timings.leave if leave_seconds is None else leave_seconds
        end = time.monotonic() + seconds + self._timings.stop
        for supervisor in self._under_way.copy().values():
            supervisor.leave(seconds)
        for _ in self._threads:
            self._submitted.put(None)
        for thread in self._threads:
            thread.join(max(0.0, end - time.monotonic()))
        busy = sum(thread.is_alive() for thread in self._threads)
        if busy:
            raise TimeoutError(f"{busy} of {len(self._threads)} slots are still busy")

    def _work(self) -> None:
        """Compute attempt after attempt in one slot, until the engine closes."""
        with closing(Slot(self._timings.kill_wait, self._ready)) as slot:
            while (key := self._submitted.get()) is not None:
                try:
                    ending = self._under_way[key].run(slot)
                except Exception as error:  # whatever it is, the slot must serve the next attempt
                    log.exception("%s could not be supervised", key)
                    reason = f"it could not be supervised: {error}"
                    ending = Ending.lost(type(error).__name__, reason)
                del self._under_way[key]
                self._inbox.put(Ended(key, ending))
