"""What happens, as it happens: server-sent events; and what has happened, as pages."""

from collections.abc import AsyncIterable, AsyncIterator
from typing import Annotated

from fastapi import APIRouter, Depends, Header, Query, Request, Response
from fastapi.sse import EventSourceResponse, ServerSentEvent

from service.api import feeds
from service.api.event_streams import Stream
from service.api.feeds import Subject, told
from service.api.queue_schemas import EventModel, EventPage
from service.api.routes.given import Cursor, Limit, LiveGiven, RunId, StoreGiven, SweepId
from service.api.routes.pagination import link_next
from service.records.jobs import Event
from studies.values.errors import Finding, InvalidInput
from studies.values.nearest import shown

router = APIRouter(prefix="/v1", tags=["events"])

LONGEST_NUMBER = 18  # digits
HOW = (
    " Each message that has an `id` is an event; `Last-Event-ID` goes on behind one, and one that "
    "is not known any more (the service was restored from a backup) is as none. Messages named "
    "`progress` say how far running runs are, at most once a second each. {end}"
)
ENDS = "The message named `end` is the last: close the stream, or it begins again."


def the_place(
    store: StoreGiven,
    last_event_id: Annotated[
        str | None, Header(description="`id` of the last event that was seen")
    ] = None,
    after: Annotated[str | None, Query(description="the same, for a first request")] = None,
) -> int | None:
    """The event behind which a stream begins; None: nothing is said that the store knows.

    It does not know one beyond its last: it was restored from a backup since.
    """
    given = last_event_id or after
    if not given:
        return None
    number = _number(given)
    return number if number <= store.last_event() else None


def _number(given: str) -> int:
    if not given.isascii() or not given.isdigit() or len(given) > LONGEST_NUMBER:
        limit = "the `id` of an event"
        raise InvalidInput([Finding("Last-Event-ID", shown(given), limit, "leave it out to begin")])
    return int(given)


async def the_stream(live: LiveGiven) -> AsyncIterator[Stream]:
    """A place among the listeners, for as long as the answer lasts."""
    async with live.listening() as stream:
        yield stream


def the_sweep(id: SweepId, store: StoreGiven) -> Subject:
    """The events of a sweep that is there."""
    store.sweep_document(id)
    return feeds.of_sweep(store, id)


def the_run(id: RunId, store: StoreGiven) -> Subject:
    """The events of a run that is there."""
    store.run(id)
    return feeds.of_run(store, id)


Place = Annotated[int | None, Depends(the_place)]


def the_place_or_now(place: Place, store: StoreGiven) -> int:
    """The event behind which a stream begins, else the last there is."""
    return store.last_event() if place is None else place


StreamGiven = Annotated[Stream, Depends(the_stream)]


@router.get(
    "/sweeps/{id}/events",
    response_class=EventSourceResponse,
    description="What happened to a sweep and its runs, from its begin, then what happens."
    + HOW.format(end=ENDS),
)
async def follow_sweep(
    about: Annotated[Subject, Depends(the_sweep)], place: Place, stream: StreamGiven
) -> AsyncIterable[ServerSentEvent]:
    async for message in told(about, stream, place or 0):
        yield message


@router.get(
    "/runs/{id}/events",
    response_class=EventSourceResponse,
    description="What happened to a run, from its begin, then what happens." + HOW.format(end=ENDS),
)
async def follow_run(
    about: Annotated[Subject, Depends(the_run)], place: Place, stream: StreamGiven
) -> AsyncIterable[ServerSentEvent]:
    async for message in told(about, stream, place or 0):
        yield message


@router.get(
    "/queue/events",
    response_class=EventSourceResponse,
    description="What happens to all sweeps and runs from now on, or behind `Last-Event-ID`."
    + HOW.format(end="It does not end."),
)
async def follow_queue(
    store: StoreGiven, begin: Annotated[int, Depends(the_place_or_now)], stream: StreamGiven
) -> AsyncIterable[ServerSentEvent]:
    async for message in told(feeds.of_queue(store), stream, begin):
        yield message


@router.get("/sweeps/{id}/history")
def list_sweep_events(
    id: SweepId,
    store: StoreGiven,
    request: Request,
    response: Response,
    cursor: Cursor = None,
    limit: Limit = 100,
) -> EventPage:
    """What happened to a sweep and its runs, the oldest first."""
    store.sweep_document(id)
    events = store.events(id, after=_number(cursor or "0"), limit=limit + 1)
    return _page(request, response, events, limit)


@router.get("/runs/{id}/history")
def list_run_events(
    id: RunId,
    store: StoreGiven,
    request: Request,
    response: Response,
    cursor: Cursor = None,
    limit: Limit = 100,
) -> EventPage:
    """What happened to a run, the oldest first."""
    store.run(id)
    events = store.run_events(id, after=_number(cursor or "0"), limit=limit + 1)
    return _page(request, response, events, limit)


def _page(request: Request, response: Response, events: tuple[Event, ...], limit: int) -> EventPage:
    """The first ``limit`` of the events, and the way to the rest."""
    cursor = str(events[limit - 1].number) if len(events) > limit else None
    link_next(request, response, cursor)
    return EventPage(items=[EventModel.of(one) for one in events[:limit]], next_cursor=cursor)
