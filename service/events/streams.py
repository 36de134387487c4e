"""Server-sent events of a sweep, a run or the whole queue.

Three kinds of messages, as an ``EventSource`` of a browser knows them:

* without a name: an event of the store. ``id`` is its number, so that a client that reconnects with
  ``Last-Event-ID`` misses none and receives none twice.
* ``progress``: the progress of a running run, at most once a second each; without an id, so that it
  leaves the position of the client as it is.
* ``end``: the sweep or the run in its final state. The stream is over.

Each stream looks twice a second whether there are new events, and then reads its own; the store is asked once for all.
"""

import math
import time
from collections import Counter
from collections.abc import AsyncIterator, Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass

import anyio
from anyio.to_thread import run_sync
from fastapi.sse import ServerSentEvent
from pydantic_core import to_jsonable_python

from service.api.errors import Busy, TooManyRequests, Unauthorized
from service.api.schemas import ProgressModel, RunModel, SweepModel
from service.records.jobs import Event, RunRow, StoreUnavailable
from service.store import Store

MOST_STREAMS = 100  # open at once; each holds a connection
MOST_OF_A_KEY = 40  # of them; so that no two keys leave none for a third
TICK_SECONDS = 0.5  # interval between two readings of the store
PROGRESS_SECONDS = 1.0  # interval between two readings of the progress of runs
CHECK_SECONDS = 15.0  # interval between two looks at the key of a stream
PAGE = 500  # events read at once
RECONNECT_MILLISECONDS = 2000  # after which a client whose connection broke tries again


@dataclass(frozen=True)
class QueueSnapshot:
    """The store at one moment."""

    last_event: int
    running: Sequence[tuple[RunRow, Sequence[str]]]  # running runs, each with the ids of its sweeps


class EventStreams:
    """All open streams of the service, and what they see of the store."""

    def __init__(self, store: Store, opened: Counter[str] | None = None, *, most_of_a_key: int = MOST_OF_A_KEY):
        """``opened`` counts the open streams of each key."""
        self._store, self.check_interval = store, CHECK_SECONDS
        self._most, self._most_of_a_key = MOST_STREAMS, most_of_a_key
        self.opened = Counter[str]() if opened is None else opened
        self.is_closed = False
        self._reading = anyio.Lock()
        self._snapshot = QueueSnapshot(0, ())
        self._read = self._read_progress = -math.inf  # monotonic

    @contextmanager
    def listening(self, key: str = "") -> Iterator[None]:
        """A stream for the duration of a block; raises Busy if too many are open, TooManyRequests if of this key."""
        if self.is_closed:
            raise Busy("the service is stopping")
        if self.opened.total() >= self._most:
            raise Busy(f"{self._most} event streams are open, which is the limit; close one, or poll the state")
        if self.opened[key] >= self._most_of_a_key:
            raise TooManyRequests(
                f"{self._most_of_a_key} event streams of this key are open, which is the limit; close one, or "
                "poll the state"
            )
        self.opened[key] += 1
        try:
            yield
        finally:
            self.opened[key] -= 1

    def close(self) -> None:
        """End every stream within a tick, and open no more."""
        self.is_closed = True

    async def latest(self) -> QueueSnapshot:
        """The store as it was read a tick ago at most; raises StoreUnavailable."""
        async with self._reading:
            if time.monotonic() - self._read >= TICK_SECONDS:
                self._snapshot = await run_sync(self._look)
                self._read = time.monotonic()
            return self._snapshot

    def _look(self) -> QueueSnapshot:
        last, running = self._store.events.last(), self._snapshot.running
        if time.monotonic() - self._read_progress >= PROGRESS_SECONDS:
            running, self._read_progress = self._store.runs.under_way(), time.monotonic()
        return QueueSnapshot(last, running)


# --- the messages of one stream -------------------------------------------------------------------


@dataclass(frozen=True)
class EventSubject:
    """The subject of a stream: a sweep, a run or the queue."""

    events: Callable[[int, int], Sequence[Event]]  # those after a number, oldest first, so many at most
    includes: Callable[[str, Sequence[str]], bool]  # a running run, by its id and those of its sweeps
    # Content of the message ``end``; None before the end.
    final: Callable[[], SweepModel | RunModel | Mapping[str, str] | None]


Stream = Callable[..., AsyncIterator[ServerSentEvent]]  # ``stream`` of a subject after an event, of open streams


async def stream(
    subject: EventSubject, *, after: int, streams: EventStreams, check: Callable[[], object]
) -> AsyncIterator[ServerSentEvent]:
    """All events of a subject after a number, then new ones as they happen, until it ends.

    ``check`` raises Unauthorized once the client may not read any more, which is asked at an interval.
    """
    yield ServerSentEvent(retry=RECONNECT_MILLISECONDS)
    read_up_to, checked = -1, time.monotonic()
    reported: dict[str, ProgressModel] = {}
    while not streams.is_closed:
        final: SweepModel | RunModel | Mapping[str, str] | None = None
        events: Sequence[Event] = ()
        try:
            snapshot = await streams.latest()
            if time.monotonic() - checked >= streams.check_interval:
                await run_sync(check)
                checked = time.monotonic()
            if snapshot.last_event > read_up_to:
                # Read before the events, so that the message ``end`` follows all of them.
                final = await run_sync(subject.final)
                events = await run_sync(subject.events, after, PAGE)
                read_up_to = snapshot.last_event if len(events) < PAGE else read_up_to
        except Unauthorized:
            return
        except StoreUnavailable:  # asked again a tick later
            await anyio.sleep(TICK_SECONDS)
            continue
        for event in events:
            after = event.number
            yield ServerSentEvent(data=to_jsonable_python(event), id=str(after))
        if len(events) == PAGE:
            continue
        if final is not None:
            yield ServerSentEvent(data=to_jsonable_python(final), event="end")
            return
        for progress in _new_progress(subject, snapshot, reported):
            yield ServerSentEvent(data=progress, event="progress")
        await anyio.sleep(TICK_SECONDS)


def _new_progress(
    subject: EventSubject, snapshot: QueueSnapshot, reported: dict[str, ProgressModel]
) -> list[ProgressModel]:
    """The progress of the subject's running runs that differs from what was ``reported``, which is updated."""
    running = [run for run, sweeps in snapshot.running if subject.includes(run.id, sweeps)]
    current = {run.id: progress for run in running if (progress := ProgressModel.of(run))}
    new = [progress for id, progress in current.items() if reported.get(id) != progress]
    reported.clear()
    reported.update(current)
    return new
