"""Is it alive, is it ready, what is it, how much does it do."""

import platform
import shutil
import tempfile
import threading
import time
from collections.abc import Callable, Iterator
from concurrent.futures import Future
from dataclasses import dataclass

from fastapi import APIRouter, Request, Response

from service.api.errors import ServiceNotReady
from service.api.metrics import CONTENT_TYPE
from service.api.routes.given import SettingsGiven, StoreGiven, check_directory
from service.api.schemas import Health, Readiness, VersionModel
from service.queue.status import DispatcherStatus
from service.records.jobs import QueueRow
from service.records.settings import Settings
from service.records.version import version
from studies.runs.run import PHYSICS_VERSION

router = APIRouter(tags=["service"])

# An answer holds for so long: anybody may ask, and each look takes the write lock.
LOOK_SECONDS = 1.0
PATIENCE_SECONDS = (
    3.0  # a store that takes longer is not ready; whoever asks for health rarely waits for 5
)


class Lookout:
    """One look at a time, and what the last one found."""

    def __init__(self) -> None:
        self._mutex = threading.Lock()
        self._last: Future[_Found] | None = None

    def answer(self, look: Callable[[], Readiness]) -> Readiness:
        """What ``look`` finds, or found just now; raises what it raised, and ServiceNotReady while it lasts."""
        with self._mutex:
            if self._last is None or _is_old(self._last):
                self._last = Future()
                # Waits for a store as long as the store lets it, and holds up no end of the service.
                threading.Thread(target=_look, args=(look, self._last), daemon=True).start()
            last = self._last
        try:
            found = last.result(PATIENCE_SECONDS).what
        except TimeoutError:
            raise ServiceNotReady("the store has not answered yet") from None
        if isinstance(found, Exception):
            raise found.with_traceback(None)
        return found


@dataclass(frozen=True)
class _Found:
    what: Readiness | Exception  # an error holds as long as an answer
    moment: float  # monotonic


def _is_old(look: "Future[_Found]") -> bool:
    return look.done() and time.monotonic() - look.result().moment >= LOOK_SECONDS


def _look(look: Callable[[], Readiness], answer: "Future[_Found]") -> None:
    what: Readiness | Exception
    try:
        what = look()
    except Exception as error:
        what = error
    answer.set_result(_Found(what, time.monotonic()))


@router.get("/livez")
async def show_life() -> Health:
    """The process answers."""
    return Health(status="alive")


@router.get("/readyz")
def show_readiness(request: Request, store: StoreGiven, settings: SettingsGiven) -> Readiness:
    """The store and the data directory can be written to, and somebody computes what is in the queue."""

    def look() -> Readiness:
        store.ping()
        check_directory(settings, store)
        checks = {"store": "can be written to", **dict(_disk(settings))}
        checks |= dict(_engine(request.app.state.engine, store.queue()))
        return Readiness(status="ready", checks=checks)

    return request.app.state.lookout.answer(look)


@router.get("/version")
def show_version() -> VersionModel:
    """What is running here."""
    return VersionModel(
        version=version(), physics_version=PHYSICS_VERSION, python=platform.python_version()
    )


metrics_router = APIRouter(tags=["service"])


@metrics_router.get(
    "/metrics",
    response_class=Response,
    responses={200: {"content": {"text/plain": {"schema": {"type": "string"}}}}},
)
def show_metrics(request: Request) -> Response:
    """Counts and times for a monitor (Prometheus): runs by state, queue, attempts, requests."""
    return Response(request.app.state.metrics.text(), media_type=CONTENT_TYPE)


def _disk(settings: Settings) -> Iterator[tuple[str, str]]:
    """Whether results can be written; raises ServiceNotReady."""
    try:
        with tempfile.TemporaryFile(dir=settings.data) as probe:
            probe.write(b"ready?")
            probe.flush()
    except OSError as error:
        raise ServiceNotReady(
            f"the data directory cannot be written to: {error.strerror}"
        ) from None
    yield "data", "can be written to"
    free = shutil.disk_usage(settings.data).free
    if free < settings.disk_reserve:
        raise ServiceNotReady(
            f"{_gigabytes(free)} of disk are free, and {_gigabytes(settings.disk_reserve)} are kept in "
            "reserve; delete sweeps, or make room"
        )
    yield "disk", f"{_gigabytes(free)} free"


def _engine(engine: DispatcherStatus, queue: QueueRow) -> Iterator[tuple[str, str]]:
    """Whether somebody computes; raises ServiceNotReady."""
    if not engine.is_alive():
        raise ServiceNotReady("nobody computes what is in the queue")
    if queue.leader is None:
        raise ServiceNotReady("nobody gives out what is in the queue yet")
    yield "leader", "known"
    trouble = engine.blocked_reason() or queue.blocked_reason
    if trouble is not None:
        raise ServiceNotReady(trouble)
    workers = engine.workers()
    if workers == 0:
        raise ServiceNotReady("there is no worker")
    yield "workers", "of the leader" if workers is None else str(workers)


def _gigabytes(size: int) -> str:
    return f"{size / 1e9:.1f} GB"
