"""What is told in an event stream: of a sweep, of a run, of the whole queue.

Three kinds of messages, as an ``EventSource`` of a browser knows them:

* without a name: something that happened, an event of the store. ``id`` is its number, so that a
  listener that comes back with ``Last-Event-ID`` misses nothing and hears nothing twice.
* ``progress``: how far a running run is, at most once a second each; without an id, so that it changes
  nothing for who comes back.
* ``end``: the sweep or the run as it ended. The stream is over; who listens closes it.
"""

import time
from collections.abc import AsyncIterator, Callable, Iterator, Sequence, Set
from dataclasses import dataclass, field
from typing import Any

from anyio.to_thread import run_sync
from fastapi.sse import ServerSentEvent

from service.api.event_streams import Moment, Stream
from service.api.queue_schemas import EventModel, ProgressModel
from service.api.schemas import RunModel, SweepModel
from service.records.jobs import TERMINAL, Event, NotFound, StoreUnavailable
from service.store import Store

PAGE = 500  # events asked for at once
COME_BACK = 2000  # ms, after which a listener whose connection broke tries again
PROGRESS_SECONDS = 1.0  # at least so much between two pieces of progress of a run


@dataclass(frozen=True)
class Subject:
    """What a stream is about."""

    events: Callable[[int], Sequence[Event]]  # those after a number, oldest first, PAGE at most
    has: Callable[
        [Event, Set[str]], bool
    ]  # whether it is one of them; the sweeps that have its run
    concerns: Callable[[str, Sequence[str]], bool]  # a running run, and the sweeps that wait for it
    ends_with: Callable[[Event], bool]  # after such an event it is worth a look whether all is over
    ended: Callable[[], Any | None]  # what to say at the end, once it is there


def of_sweep(store: Store, id: str) -> Subject:
    """A sweep and its runs, until it has ended."""

    def ended() -> Any | None:
        try:
            row = store.sweep(id)
        except NotFound:
            return {"id": id, "state": "deleted"}
        return SweepModel.of(row) if row.is_terminal else None

    return Subject(
        events=lambda after: store.events(id, after=after, limit=PAGE),
        has=lambda event, sweeps: event.sweep_id == id or id in sweeps,
        concerns=lambda _run, sweeps: id in sweeps,
        ends_with=lambda event: event.sweep_id == id,
        ended=ended,
    )


def of_run(store: Store, id: str) -> Subject:
    """A run, until it has ended."""

    def ended() -> Any | None:
        row = store.run(id)
        return RunModel.of(row) if row.state in TERMINAL else None

    return Subject(
        events=lambda after: store.run_events(id, after=after, limit=PAGE),
        has=lambda event, _sweeps: event.job_id == id,
        concerns=lambda run, _sweeps: run == id,
        ends_with=lambda event: True,
        ended=ended,
    )


def of_queue(store: Store) -> Subject:
    """Everything, for as long as somebody listens."""
    return Subject(
        events=lambda after: store.all_events(after=after, limit=PAGE),
        has=lambda _event, _sweeps: True,
        concerns=lambda _run, _sweeps: True,
        ends_with=lambda event: False,
        ended=lambda: None,
    )


async def told(subject: Subject, stream: Stream, after: int) -> AsyncIterator[ServerSentEvent]:
    """Everything of a subject since an event, then what happens from now on, until it ends."""
    yield ServerSentEvent(retry=COME_BACK)
    pace, seen, look = FeedRate(), after, True
    while True:
        try:
            # What it ended with is asked for before the events, so that none of them is left out.
            final = await run_sync(subject.ended) if look else None
            events = await run_sync(subject.events, after)
            failed = look = False
        except StoreUnavailable:  # asked again at the next moment that can be told
            final, events, failed = None, (), True
        for event in events:
            after, look = event.number, look or subject.ends_with(event)
            yield ServerSentEvent(data=EventModel.of(event), id=str(event.number))
        if len(events) == PAGE:
            look = look or final is not None
            continue
        if final is not None:
            yield ServerSentEvent(data=final, event="end")
            return
        while failed or not look:
            moment = await stream.next()
            if moment is None:
                return
            for progress in pace.news(subject, moment):
                yield ServerSentEvent(data=progress, event="progress")
            if not failed and moment.last_event <= seen:
                continue
            news = None if failed else moment.after(max(seen, after))
            seen = moment.last_event
            if news is None:
                break
            for event in (event for event, sweeps in news if subject.has(event, sweeps)):
                after, look = event.number, look or subject.ends_with(event)
                yield ServerSentEvent(data=EventModel.of(event), id=str(event.number))


@dataclass
class FeedRate:
    """What was told of each running run, and when."""

    clock: Callable[[], float] = time.monotonic
    _told: dict[str, tuple[float, ProgressModel]] = field(default_factory=dict)

    def news(self, subject: Subject, moment: Moment) -> Iterator[ProgressModel]:
        """What is new about the runs of a subject, of each at most once a second."""
        now = self.clock()
        rows = [run for run, sweeps in moment.under_way if subject.concerns(run.id, sweeps)]
        self._told = {run.id: self._told[run.id] for run in rows if run.id in self._told}
        for run in rows:
            when, last = self._told.get(run.id, (-PROGRESS_SECONDS, None))
            progress = ProgressModel.of(run)
            if progress is not None and progress != last and now - when >= PROGRESS_SECONDS:
                self._told[run.id] = (now, progress)
                yield progress
