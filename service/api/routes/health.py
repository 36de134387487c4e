"""Liveness, readiness, version and metrics of the service."""

import asyncio
import platform
import shutil
import tempfile
import threading
import time
from collections.abc import Callable
from concurrent.futures import Future

import anyio
from fastapi import APIRouter, Request, Response

from service import version
from service.api.errors import ServiceNotReady
from service.api.metrics import CONTENT_TYPE
from service.api.routes.dependencies import AppSettings, AppStore, check_directory
from service.api.schemas import Health, Readiness, VersionModel
from service.queue.status import DispatcherStatus
from service.records.jobs import QueueRow, StoreUnavailable
from service.settings import Settings
from studies.runs.run import PHYSICS_VERSION

router = APIRouter(tags=["operations"])

# Seconds for which an outcome is reused: any client may ask, and each check takes the write lock.
REUSE_SECONDS = 1.0
# A store that takes longer is not ready; monitors rarely wait for 5 s.
TIMEOUT_SECONDS = 3.0


class ReadinessCheck:
    """Runs one check at a time in a thread, and shares its outcome among all who ask."""

    def __init__(self) -> None:
        self._mutex = threading.Lock()
        self._last: Future[Readiness] | None = None
        self._ended = 0.0  # monotonic

    def result(self, check: Callable[[], Readiness]) -> Readiness:
        """The outcome of ``check``, at most ``REUSE_SECONDS`` old; raises what it raised, and ServiceNotReady."""
        try:
            return self._begun(check).result(TIMEOUT_SECONDS)
        except TimeoutError:
            raise _late() from None

    async def awaited(self, check: Callable[[], Readiness]) -> Readiness:
        """The same, waited for without a thread."""
        try:
            with anyio.fail_after(TIMEOUT_SECONDS):
                return await asyncio.shield(asyncio.wrap_future(self._begun(check)))
        except TimeoutError:
            raise _late() from None

    def _begun(self, check: Callable[[], Readiness]) -> Future[Readiness]:
        """A check that goes on or has just ended.

        It may wait as long as the store does, in a thread that delays neither callers nor the exit.
        """

        def run(future: Future[Readiness]) -> None:
            try:
                readiness = check()
            except Exception as error:
                self._ended = time.monotonic()
                future.set_exception(error.with_traceback(None))
            else:
                self._ended = time.monotonic()
                future.set_result(readiness)

        with self._mutex:
            is_old = time.monotonic() - self._ended >= REUSE_SECONDS
            if self._last is None or (self._last.done() and is_old):
                self._last = Future()
                threading.Thread(target=run, args=(self._last,), daemon=True).start()
            return self._last


def _late() -> ServiceNotReady:
    return ServiceNotReady("the database has not responded yet")


@router.get("/livez")
async def show_liveness() -> Health:
    """The process responds."""
    return Health(status="alive")


@router.get("/readyz")
async def show_readiness(request: Request, store: AppStore, settings: AppSettings) -> Readiness:
    """The database and the data directory are writable, and the queue has a leader with workers."""
    readiness: ReadinessCheck = request.app.state.readiness
    return await readiness.awaited(lambda: _check(request, store, settings))


def _check(request: Request, store: AppStore, settings: AppSettings) -> Readiness:
    """What makes the service ready; raises ServiceNotReady, StoreUnavailable."""
    store.ping()
    check_directory(settings, store)
    checks = {"store": "writable", **_check_disk(settings)}
    checks |= _check_engine(request.app.state.engine, store.queue.status())
    return Readiness(status="ready", checks=checks)


def why_not_ready(request: Request, store: AppStore, settings: AppSettings) -> str | None:
    """The reason why `/readyz` says that the service cannot compute; None: it can."""
    try:
        request.app.state.readiness.result(lambda: _check(request, store, settings))
    except (ServiceNotReady, StoreUnavailable) as error:
        return str(error)
    return None


@router.get("/version")
def show_version() -> VersionModel:
    """Versions of the service, its physics and Python."""
    return VersionModel(version=version(), physics_version=PHYSICS_VERSION, python=platform.python_version())


metrics_router = APIRouter(tags=["operations"])


@metrics_router.get(
    "/metrics", response_class=Response, responses={200: {"content": {"text/plain": {"schema": {"type": "string"}}}}}
)
def show_metrics(request: Request) -> Response:
    """Metrics for Prometheus: runs by state, queue, attempts, requests."""
    return Response(request.app.state.metrics.text(), media_type=CONTENT_TYPE)


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


def _check_engine(engine: DispatcherStatus, queue: QueueRow) -> dict[str, str]:
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
