"""Who may ask: where the service listens, whose requests it answers, and what each answer forbids.

On the loopback there is no login, so two things have to be kept out that a browser on the same machine
could be talked into: a foreign name that resolves to the loopback (DNS rebinding; seen in ``Host``), and
a write from a page of another site (seen in ``Sec-Fetch-Site`` and ``Origin``).
"""

import re
import secrets
from ipaddress import ip_address
from urllib.parse import urlsplit

from starlette.datastructures import Headers, MutableHeaders
from starlette.requests import Request
from starlette.types import ASGIApp, Message, Receive, Scope, Send

from service.errors import CrossSite, ForeignHost, answer
from service.settings import Settings
from studies.errors import Finding, InvalidInput

LOOPBACK_NAMES = frozenset({"localhost", "127.0.0.1", "::1"})
READING = frozenset({"GET", "HEAD", "OPTIONS"})
OWN_SITE = frozenset({"same-origin", "none"})  # "none": typed into the address bar
REQUEST_ID = re.compile(r"[A-Za-z0-9._-]{1,64}")
# A page of ours loads its own style sheet and nothing else; a route may say otherwise (the report).
PAGE_POLICY = (
    "default-src 'none'; style-src 'self'; img-src 'self' data:; "
    "form-action 'self'; frame-ancestors 'none'; base-uri 'none'"
)


def check_binding(settings: Settings) -> None:
    """Refuse to listen where strangers could reach a service without a login; raises InvalidInput."""
    if is_loopback(settings.host) or (settings.trusted_proxy and settings.allowed_hosts):
        return
    raise InvalidInput(
        [
            Finding(
                "host",
                settings.host,
                "an address of this machine's loopback: there is no login yet",
                "use 127.0.0.1; or, behind a proxy that checks who is asking, set WHIPPLE_TRUSTED_PROXY=true "
                "and the names it is reached by, WHIPPLE_ALLOWED_HOSTS='[\"whipple.example.org\"]'",
            )
        ]
    )


def is_loopback(host: str) -> bool:
    """Whether only this machine can reach an address.

    >>> is_loopback("127.0.0.1"), is_loopback("localhost"), is_loopback("0.0.0.0")
    (True, True, False)
    """
    try:
        return ip_address(host).is_loopback
    except ValueError:
        return host in LOOPBACK_NAMES


class Access:
    """Middleware: gives each request an id, refuses foreign hosts and writes of other sites."""

    def __init__(self, app: ASGIApp, settings: Settings):
        self._app = app
        self._hosts = LOOPBACK_NAMES | {settings.host, *settings.allowed_hosts}

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        if scope["type"] != "http":
            await self._app(scope, receive, send)
            return
        headers = Headers(scope=scope)
        request_id = _request_id(headers)
        scope.setdefault("state", {})["request_id"] = request_id

        async def send_marked(message: Message) -> None:
            if message["type"] == "http.response.start":
                _mark(MutableHeaders(scope=message), request_id)
            await send(message)

        refusal = self._refusal(scope["method"], headers)
        if refusal is None:
            await self._app(scope, receive, send_marked)
        else:
            await answer(Request(scope), refusal)(scope, receive, send_marked)

    def _refusal(self, method: str, headers: Headers) -> ForeignHost | CrossSite | None:
        host = headers.get("host", "")
        if _name_of(host) not in self._hosts:
            return ForeignHost(
                f"{host!r} is not a name of this service; use 127.0.0.1 or localhost"
            )
        if method not in READING and not _is_own_site(headers, host):
            return CrossSite("send the request from a page of this service, or without a browser")
        return None


def _is_own_site(headers: Headers, host: str) -> bool:
    """Programs send neither header; browsers send both, and pages cannot change them."""
    site, origin = headers.get("sec-fetch-site"), headers.get("origin")
    if site is not None and site not in OWN_SITE:
        return False
    return origin is None or urlsplit(origin).netloc == host


def _name_of(host: str) -> str:
    """A ``Host`` header without its port and brackets."""
    try:
        return urlsplit(f"//{host}").hostname or ""
    except ValueError:
        return ""


def _request_id(headers: Headers) -> str:
    """The caller's own id if it is short and plain, else a new one."""
    given = headers.get("x-request-id", "")
    return given if REQUEST_ID.fullmatch(given) else secrets.token_hex(8)


def _mark(headers: MutableHeaders, request_id: str) -> None:
    headers["X-Request-ID"] = request_id
    headers["X-Content-Type-Options"] = "nosniff"
    headers.setdefault("Referrer-Policy", "no-referrer")
    if headers.get("content-type", "").startswith("text/html"):
        headers.setdefault("Content-Security-Policy", PAGE_POLICY)
