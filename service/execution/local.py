"""The engine of this machine: threads, each with a warm process that computes one attempt at a time."""

import logging
import threading
import time
from collections.abc import Mapping
from contextlib import closing
from queue import SimpleQueue
from typing import Any

from service.records.attempt import Attempt, Ended, Ending, Inbox, ProgressMessage
from service.workers.supervisor import LEAVE_SECONDS, STOP_SECONDS, Supervisor
from service.workers.warm import Slot

log = logging.getLogger(__name__)


class LocalEngine:
    """``protocol.Engine`` on this machine; its processes end with this one, however it ends."""

    def __init__(self, workers: int, inbox: Inbox):
        self._inbox = inbox
        self._submitted: SimpleQueue[str | None] = SimpleQueue()  # keys; None ends a thread
        self._under_way: dict[str, Supervisor] = {}  # by key
        self._threads = [
            threading.Thread(target=self._work, name=f"slot-{number}", daemon=True)
            for number in range(workers)
        ]
        for thread in self._threads:
            thread.start()

    def slots(self) -> int:
        """As many as there are threads."""
        return len(self._threads)

    def submit(self, ticket: Attempt) -> None:
        """Begin an attempt."""

        def tell(progress: Mapping[str, Any]) -> None:
            self._inbox.put(ProgressMessage(ticket.key, progress))

        self._under_way[ticket.key] = Supervisor(ticket, tell)
        self._submitted.put(ticket.key)

    def stop(self, keys: list[str]) -> None:
        """Ask for the end of attempts; those that wait for a slot hear it too."""
        under_way = self._under_way.copy()
        for key in keys:
            if key in under_way:
                under_way[key].stop()

    def known(self) -> set[str]:
        """Keys of the attempts under way; none of an earlier life, which ended with it."""
        return set(self._under_way.copy())

    def follow(self, key: str) -> None:
        """An attempt that is not under way here is lost."""
        if key not in self._under_way:
            self._inbox.put(
                Ended(key, Ending.lost("Gone", "the process that computed it has ended"))
            )

    def forget(self, keys: list[str]) -> None:
        """Nothing is kept of attempts that have ended."""

    def close(self, leave_seconds: float | None = LEAVE_SECONDS) -> None:
        """End all processes; also with None, as they cannot outlive this one."""
        seconds = LEAVE_SECONDS if leave_seconds is None else leave_seconds
        end = time.monotonic() + seconds + STOP_SECONDS
        for supervisor in self._under_way.copy().values():
            supervisor.leave(seconds)
        for _ in self._threads:
            self._submitted.put(None)
        for thread in self._threads:
            thread.join(max(0.0, end - time.monotonic()))
        left = sum(thread.is_alive() for thread in self._threads)
        if left:
            raise TimeoutError(f"{left} of {len(self._threads)} slots are still busy")

    def _work(self) -> None:
        """One slot: attempt after attempt, until the engine closes."""
        with closing(Slot()) as slot:
            while (key := self._submitted.get()) is not None:
                ending = self._compute(key, slot)
                del self._under_way[key]
                self._inbox.put(Ended(key, ending))

    def _compute(self, key: str, slot: Slot) -> Ending:
        try:
            return self._under_way[key].run(slot)
        except Exception as error:  # whatever it is, the slot must serve the next attempt
            log.exception("%s could not be supervised", key)
            return Ending.lost(type(error).__name__, f"it could not be supervised: {error}")
