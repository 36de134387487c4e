"""Server-sent events of a sweep, a run or the whole queue, and the thread that reads the store for all streams.

Three kinds of messages, as an ``EventSource`` of a browser knows them:

* without a name: an event of the store. ``id`` is its number, so that a client that reconnects with
  ``Last-Event-ID`` misses none and receives none twice.
* ``progress``: the progress of a running run, at most once a second each; without an id, so that it
  leaves the position of the client as it is.
* ``end``: the sweep or the run in its final state. The stream is over.

One thread asks the store twice a second, however many streams are open, whether there are new events; a stream
then reads its own. Without a stream there is no thread.
"""

import asyncio
import logging
import math
import threading
import time
from collections.abc import AsyncIterator, Callable, Mapping, Sequence
from contextlib import asynccontextmanager, suppress
from dataclasses import dataclass

from anyio.to_thread import run_sync
from fastapi.sse import ServerSentEvent
from pydantic_core import to_jsonable_python

from service.api.errors import Busy, TooManyRequests, Unauthorized
from service.api.schemas import ProgressModel, RunModel, SweepModel
from service.records.jobs import Event, RunRow, StoreUnavailable
from service.store import Store

log = logging.getLogger(__name__)

MOST_STREAMS = 100  # open at once; each holds a connection
MOST_OF_A_KEY = 40  # of them; so that no two keys leave none for a third
TICK_SECONDS = 0.5  # interval between two readings of the store
PROGRESS_SECONDS = 1.0  # interval between two readings of the progress of runs
CHECK_SECONDS = 15.0  # interval between two looks at the key of a stream
PAGE = 500  # events read at once
RECONNECT_MILLISECONDS = 2000  # after which a client whose connection broke tries again


# --- one thread for all streams -------------------------------------------------------------------


@dataclass(frozen=True)
class QueueSnapshot:
    """The store at one moment."""

    last_event: int
    # Running runs, each with the ids of its sweeps; None: not read this time.
    running: Sequence[tuple[RunRow, Sequence[str]]] | None


class Listener:
    """An open stream; it holds the latest snapshot only, so a slow client costs no memory.

    ``check`` raises Unauthorized once the client may not read any more, which is asked at an interval (s).
    """

    def __init__(self, check: Callable[[], object], interval: float) -> None:
        self._check, self._interval = check, interval
        self._checked = time.monotonic()
        self._loop = asyncio.get_running_loop()
        self._is_ready = asyncio.Event()
        self._latest: QueueSnapshot | None = None

    async def next(self) -> QueueSnapshot | None:
        """The next snapshot; None ends the stream."""
        await self._is_ready.wait()
        self._is_ready.clear()
        if time.monotonic() - self._checked >= self._interval:
            try:
                await run_sync(self._check)
            except Unauthorized:
                return None
            except StoreUnavailable:  # asked again with the next snapshot
                return self._latest
            self._checked = time.monotonic()
        return self._latest

    def post(self, snapshot: QueueSnapshot | None) -> None:
        """Hand over a snapshot, or None for the end; called in any thread."""
        # A closed loop: the client is gone, and its stream is about to be discarded.
        with suppress(RuntimeError):
            self._loop.call_soon_threadsafe(self._set, snapshot)

    def _set(self, snapshot: QueueSnapshot | None) -> None:
        self._latest = snapshot
        self._is_ready.set()


class EventStreams:
    """All open streams of the service."""

    def __init__(self, store: Store, *, most_of_a_key: int = MOST_OF_A_KEY):
        self._store, self._check_interval = store, CHECK_SECONDS
        self._most, self._most_of_a_key = MOST_STREAMS, most_of_a_key
        self._listeners: dict[Listener, str] = {}  # with the name of its key
        self._changed = threading.Condition()  # guards the listeners
        self._thread: threading.Thread | None = None
        self._is_closed = False

    @property
    def open(self) -> int:
        """The number of open streams."""
        return len(self._listeners)

    @asynccontextmanager
    async def listening(self, key: str = "", check: Callable[[], object] = lambda: None) -> AsyncIterator[Listener]:
        """A listener for the duration of a block; raises Busy if too many are open, TooManyRequests if of this key."""
        listener = Listener(check, self._check_interval)
        with self._changed:
            if self._is_closed:
                raise Busy("the service is stopping")
            if len(self._listeners) >= self._most:
                raise Busy(f"{self._most} event streams are open, which is the limit; close one, or poll the state")
            if [*self._listeners.values()].count(key) >= self._most_of_a_key:
                raise TooManyRequests(
                    f"{self._most_of_a_key} event streams of this key are open, which is the limit; close one, or "
                    "poll the state"
                )
            self._listeners[listener] = key
            if self._thread is None:
                self._thread = threading.Thread(target=self._run, name="event-streams", daemon=True)
                self._thread.start()
        try:
            yield listener
        finally:
            with self._changed:
                del self._listeners[listener]
                self._changed.notify_all()

    def close(self) -> None:
        """End every stream, and open no more."""
        with self._changed:
            self._is_closed = True
            for listener in self._listeners:
                listener.post(None)
            self._changed.notify_all()

    def _run(self) -> None:
        """Read the store and post what changed until the last stream closes."""
        progress_read = -math.inf
        while True:
            is_due = time.monotonic() - progress_read >= PROGRESS_SECONDS
            snapshot = self._read(with_progress=is_due)
            progress_read = time.monotonic() if is_due else progress_read
            with self._changed:
                if snapshot is not None and not self._is_closed:
                    for listener in self._listeners:
                        listener.post(snapshot)
                self._changed.wait_for(self._is_over, TICK_SECONDS)
                if self._is_over():
                    self._thread = None
                    return

    def _is_over(self) -> bool:
        return self._is_closed or not self._listeners

    def _read(self, *, with_progress: bool) -> QueueSnapshot | None:
        try:
            last = self._store.events.last()
            return QueueSnapshot(last, self._store.runs.under_way() if with_progress else None)
        except StoreUnavailable as error:  # streams stay open, and continue when it is back
            log.warning("%s", error)
        except Exception:
            log.exception("the events for the open streams could not be read")
        return None


# --- the messages of one stream -------------------------------------------------------------------


@dataclass(frozen=True)
class EventSubject:
    """The subject of a stream: a sweep, a run or the queue."""

    events: Callable[[int, int], Sequence[Event]]  # those after a number, oldest first, so many at most
    includes: Callable[[str, Sequence[str]], bool]  # a running run, by its id and those of its sweeps
    # Content of the message ``end``; None before the end.
    final: Callable[[], SweepModel | RunModel | Mapping[str, str] | None]


async def stream(subject: EventSubject, listener: Listener, after: int) -> AsyncIterator[ServerSentEvent]:
    """All events of a subject after a number, then new ones as they happen, until it ends."""
    yield ServerSentEvent(retry=RECONNECT_MILLISECONDS)
    read_up_to = 0
    reported: dict[str, ProgressModel] = {}
    while True:
        try:
            # Read before the events, so that the message ``end`` follows all of them.
            final = await run_sync(subject.final)
            events = await run_sync(subject.events, after, PAGE)
            has_failed = False
        except StoreUnavailable:  # repeated at the next snapshot
            final, events, has_failed = None, (), True
        for event in events:
            after = event.number
            yield ServerSentEvent(data=to_jsonable_python(event), id=str(after))
        if len(events) == PAGE:
            continue
        if final is not None:
            yield ServerSentEvent(data=to_jsonable_python(final), event="end")
            return
        is_current = True
        while is_current:
            snapshot = await listener.next()
            if snapshot is None:
                return
            for progress in _new_progress(subject, snapshot, reported):
                yield ServerSentEvent(data=progress, event="progress")
            is_current = not has_failed and snapshot.last_event <= read_up_to
            read_up_to = snapshot.last_event


def _new_progress(
    subject: EventSubject, snapshot: QueueSnapshot, reported: dict[str, ProgressModel]
) -> list[ProgressModel]:
    """The progress of the subject's running runs that differs from what was ``reported``, which is updated."""
    if snapshot.running is None:
        return []
    running = [run for run, sweeps in snapshot.running if subject.includes(run.id, sweeps)]
    current = {run.id: progress for run in running if (progress := ProgressModel.of(run))}
    new = [progress for id, progress in current.items() if reported.get(id) != progress]
    reported.clear()
    reported.update(current)
    return new
