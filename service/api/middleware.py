"""Around each request: its id and log line; deadlines and a bound on the work of reading it.

Half-sent requests occupy connections at no cost to their sender, so a head and a body each have a deadline, and when
all connections are taken, the one whose deadline is nearest makes room. Reading one request blocks the event loop, so
its computing time is bounded. A connection that sends a request before the last response is closed after that.
"""

import asyncio
import logging
import re
import secrets
import time

import h11
from anyio import CancelScope
from anyio.lowlevel import checkpoint
from starlette.datastructures import Headers, MutableHeaders
from starlette.types import ASGIApp, Message, Receive, Scope, Send
from uvicorn.protocols.http.flow_control import CLOSE_HEADER
from uvicorn.protocols.http.h11_impl import H11Protocol

from service import memory
from service.logs import REQUEST_ID

log = logging.getLogger(__name__)

CALLERS_REQUEST_ID = re.compile(r"[A-Za-z0-9._-]{1,64}")
ACCEPTED = 202
METHODS = frozenset({"GET", "HEAD", "POST", "PUT", "PATCH", "DELETE", "OPTIONS"})
QUIET = frozenset({"/livez", "/readyz", "/metrics"})  # monitors request them every few seconds
UNKNOWN_ROUTE = "unknown"
LONGEST_ID = 64  # characters of an id in the log; those of the service have 32
ID_FIELDS = {"/v1/sweeps/": "sweep", "/v1/runs/": "run"}  # log field for the ``{id}`` of a route

LONGEST_HEAD = 32 * 1024  # bytes of request line and headers; usual are a few hundred
HEAD_SECONDS = 10.0  # limit for a head; on a kept connection, from the end of the last response
BODY_SECONDS = 120.0  # limit for a body: 4 MiB at 35 kB/s
CHUNK = 16 * 1024  # bytes parsed between two readings of the clock
PARSING_SECONDS = 0.1  # computing time that a request may take beyond what its bytes may:
PARSING_RATE = 10e6  # bytes/s; packets are parsed at 160e6, chunks of one byte at 1e6 (2026-11)
MOST_PIPELINING = 32  # with more connections of any kind, one that pipelines is closed without a response
ENDED = "ended"  # in the state of a request whose connection is closed before it is looked at
UNREAD_SECONDS = 60.0  # limit for a client to read 48 KiB of a response


class RequestLog:
    """The outermost middleware: gives each request an id, and logs its outcome."""

    def __init__(self, app: ASGIApp):
        self._app = app

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        if scope["type"] != "http":
            await self._app(scope, receive, send)
            return
        if ENDED in scope.get("state", ()):
            return
        callers_id = Headers(scope=scope).get("x-request-id", "")
        is_plain = CALLERS_REQUEST_ID.fullmatch(callers_id)
        request_id = callers_id if is_plain else secrets.token_hex(8)
        scope.setdefault("state", {})["request_id"] = request_id
        token = REQUEST_ID.set(request_id)
        begin, status = time.perf_counter(), 500  # stays 500 if an exception escapes

        async def send_with_id(message: Message) -> None:
            nonlocal status
            if message["type"] == "http.response.start":
                status = message["status"]
                headers = MutableHeaders(scope=message)
                headers["X-Request-ID"] = request_id
            await send(message)

        try:
            await self._app(scope, receive, send_with_id)
        finally:
            if status == ACCEPTED:  # ten thousand runs of a sweep have been here
                memory.give_back()
            seconds = time.perf_counter() - begin
            self._record(scope, status, seconds)
            for observe in scope["app"].state.at_response:
                observe(scope, status, seconds)
            REQUEST_ID.reset(token)

    def _record(self, scope: Scope, status: int, seconds: float) -> None:
        method, route = method_of(scope), route_of(scope)
        id = scope.get("path_params", {}).get("id")
        is_quiet = route in QUIET and status < 500
        level = logging.WARNING if status >= 500 else logging.DEBUG if is_quiet else logging.INFO
        fields = {
            "method": method,
            "route": route,
            "status": status,
            "seconds": round(seconds, 6),
            "caller": getattr(scope["state"].get("caller"), "name", None) or None,
        }
        for prefix, field in ID_FIELDS.items():
            if id is not None and route.startswith(prefix):
                fields[field] = str(id)[:LONGEST_ID]
        log.log(level, "%s %s %d", method, route, status, extra=fields)


def method_of(scope: Scope) -> str:
    """The method of a request, or "other": what the caller wrote is never a label."""
    return scope["method"] if scope["method"] in METHODS else "other"


def route_of(scope: Scope) -> str:
    """The template of the route of a request that was responded to."""
    return getattr(scope.get("route"), "path", None) or scope.get("root_path") or UNKNOWN_ROUTE


class Heads:
    """The middleware that responds to HEAD wherever there is a GET: with its status and headers, and no body.

    What the GET would send after its headers is not made: a stream of events ends at once.
    """

    def __init__(self, app: ASGIApp):
        self._app = app

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        if scope["type"] != "http" or scope["method"] != "HEAD":
            await self._app(scope, receive, send)
            return

        async def send_head(message: Message) -> None:
            if message["type"] == "http.response.start":
                scope["method"] = "HEAD"  # as the server and the log know it
                await send(message)
                await send({"type": "http.response.body", "body": b""})
                rest.cancel()
                await checkpoint()  # ends the response here

        scope["method"], scope["is_head"] = "GET", True
        try:
            with CancelScope() as rest:
                await self._app(scope, receive, send_head)
        finally:
            scope["method"] = "HEAD"


class DeadlineProtocol(H11Protocol):
    """A connection that is closed when a request comes too slowly or costs too much, or its response is not read."""

    _deadline: asyncio.TimerHandle | None = None
    _unread: asyncio.TimerHandle | None = None  # while the client does not read
    _pipelines = False  # has sent a request before the response of the last one
    _deadline_state: type | None = None  # state of h11 that the deadline belongs to
    _excess_seconds = 0.0  # computing time on this request, beyond what its bytes may take

    def connection_made(self, transport: asyncio.Transport) -> None:  # type: ignore[override] # as uvicorn's own
        super().connection_made(transport)
        self._set_deadline()
        self._make_room()

    def data_received(self, data: bytes) -> None:
        for offset in range(0, len(data), CHUNK):
            chunk = data[offset : offset + CHUNK]
            begin = time.thread_time()
            super().data_received(chunk)
            self._set_deadline()
            seconds = time.thread_time() - begin - len(chunk) / PARSING_RATE
            self._excess_seconds = max(0.0, self._excess_seconds + seconds)
            if self._excess_seconds > PARSING_SECONDS:
                self.transport.close()
            if self.transport.is_closing():
                return
        if self._pipelines or not self.flow.read_paused:  # a long body pauses reading too
            return
        if self.conn.their_state is h11.DONE and self.conn.trailing_data[0]:
            self._pipelines = True
            self.headers.append(CLOSE_HEADER)
            self.cycle.keep_alive = False
            if len(self.connections) > MOST_PIPELINING:
                self.scope["state"][ENDED] = self.cycle.disconnected = True
                self.connections.discard(self)
                self.transport.abort()

    def pause_writing(self) -> None:
        super().pause_writing()
        self._unread = self.loop.call_later(UNREAD_SECONDS, self.transport.abort)

    def resume_writing(self) -> None:
        super().resume_writing()
        self._clear_unread()

    def _clear_unread(self) -> None:
        if self._unread is not None:
            self._unread.cancel()
            self._unread = None

    def on_response_complete(self) -> None:
        super().on_response_complete()
        self._set_deadline()

    def connection_lost(self, exc: Exception | None) -> None:
        self._clear_deadline()
        self._clear_unread()
        super().connection_lost(exc)

    def _set_deadline(self) -> None:
        """Start the time for a head or a body; a complete request has no deadline."""
        state = self.conn.their_state
        if state is self._deadline_state or self.transport.is_closing():
            return
        self._clear_deadline()
        self._deadline_state = state
        if state is h11.IDLE:
            self._excess_seconds = 0.0
        seconds = {h11.IDLE: HEAD_SECONDS, h11.SEND_BODY: BODY_SECONDS}.get(state)
        if seconds is not None:
            self._deadline = self.loop.call_later(seconds, self.transport.close)

    def _clear_deadline(self) -> None:
        if self._deadline is not None:
            self._deadline.cancel()
            self._deadline = None

    def _make_room(self) -> None:
        """When all connections are taken, close the one whose deadline is nearest."""
        if self.limit_concurrency is None or len(self.connections) < self.limit_concurrency:
            return
        ends = {
            other: timer.when()
            for other in self.connections - {self}
            if isinstance(other, DeadlineProtocol) and (timer := other._deadline or other._unread)
        }
        if ends:
            nearest = min(ends, key=ends.__getitem__)
            end = nearest.transport.abort if nearest._unread else nearest.transport.close
            end()
            self.connections.discard(nearest)
