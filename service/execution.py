"""The engine: workers of Dask over TLS. The only file that imports ``distributed``.

Dask is muscle: it is never given more than it has free slots, never retries, and may lose anything
at any moment. A slot is a worker process with one thread; in it a supervisor watches one child.
"""

import logging
import signal
import threading
from collections.abc import Mapping
from contextlib import suppress
from dataclasses import dataclass
from multiprocessing import spawn
from pathlib import Path
from queue import SimpleQueue
from typing import Any

import dask
import distributed

from service import worker
from service.jobs import Cause
from service.worker import Ending, Ticket

PROGRESS = "whipple-progress"  # topic
WORKER_PROCESS = "Dask Worker process"  # how distributed.nanny names them
CLOSE_SECONDS = 10.0  # a child needs half a second to go, a worker a few

CONFIGURATION = {
    "distributed.scheduler.allowed-failures": 0,  # the row owns retries
    "distributed.scheduler.work-stealing": True,  # a task on a busy worker moves to a free one
    "distributed.scheduler.http.routes": [],  # no page without a login
    "distributed.worker.http.routes": [],
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
        self._changed = threading.Condition()  # guards the futures
        _spare_the_main_module()
        with dask.config.set(CONFIGURATION):
            self._cluster = distributed.LocalCluster(
                n_workers=workers,
                threads_per_worker=1,
                processes=True,
                protocol="tls://",
                security=distributed.Security.temporary(),
                scheduler_kwargs={"dashboard": False, "dashboard_address": "127.0.0.1:0"},
                memory_limit=None,  # the supervisor is small, and Dask does not see its child
                local_directory=str(scratch),
                silence_logs=logging.CRITICAL,
            )
        self._client = distributed.Client(self._cluster, set_as_default=False)
        self._client.register_plugin(_Undisturbed())
        self._client.subscribe_topic(PROGRESS, self._hear)

    def slots(self) -> int:
        """Attempts that can be under way at once."""
        return sum(self._client.nthreads().values())

    def submit(self, ticket: Ticket) -> None:
        """Begin an attempt; ``Ended`` follows, whatever happens."""
        future = self._client.submit(_supervise, ticket, key=ticket.key, pure=False, retries=0)
        with self._changed:
            self._futures[ticket.key] = future
        future.add_done_callback(self._note_end)

    def stop(self, keys: list[str]) -> None:
        """Ask for the end of attempts; one that has not begun does not hear it, so ask again."""
        self._client.run(_stop, keys, wait=False, on_error="ignore")

    def close(self) -> None:
        """End every attempt, and the workers."""
        with suppress(OSError, TimeoutError):  # a worker that does not answer is killed below
            self._client.run(_stop, on_error="ignore")
        with self._changed:
            self._changed.wait_for(lambda: not self._futures, CLOSE_SECONDS)
        self._client.close(timeout=CLOSE_SECONDS)
        self._cluster.close(timeout=CLOSE_SECONDS)

    def _note_end(self, future: distributed.Future) -> None:
        """Called in a thread of the client when a future is done, failed, cancelled or lost."""
        try:
            ending = future.result(timeout=CLOSE_SECONDS)
        except BaseException as error:  # cancellation is no Exception here
            reason = f"the worker is lost: {error}"
            ending = Ending(Cause.LOST, type(error).__name__, reason, (), 0.0)
        key = str(future.key)
        self._inbox.put(Ended(key, ending))
        future.release()
        with self._changed:
            self._futures.pop(key, None)
            self._changed.notify_all()

    def _hear(self, event: tuple[float, Mapping[str, Any]]) -> None:
        """Called in the loop of the client."""
        words = dict(event[1])
        self._inbox.put(Told(words.pop("key"), words))


def _spare_the_main_module() -> None:
    """Let workers start without importing the program that called us.

    Else a script that calls ``run_sweep`` outside of ``if __name__ == "__main__"`` would run again
    in each worker, and fail there; so would every worker that is replaced later.
    """
    plain = spawn.get_preparation_data

    def prepare(name: str) -> dict[str, Any]:
        prepared = plain(name)
        if name.startswith(WORKER_PROCESS):
            for entry in ("init_main_from_name", "init_main_from_path"):
                prepared.pop(entry, None)
        return prepared

    if plain.__module__ == spawn.__name__:  # else it is ours already
        spawn.get_preparation_data = prepare


class _Undisturbed(distributed.WorkerPlugin):
    """Ctrl-C in a terminal reaches all of its processes; workers leave it to the one above them."""

    name = "undisturbed"

    def setup(self, worker: Any) -> None:
        """Called in the main thread of each worker, also of one that replaces another."""
        signal.signal(signal.SIGINT, signal.SIG_IGN)


def _supervise(ticket: Ticket) -> Ending:
    """The task: runs in a worker."""
    report = distributed.get_worker().log_event

    def tell(words: Mapping[str, Any]) -> None:
        report(PROGRESS, {"key": ticket.key, **words})

    return worker.supervise(ticket, tell)


async def _stop(keys: list[str] | None = None) -> None:
    """Called in the loop of each worker, while its thread supervises."""
    worker.stop(keys)
