"""Each request: its id, its line in the log, its place in the metrics."""

import logging
import re
import secrets
import time
from collections.abc import Mapping
from typing import Any

from starlette.datastructures import Headers, MutableHeaders
from starlette.types import ASGIApp, Message, Receive, Scope, Send

from service.api.metrics import Metrics
from service.records.logs import REQUEST_ID

log = logging.getLogger(__name__)

REQUEST_ID_GIVEN = re.compile(r"[A-Za-z0-9._-]{1,64}")
METHODS = frozenset({"GET", "HEAD", "POST", "PUT", "PATCH", "DELETE", "OPTIONS"})
OFTEN = frozenset({"/livez", "/readyz", "/metrics"})  # asked by machines every few seconds
UNKNOWN_ROUTE = "unknown"
LONGEST_ID = 64  # characters of an id in the log; those of the service have 32
NAMED = {"/v1/sweeps/": "sweep", "/v1/runs/": "run"}  # what ``{id}`` of a route is the id of


class RequestLog:
    """Middleware, the outermost of ours: gives each request an id, and notes how it went."""

    def __init__(self, app: ASGIApp, metrics: Metrics):
        self._app = app
        self._metrics = metrics

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        if scope["type"] != "http":
            await self._app(scope, receive, send)
            return
        request_id = _request_id(Headers(scope=scope))
        scope.setdefault("state", {})["request_id"] = request_id
        token = REQUEST_ID.set(request_id)
        begin, status = time.perf_counter(), 500  # of an exception that nobody answers in here

        async def send_marked(message: Message) -> None:
            nonlocal status
            if message["type"] == "http.response.start":
                status = message["status"]
                MutableHeaders(scope=message)["X-Request-ID"] = request_id
            await send(message)

        try:
            await self._app(scope, receive, send_marked)
        finally:
            self._note(scope, status, time.perf_counter() - begin)
            REQUEST_ID.reset(token)

    def _note(self, scope: Scope, status: int, seconds: float) -> None:
        method = scope["method"] if scope["method"] in METHODS else "other"
        route = route_of(scope)
        self._metrics.note_request(route=route, method=method, status=status, seconds=seconds)
        level = logging.WARNING if status >= 500 else logging.INFO
        words = {
            "method": method,
            "route": route,
            "status": status,
            "seconds": round(seconds, 6),
            "caller": scope["state"].get("caller") or None,
            **_ids(route, scope.get("path_params", {})),
        }
        log.log(
            logging.DEBUG if route in OFTEN and status < 500 else level,
            "%s %s %d",
            *(method, route, status),
            extra=words,
        )


def route_of(scope: Scope) -> str:
    """The template that a request met: never what a caller wrote."""
    template = getattr(scope.get("route"), "path", None)
    return template or scope.get("root_path") or UNKNOWN_ROUTE


def _ids(route: str, given: Mapping[str, Any]) -> dict[str, str]:
    """The run or sweep that a request was about."""
    words = (word for place, word in NAMED.items() if route.startswith(place) and "id" in given)
    return {word: str(given["id"])[:LONGEST_ID] for word in words}


def _request_id(headers: Headers) -> str:
    """The caller's own id if it is short and plain, else a new one."""
    given = headers.get("x-request-id", "")
    return given if REQUEST_ID_GIVEN.fullmatch(given) else secrets.token_hex(8)
