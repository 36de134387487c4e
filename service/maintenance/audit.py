"""The audit of a service: the middleware that writes down who gave which order, and what came of it."""

import re
from datetime import UTC, datetime

from anyio import CapacityLimiter, to_thread
from fastapi import FastAPI
from starlette.datastructures import Headers
from starlette.types import ASGIApp, Message, Receive, Scope, Send

from service.api.access import WITHOUT_KEY, Caller, peer_of
from service.api.browsers import SAFE_METHODS
from service.api.routes import Routes
from service.records.jobs import AuditEntry

SUBMIT = "submit"
# Actions by the name of their route; that of another one is the name itself.
ACTIONS = {
    "submit_sweep": SUBMIT,
    **{f"{order}_sweep": order for order in ("cancel", "retry", "pin", "unpin", "delete")},
    **{"change_sweep": "prioritise", "pause_queue": "pause", "resume_queue": "resume"},
}
READS = frozenset({"estimate_sweep", "evaluate_laws"})  # their questions come in a body
NO_ORDER = frozenset({405, 429, 503})  # statuses of requests that change nothing: of no such method, or to send again
ID_AT_END = re.compile(r"(?:^|/)([0-9a-f]{32})$")
MOST_RECORDING = 2  # threads that write the audit, and wait for the lock of the database


class Audit:
    """Records each order before its response begins."""

    def __init__(self, app: ASGIApp, service: FastAPI):
        self._app = app
        self._trail = service.state.store.audit
        self._threads = CapacityLimiter(MOST_RECORDING)

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        if scope["type"] != "http":
            await self._app(scope, receive, send)
            return
        has_response = False

        async def send_recorded(message: Message) -> None:
            nonlocal has_response
            if message["type"] == "http.response.start":
                has_response = True
                location = Headers(raw=message["headers"]).get("location", "")
                await self._record(audit_entry(scope, message["status"], location))
            await send(message)

        try:
            await self._app(scope, receive, send_recorded)
        except Exception:
            if not has_response:
                await self._record(audit_entry(scope, 500, ""))
            raise

    async def _record(self, entry: AuditEntry | None) -> None:
        if entry is not None:
            await to_thread.run_sync(self._trail.record, entry, limiter=self._threads)


def audit_entry(scope: Scope, status: int, location: str) -> AuditEntry | None:
    """The entry of a request whose response has a status and a ``Location``, if it is an order or has a refused key.

    Without a row are orders without a valid key (but the first wrong keys of a minute have one), and those during which
    the process was killed.
    """
    state, path, route = scope["state"], scope.get("path_params", {}), getattr(scope.get("route"), "name", "")
    action, caller = ACTIONS.get(f"{path.get('order')}_sweep") or ACTIONS.get(route, route), state.get("caller")
    if "refused_key" in state:
        key = state["refused_key"]
        action, caller = "refused key", WITHOUT_KEY if key is None else Caller.of(key)
    elif scope["method"] in SAFE_METHODS or route in READS or status in NO_ORDER:
        return None
    if not action or caller is None or (route, status) == (SUBMIT, 200):  # which shows a form
        return None
    # The response names the id of a new sweep, the path the id that another order is about.
    found = ID_AT_END.search(location) or ID_AT_END.search(path.get("id", ""))
    subject, address = found[1] if found else "", peer_of(scope)
    return AuditEntry(datetime.now(UTC), caller.key_id, caller.name, address, action, subject, str(status))


ROUTES = Routes("audit", prepare=lambda service: service.add_middleware(Audit, service=service))
