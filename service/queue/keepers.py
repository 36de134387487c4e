"""What keeps registered files beside the leader's own work: objects of a bucket, comparison with digests.

To add one: a class like ``Keeper``, and a line of the entry-point group ``whipple.service.queue.keepers``.
"""

import logging
from concurrent.futures import Future, ThreadPoolExecutor
from typing import Protocol

from service.files.artifacts import Artifacts
from service.files.stores import FilesAway
from service.queue.clock_watch import ClockWatch
from service.queue.data_identity import WrongDirectory
from service.records.jobs import StoreUnavailable
from service.settings import Settings
from service.store import Store
from service.workers.timings import Timings
from solver.registry import points

log = logging.getLogger(__name__)


class Keeper(Protocol):
    """Does bounded parts of a work that has no end."""

    def __init__(self, settings: Settings, store: Store, artifacts: Artifacts, clock: ClockWatch, timings: Timings): ...

    def step(self) -> None:
        """Do a bounded part of the work; called by the leader at some of its ticks."""


class KeptInThread:
    """The steps of a keeper, in a thread beside the ticks; what fails is done at a later one."""

    def __init__(self, keeper: Keeper):
        self._keeper = keeper
        self._thread = ThreadPoolExecutor(1, thread_name_prefix="keeper")
        self._running: Future[None] | None = None

    def step(self) -> None:
        """Begin a step, unless one is under way."""
        if self._running is None or self._running.done():
            self._running = self._thread.submit(self._step)

    def _step(self) -> None:
        try:
            self._keeper.step()
        except (FilesAway, StoreUnavailable, WrongDirectory) as error:
            log.warning("%s", error)
        except Exception:
            log.exception("stored files could not be kept")


def keepers_of(
    settings: Settings, store: Store, artifacts: Artifacts, clock: ClockWatch, timings: Timings
) -> list[Keeper | KeptInThread]:
    """Those of features; with a bucket, which may be slow or away, each in a thread."""
    makers: list[type[Keeper]] = [point.load() for point in points("service.queue.keepers")]
    keepers = [make(settings, store, artifacts, clock, timings) for make in makers]
    return [*keepers] if artifacts.bucket is None else [*map(KeptInThread, keepers)]
