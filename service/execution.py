"""The engine: workers of Dask over TLS. The only file that imports ``distributed``.

Dask is muscle: it is never given more than it has free slots, never retries, and may lose anything at
any moment. A slot is a worker process with one thread, in which a supervisor watches one child.
"""

import logging
import threading
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from queue import SimpleQueue
from typing import Any

import dask
import distributed

from service import worker
from service.jobs import Cause
from service.worker import Ending, Ticket

PROGRESS = "whipple-progress"  # topic
CLOSE_SECONDS = 10.0  # a child needs half a second to go, a worker a few

CONFIGURATION = {
    "distributed.scheduler.allowed-failures": 0,  # the row owns retries
    "distributed.scheduler.work-stealing": True,  # a task on a busy worker moves to a free one
    "distributed.worker.profile.enabled": False,
    "distributed.admin.low-level-log-length": 100,
}


@dataclass(frozen=True)
class Ended:
    """An attempt has ended, or the engine lost it."""

    key: str
    ending: Ending


@dataclass(frozen=True)
class Told:
    """What the process of an attempt said of its progress."""

    key: str
    words: Mapping[str, Any]  # with "seconds": wall clock of the attempt


Message = Ended | Told


class Engine:
    """Slots for attempts; what happens in them is put into ``inbox``."""

    def __init__(self, *, workers: int, scratch: Path, inbox: "SimpleQueue[Message | None]"):
        self._inbox = inbox
        self._futures: dict[str, distributed.Future] = {}
        self._lock = threading.Lock()
        dask.config.set(CONFIGURATION)
        self._cluster = distributed.LocalCluster(
            n_workers=workers,
            threads_per_worker=1,
            processes=True,
            protocol="tls://",
            security=distributed.Security.temporary(),
            dashboard_address=None,
            worker_dashboard_address=None,
            memory_limit=None,  # the supervisor is small, and Dask does not see its child
            local_directory=str(scratch),
            silence_logs=logging.CRITICAL,
        )
        self._client = distributed.Client(self._cluster, set_as_default=False)
        self._client.subscribe_topic(PROGRESS, self._hear)

    def slots(self) -> int:
        """Attempts that can be under way at once."""
        return sum(self._client.nthreads().values())

    def submit(self, ticket: Ticket) -> None:
        """Begin an attempt; ``Ended`` follows, whatever happens."""
        future = self._client.submit(
            _supervise, ticket, key=ticket.key, pure=False, retries=0, fifo_timeout="0 ms"
        )
        with self._lock:
            self._futures[ticket.key] = future
        future.add_done_callback(self._note_end)

    def stop(self, keys: list[str]) -> None:
        """Ask for the end of attempts; one that has not begun yet does not hear it, so ask again."""
        self._client.run(worker.stop, keys, wait=False, on_error="ignore")

    def close(self) -> None:
        """End every attempt, and the workers."""
        try:
            self._client.run(worker.stop, on_error="ignore")
            distributed.wait(list(self._futures.values()), timeout=CLOSE_SECONDS)
        except (TimeoutError, OSError, distributed.comm.CommClosedError):
            pass  # whatever hangs is killed with its worker
        self._client.close(timeout=CLOSE_SECONDS)
        self._cluster.close(timeout=CLOSE_SECONDS)

    def _note_end(self, future: distributed.Future) -> None:
        """Called in a thread of the client when a future is done, failed, cancelled or lost."""
        with self._lock:
            self._futures.pop(future.key, None)
        try:
            ending = future.result(timeout=CLOSE_SECONDS)
        except BaseException as error:  # cancellation is no Exception here
            ending = Ending(
                Cause.LOST, type(error).__name__, f"the worker is lost: {error}", (), 0.0
            )
        self._inbox.put(Ended(future.key, ending))
        future.release()

    def _hear(self, event: tuple[float, Mapping[str, Any]]) -> None:
        """Called in the loop of the client."""
        words = dict(event[1])
        self._inbox.put(Told(words.pop("key"), words))


def _supervise(ticket: Ticket) -> Ending:
    """The task: runs in a worker."""
    report = distributed.get_worker().log_event

    def tell(words: Mapping[str, Any]) -> None:
        report(PROGRESS, {"key": ticket.key, **words})

    return worker.supervise(ticket, tell)
