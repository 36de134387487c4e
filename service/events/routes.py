"""Events as they happen (server-sent events), and past events as pages."""

from collections.abc import AsyncIterable, AsyncIterator, Mapping
from functools import partial
from typing import Annotated

from fastapi import APIRouter, Depends, FastAPI, Header, Query, Request, Response
from fastapi.sse import EventSourceResponse, ServerSentEvent

from service.api.access import Credentials, authenticate
from service.api.dependencies import AppStore, Cursor, PageLimit, RunId, SweepId, link_next
from service.api.routes import Routes
from service.api.schemas import EventModel, PageOf, RunModel, SweepModel
from service.events.streams import EventStreams, EventSubject, Stream, stream
from service.records.jobs import TERMINAL, Event, NotFound
from studies.quantities.findings import Finding, InvalidInput, shown

router = APIRouter(prefix="/v1")


def _prepare(service: FastAPI) -> None:
    """Let a service have streams, which end before its connections are closed."""
    state = service.state
    state.event_streams = EventStreams(state.store, state.open_streams)
    state.at_end.append(state.event_streams.close)


ROUTES = Routes("events", 50, guarded=(router,), prepare=_prepare)

LONGEST_NUMBER = 18  # digits
MESSAGES = (
    " Each message with an `id` is an event; send the last one as `Last-Event-ID` to continue after it. "
    "An id that the service does not know (the database was restored from a backup) is ignored. "
    "Messages named `progress` report running runs, at most once a second each. {end}"
)
ENDS = "The message named `end` is the last: close the stream then, or the browser reconnects."


def _last_event(
    store: AppStore,
    last_event_id: Annotated[str | None, Header(description="`id` of the last event received")] = None,
    after: Annotated[str | None, Query(description="`id` of the last event received, for the first request")] = None,
) -> int | None:
    """The event after which a stream begins; None if none is given that the store knows."""
    text = last_event_id or after
    if not text:
        return None
    number = _number(text)
    return number if number <= store.events.last() else None


def _number(text: str) -> int:
    if not text.isascii() or not text.isdigit() or len(text) > LONGEST_NUMBER:
        limit = "the `id` of an event"
        raise InvalidInput([Finding("Last-Event-ID", shown(text), limit, "omit it to start at the beginning")])
    return int(text)


async def _opened(request: Request, credentials: Credentials) -> AsyncIterator[Stream]:
    """What happens to a subject after an event, for the duration of the response, as long as its key is valid."""
    streams: EventStreams = request.app.state.event_streams
    with streams.listening(request.state.caller.name):
        yield partial(stream, streams=streams, check=partial(authenticate, request, credentials))


def _sweep(id: SweepId, store: AppStore) -> EventSubject:
    """A sweep and its runs, until it has ended; raises NotFound."""
    store.sweeps.document(id)

    def final() -> SweepModel | Mapping[str, str] | None:
        try:
            row = store.sweeps.get(id)
        except NotFound:
            return {"id": id, "state": "deleted"}
        return SweepModel.of(row) if row.is_terminal else None

    return EventSubject(
        events=lambda after, limit: store.events.of_sweep(id, after=after, limit=limit),
        includes=lambda _run, sweeps: id in sweeps,
        final=final,
    )


def _run(id: RunId, store: AppStore) -> EventSubject:
    """A run, until it has ended; raises NotFound."""
    store.runs.get(id)

    def final() -> RunModel | None:
        row = store.runs.get(id)
        return RunModel.of(row) if row.state in TERMINAL else None

    return EventSubject(
        events=lambda after, limit: store.events.of_run(id, after=after, limit=limit),
        includes=lambda run, _sweeps: run == id,
        final=final,
    )


def _queue(store: AppStore) -> EventSubject:
    """All sweeps and runs, for as long as the client is connected."""
    return EventSubject(
        events=lambda after, limit: store.events.all(after=after, limit=limit),
        includes=lambda _run, _sweeps: True,
        final=lambda: None,
    )


LastEvent = Annotated[int | None, Depends(_last_event)]
Opened = Annotated[Stream, Depends(_opened)]


def _last_event_or_newest(last_event: LastEvent, store: AppStore) -> int:
    return store.events.last() if last_event is None else last_event


@router.get(
    "/sweeps/{id}/events",
    tags=["watch"],
    response_class=EventSourceResponse,
    description="All events of a sweep and its runs: past ones first, then as they happen." + MESSAGES.format(end=ENDS),
)
async def follow_sweep(
    subject: Annotated[EventSubject, Depends(_sweep)], last_event: LastEvent, opened: Opened
) -> AsyncIterable[ServerSentEvent]:
    async for message in opened(subject, after=last_event or 0):
        yield message


@router.get(
    "/runs/{id}/events",
    tags=["runs"],
    response_class=EventSourceResponse,
    description="All events of a run: past ones first, then as they happen." + MESSAGES.format(end=ENDS),
)
async def follow_run(
    subject: Annotated[EventSubject, Depends(_run)], last_event: LastEvent, opened: Opened
) -> AsyncIterable[ServerSentEvent]:
    async for message in opened(subject, after=last_event or 0):
        yield message


@router.get(
    "/queue/events",
    tags=["operations"],
    response_class=EventSourceResponse,
    description="New events of all sweeps and runs, or all events after `Last-Event-ID`."
    + MESSAGES.format(end="The stream stays open."),
)
async def follow_queue(
    subject: Annotated[EventSubject, Depends(_queue)],
    last_event: Annotated[int, Depends(_last_event_or_newest)],
    opened: Opened,
) -> AsyncIterable[ServerSentEvent]:
    async for message in opened(subject, after=last_event):
        yield message


@router.get("/sweeps/{id}/history", tags=["watch"])
def list_sweep_events(
    id: SweepId, store: AppStore, request: Request, response: Response, cursor: Cursor = None, limit: PageLimit = 100
) -> PageOf[EventModel]:
    """Past events of a sweep and its runs, oldest first."""
    store.sweeps.document(id)
    events = store.events.of_sweep(id, after=_number(cursor or "0"), limit=limit + 1)
    return _page(request, response, events, limit)


@router.get("/runs/{id}/history", tags=["runs"])
def list_run_events(
    id: RunId, store: AppStore, request: Request, response: Response, cursor: Cursor = None, limit: PageLimit = 100
) -> PageOf[EventModel]:
    """Past events of a run, oldest first."""
    store.runs.get(id)
    events = store.events.of_run(id, after=_number(cursor or "0"), limit=limit + 1)
    return _page(request, response, events, limit)


def _page(request: Request, response: Response, events: tuple[Event, ...], limit: int) -> PageOf[EventModel]:
    """The first ``limit`` events, with a link to the rest."""
    cursor = str(events[limit - 1].number) if len(events) > limit else None
    link_next(request, response, cursor)
    items = [EventModel(**vars(event)) for event in events[:limit]]
    return PageOf(items=items, next_cursor=cursor)
