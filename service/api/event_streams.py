"""What happens, told as it happens: the open event streams, and one thread that looks for all of them.

The store is asked a few times a tick, however many streams there are: new events are read once, and each
stream takes its own. One that was away meanwhile asks for what it missed. Without a stream there is no
thread.
"""

import asyncio
import logging
import threading
from collections.abc import AsyncIterator, Sequence, Set
from contextlib import asynccontextmanager, suppress
from dataclasses import dataclass

from service.api.errors import Busy
from service.records.jobs import Event, RunRow, StoreUnavailable
from service.store import Store

log = logging.getLogger(__name__)

MOST_STREAMS = 100  # open at once; each holds a connection
TICK = 0.5  # s, between two looks
MOST_NEWS = 1000  # events of one look; of more each stream asks for its own


@dataclass(frozen=True)
class Moment:
    """What one look saw."""

    last_event: int
    under_way: Sequence[tuple[RunRow, Sequence[str]]]  # running runs, each with its sweeps
    since: int = 0  # the last event before ``news``
    news: Sequence[tuple[Event, Set[str]]] | None = None  # each with the sweeps that have its run

    def after(self, number: int) -> Sequence[tuple[Event, Set[str]]] | None:
        """The news behind an event; None: the store knows more."""
        if self.news is None or number < self.since:
            return None
        return [(event, sweeps) for event, sweeps in self.news if event.number > number]


class Stream:
    """Somebody who listens; holds the last moment alone, so a slow listener costs nothing more."""

    def __init__(self) -> None:
        self._loop = asyncio.get_running_loop()
        self._news = asyncio.Event()
        self._moment: Moment | None = None
        self._closed = False

    async def next(self) -> Moment | None:
        """The next moment that this listener has not seen; None: there will be no more."""
        await self._news.wait()
        self._news.clear()
        return None if self._closed else self._moment

    def tell(self, moment: Moment) -> None:
        """Called in the loop of the listener."""
        self._moment = moment
        self._news.set()

    def close(self) -> None:
        """Called in the loop of the listener."""
        self._closed = True
        self._news.set()

    def post(self, moment: Moment | None) -> None:
        """Called in any thread: a moment, or None for the end."""
        with suppress(
            RuntimeError
        ):  # the loop is closed: the listener is gone, and has not said so yet
            if moment is None:
                self._loop.call_soon_threadsafe(self.close)
            else:
                self._loop.call_soon_threadsafe(self.tell, moment)


class Live:
    """All open streams."""

    def __init__(self, store: Store):
        self._store = store
        self._most = MOST_STREAMS
        self._streams: set[Stream] = set()
        self._changed = threading.Condition()  # guards the streams
        self._thread: threading.Thread | None = None
        self._closed = False

    @property
    def open(self) -> int:
        """How many streams are open."""
        return len(self._streams)

    @asynccontextmanager
    async def listening(self) -> AsyncIterator[Stream]:
        """A stream for the time of a block; raises Busy when there are as many as are allowed."""
        stream = Stream()
        with self._changed:
            if self._closed:
                raise Busy("the service is about to leave")
            if len(self._streams) >= self._most:
                raise Busy(
                    f"{self._most} event streams are open, and no more are allowed; close one, or "
                    "ask for the state now and then"
                )
            self._streams.add(stream)
            if self._thread is None:
                self._thread = threading.Thread(target=self._run, name="live", daemon=True)
                self._thread.start()
        try:
            yield stream
        finally:
            with self._changed:
                self._streams.discard(stream)
                self._changed.notify_all()

    def close(self) -> None:
        """End every stream; there will be no other."""
        with self._changed:
            self._closed = True
            for stream in self._streams:
                stream.post(None)
            self._changed.notify_all()

    def _run(self) -> None:
        """Look and tell until nobody listens."""
        seen: int | None = None
        while True:
            moment = self._look(seen)
            seen = seen if moment is None else moment.last_event
            with self._changed:
                if moment is not None and not self._closed:
                    for stream in self._streams:
                        stream.post(moment)
                self._changed.wait_for(self._is_over, TICK)
                if self._is_over():
                    self._thread = None
                    return

    def _is_over(self) -> bool:
        return self._closed or not self._streams

    def _look(self, seen: int | None) -> Moment | None:
        """What there is now; ``seen``: the last event of the look before."""
        try:
            last = self._store.last_event()
            if seen is None or last <= seen:
                return Moment(last, self._store.under_way(), since=last, news=())
            news = self._store.events_with_sweeps(after=seen, limit=MOST_NEWS)
            if len(news) == MOST_NEWS:
                return Moment(last, self._store.under_way())
            last = news[-1][0].number
            return Moment(last, self._store.under_way(), since=seen, news=news)
        except StoreUnavailable as error:  # the streams stay, and hear of it when it is back
            log.warning("%s", error)
        except Exception:
            log.exception("the event streams could not be told")
        return None
