"""Readiness: whether this process can compute what it accepts, for `/readyz`, `/metrics` and `/v1/queue` alike."""

import asyncio
import shutil
import tempfile
import threading
import time
from concurrent.futures import Future
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import anyio

from service.api.errors import ServiceNotReady
from service.api.schemas import Readiness
from service.queue import data_identity as identity
from service.records.jobs import QueueHead, StoreUnavailable
from service.settings import Settings
from service.store import Store

if TYPE_CHECKING:
    from service.queue.dispatcher import Dispatcher

# Seconds for which an outcome is reused: any client may ask, and each check takes the write lock.
REUSE_SECONDS = 1.0
# A store that takes longer is not ready; monitors rarely wait for 5 s.
TIMEOUT_SECONDS = 3.0
LATE = "the database has not responded yet"


@dataclass
class ReadinessCheck:
    """Runs one check at a time in a thread, and shares its outcome among all who ask."""

    settings: Settings
    store: Store
    engine: "Dispatcher"
    _mutex: threading.Lock = field(default_factory=threading.Lock)
    _last: Future[Readiness] | None = None
    _begin: float = 0.0  # monotonic

    def result(self) -> Readiness:
        """What the last check found, begun at most ``REUSE_SECONDS`` ago; raises ServiceNotReady, StoreUnavailable."""
        try:
            return self._begun().result(TIMEOUT_SECONDS)
        except TimeoutError:
            raise StoreUnavailable(LATE) from None

    async def awaited(self) -> Readiness:
        """The same, waited for without a thread."""
        try:
            with anyio.fail_after(TIMEOUT_SECONDS):
                return await asyncio.shield(asyncio.wrap_future(self._begun()))
        except TimeoutError:
            raise StoreUnavailable(LATE) from None

    def _begun(self) -> Future[Readiness]:
        """A check that goes on, or has just begun and ended.

        It may wait as long as the store does, in a thread that delays neither callers nor the exit.
        """
        with self._mutex:
            is_old = time.monotonic() - self._begin >= REUSE_SECONDS
            if self._last is None or (self._last.done() and is_old):
                self._last, self._begin = Future(), time.monotonic()
                threading.Thread(target=self._run, args=(self._last,), daemon=True).start()
            return self._last

    def problem(self) -> ServiceNotReady | StoreUnavailable | None:
        """The error that ``result`` raises; None: the service is ready."""
        try:
            self.result()
        except (ServiceNotReady, StoreUnavailable) as error:
            return error
        return None

    def _run(self, future: Future[Readiness]) -> None:
        try:
            future.set_result(self._check())
        except Exception as error:
            future.set_exception(error.with_traceback(None))

    def _check(self) -> Readiness:
        self.store.ping()
        check_directory(self.settings, self.store)
        checks = {"store": "writable", **_check_disk(self.settings)}
        checks |= _check_engine(self.engine, self.store.queue.head())
        return Readiness(status="ready", checks=checks)


def check_directory(settings: Settings, store: Store) -> None:
    """Raise ServiceNotReady if the data directory does not belong to the database."""
    try:
        identity.check(settings, store)
    except identity.WrongDirectory as error:
        raise ServiceNotReady(error.what) from None


def _check_disk(settings: Settings) -> dict[str, str]:
    """Whether results can be written; raises ServiceNotReady."""
    try:
        with tempfile.TemporaryFile(dir=settings.data) as probe:
            probe.write(b"ready?")
            probe.flush()
    except OSError as error:
        raise ServiceNotReady(f"the data directory is not writable: {error.strerror}") from None
    free = shutil.disk_usage(settings.data).free
    if free < settings.disk_reserve:
        raise ServiceNotReady(
            f"{free / 1e9:.1f} GB of disk space are free, below the reserve of "
            f"{settings.disk_reserve / 1e9:.1f} GB; delete sweeps, or make room"
        )
    return {"data": "writable", "disk": f"{free / 1e9:.1f} GB free"}


def _check_engine(engine: "Dispatcher", queue: QueueHead) -> dict[str, str]:
    """Whether the queue is worked through; raises ServiceNotReady."""
    if not engine.is_alive():
        raise ServiceNotReady("the dispatcher of this service has stopped")
    if queue.leader is None:
        raise ServiceNotReady("no service leads the queue yet")
    blocked_reason = engine.blocked_reason() or queue.blocked_reason
    if blocked_reason is not None:
        raise ServiceNotReady(blocked_reason)
    workers = engine.workers()
    if workers == 0:
        raise ServiceNotReady("there is no worker")
    return {"leader": "known", "workers": "of the leader" if workers is None else str(workers)}
