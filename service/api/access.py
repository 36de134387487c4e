"""Where the service listens, whose requests it answers, and what each answer forbids.

A browser on the same machine could be talked into two things that have to be kept out: a foreign name
that resolves to this machine (DNS rebinding; seen in ``Host``), and a write from a page of another site
(seen in ``Sec-Fetch-Site`` and ``Origin``). A Host that is the very address which the request came to
is no foreign name: somebody wrote it. Who is asking is the matter of ``service.api.keys``.
"""

from ipaddress import ip_address
from urllib.parse import urlsplit

from starlette.datastructures import Headers, MutableHeaders
from starlette.requests import Request
from starlette.types import ASGIApp, Message, Receive, Scope, Send

from service.api.errors import CrossSite, ForeignHost, Malformed, answer
from service.records.settings import Settings
from studies.values.errors import Finding, InvalidInput

LOOPBACK_NAMES = frozenset({"localhost", "127.0.0.1", "::1"})
READING = frozenset({"GET", "HEAD", "OPTIONS"})
ONCE = ("Host", "Origin", "Sec-Fetch-Site")  # what is decided by here; RFC 9112, section 3.2
OWN_SITE = frozenset({"same-origin", "none"})  # "none": typed into the address bar
# A page of ours loads its own style sheet and nothing else; a route may say otherwise (the report).
PAGE_POLICY = (
    "default-src 'none'; style-src 'self'; img-src 'self' data:; "
    "form-action 'self'; frame-ancestors 'none'; base-uri 'none'"
)
# What is no page shows nothing and runs nothing, should a browser take it for one.
OTHER_POLICY = "default-src 'none'; frame-ancestors 'none'; sandbox"
FORBIDS = {
    "X-Content-Type-Options": "nosniff",
    "X-Frame-Options": "DENY",
    "Referrer-Policy": "no-referrer",
    "Cross-Origin-Resource-Policy": "same-origin",
    "Cross-Origin-Opener-Policy": "same-origin",
    "Cache-Control": "no-store",  # a file may say otherwise
}


def check_binding(settings: Settings, *, has_keys: bool) -> None:
    """Refuse to listen where strangers could reach a service without a login; raises InvalidInput."""
    if is_loopback(settings.host) or has_keys:
        return
    if settings.trusted_proxy and settings.allowed_hosts:
        return
    raise InvalidInput(
        [
            Finding(
                "host",
                settings.host,
                "an address of this machine's loopback, as long as there is no API key",
                "use 127.0.0.1; or make a key with `whipple keys create NAME`; or, behind a proxy that "
                "checks who is asking, set WHIPPLE_TRUSTED_PROXY to its addresses and WHIPPLE_ALLOWED_HOSTS "
                "to the names that it is reached by, each as a JSON list",
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


def is_of_this_machine(scope: Scope, settings: Settings) -> bool:
    """Whether a request can only come from a user of this machine: by a name of the loopback, to it.

    One that came by another name was passed on by something in front of the service.
    """
    host = _name_of(Headers(scope=scope).get("host", ""))
    return is_loopback(settings.host) and (host in LOOPBACK_NAMES or host == settings.host)


def is_of_trusted_proxy(scope: Scope, settings: Settings) -> bool:
    """Whether a request comes from a proxy that has checked who is asking: by its address, not its words."""
    try:
        peer = ip_address((scope.get("client") or ("",))[0])
    except ValueError:
        return False
    plain = getattr(peer, "ipv4_mapped", None) or peer  # as a socket for both kinds writes it
    return any(plain in network for network in settings.trusted_proxy)


class Access:
    """Middleware: refuses foreign hosts and writes of other sites, and marks what is answered."""

    def __init__(self, app: ASGIApp, settings: Settings):
        self._app = app
        self._hosts = LOOPBACK_NAMES | {settings.host, *settings.allowed_hosts}

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        if scope["type"] != "http":
            await self._app(scope, receive, send)
            return

        async def send_marked(message: Message) -> None:
            if message["type"] == "http.response.start":
                mark(MutableHeaders(scope=message))
            await send(message)

        refusal = self._refusal(scope)
        if refusal is None:
            await self._app(scope, receive, send_marked)
        else:
            await answer(Request(scope), refusal)(scope, receive, send_marked)

    def _refusal(self, scope: Scope) -> Malformed | ForeignHost | CrossSite | None:
        headers = Headers(scope=scope)
        twice = [name for name in ONCE if len(headers.getlist(name)) > 1]
        if twice:
            return Malformed(f"{' and '.join(twice)} given more than once; send one")
        host = headers.get("host", "")
        name = _name_of(host)
        if name not in self._hosts and not _is_address_of(scope, name):
            return ForeignHost(
                f"{host[:80]!r} is not a name of this service; use 127.0.0.1 or localhost, or set "
                "WHIPPLE_ALLOWED_HOSTS to the names that it is reached by"
            )
        if scope["method"] not in READING and not _is_own_site(headers, host):
            return CrossSite("send the request from a page of this service, or without a browser")
        return None


def mark(headers: MutableHeaders) -> None:
    """Add what an answer forbids a browser to do with it."""
    for name, value in FORBIDS.items():
        headers.setdefault(name, value)
    is_page = headers.get("content-type", "").startswith("text/html")
    headers.setdefault("Content-Security-Policy", PAGE_POLICY if is_page else OTHER_POLICY)


def _is_own_site(headers: Headers, host: str) -> bool:
    """Programs send neither header; browsers send both, and pages cannot change them."""
    site, origin = headers.get("sec-fetch-site"), headers.get("origin")
    if site is not None and site not in OWN_SITE:
        return False
    return origin is None or _place_of(origin) == host


def _place_of(origin: str) -> str | None:
    """Host and port of an ``Origin``; None for one that has none."""
    try:
        return urlsplit(origin).netloc or None
    except ValueError:
        return None


def _is_address_of(scope: Scope, name: str) -> bool:
    """Whether a ``Host`` is the number of the address that the request came to."""
    server = scope.get("server")
    try:
        return server is not None and ip_address(name) == ip_address(server[0])
    except ValueError:
        return False


def _name_of(host: str) -> str:
    """A ``Host`` header without its port and brackets."""
    try:
        return urlsplit(f"//{host}").hostname or ""
    except ValueError:
        return ""
