"""Access control of requests: binding, Host and origin checks, API keys as bearer tokens (RFC 6750), scopes, owners.

A browser on the same machine could be abused through a foreign name that resolves to this machine (DNS rebinding;
visible in ``Host``), and by a page of another site that sends a write (visible in ``Sec-Fetch-Site`` and ``Origin``).

A request to a loopback name of a service that listens on the loopback needs no key, nor does one from the address of a
declared proxy; every other does. A key that is sent always counts: its name owns what is submitted with it, and its
scopes are the limit. In its place a browser has a session, whose orders need the token of a page too. Where other users
of this machine are not trusted, a socket takes the place of the loopback: who may open it may write the database too.
"""

import math
import time
from collections import Counter
from collections.abc import Mapping
from contextlib import suppress
from dataclasses import dataclass
from hashlib import sha256
from ipaddress import IPv4Address, IPv6Address, ip_address
from threading import Lock
from typing import Annotated
from urllib.parse import urlsplit

from fastapi import Depends, params
from fastapi.security import HTTPAuthorizationCredentials, HTTPBearer, SecurityScopes
from fastapi.security.base import SecurityBase
from starlette import types
from starlette.datastructures import Headers, MutableHeaders
from starlette.requests import Request

from service.api.browsers import SAFE_METHODS, SESSION, FormFields, check_token, cookie
from service.api.errors import (
    BadRequest,
    CrossSiteRequest,
    Forbidden,
    MisdirectedRequest,
    TooManyRequests,
    TooManyWrongKeys,
    Unauthorized,
    add_security_headers,
    problem_response,
)
from service.records.jobs import KeyRow, Scope, StoreUnavailable, SweepStatus
from service.settings import Settings
from studies.quantities.findings import Finding, InvalidInput

LOOPBACK_NAMES = frozenset({"localhost", "127.0.0.1", "::1"})
SINGLE_HEADERS = ("Host", "Origin", "Sec-Fetch-Site")  # RFC 9112, section 3.2
OWN_SITE = frozenset({"same-origin", "none"})  # "none": typed into the address bar
LONGEST_SECRET = 200  # characters; the service makes shorter ones
OWN_SOCKET = "socket"  # in place of the address of a peer that comes through the socket in the data directory
MOST_WRONG_KEYS = 10  # wrong keys that an address may send in a minute, until it has to wait
MOST_NAMES = 1000  # owners or addresses that are counted one by one in a minute


def check_binding(settings: Settings, *, has_keys: bool) -> None:
    """Refuse to listen on a network without keys or a trusted proxy; raises InvalidInput."""
    if is_loopback(settings.host) or has_keys:
        return
    if settings.trusted_proxy and settings.allowed_hosts:
        return
    cure = (
        "use 127.0.0.1; or make a key with `whipple keys create NAME`; or, behind a proxy that "
        "authenticates requests, set WHIPPLE_TRUSTED_PROXY to its addresses and WHIPPLE_ALLOWED_HOSTS "
        "to the names under which it is reached, each as a JSON list"
    )
    limit = "a loopback address, because the service has no API key"
    raise InvalidInput([Finding("host", settings.host, limit, cure)])


def is_loopback(host: str) -> bool:
    """Whether an address can be reached from this machine only.

    >>> is_loopback("127.0.0.1"), is_loopback("localhost"), is_loopback("0.0.0.0")
    (True, True, False)
    """
    address = _address(host)
    return host in LOOPBACK_NAMES if address is None else address.is_loopback


def _address(text: str) -> IPv4Address | IPv6Address | None:
    """A numeric address; None for a name."""
    with suppress(ValueError):
        return ip_address(text)
    return None


class Access:
    """Middleware that refuses foreign hosts and cross-site writes, and adds the fields of security and of rates."""

    def __init__(self, app: types.ASGIApp, settings: Settings):
        self._app = app
        self._hosts = LOOPBACK_NAMES | {settings.host, *settings.allowed_hosts}

    async def __call__(self, scope: types.Scope, receive: types.Receive, send: types.Send) -> None:
        if scope["type"] != "http":
            await self._app(scope, receive, send)
            return

        async def send_with_headers(message: types.Message) -> None:
            if message["type"] == "http.response.start":
                headers = MutableHeaders(scope=message)
                add_security_headers(headers)
                headers.update(scope["state"].get("rate", {}))
            await send(message)

        refusal = self._refusal(scope)
        app = self._app if refusal is None else problem_response(Request(scope), refusal)
        await app(scope, receive, send_with_headers)

    def _refusal(self, scope: types.Scope) -> Exception | None:
        headers = Headers(scope=scope)
        repeated = [name for name in SINGLE_HEADERS if len(headers.getlist(name)) > 1]
        if repeated:
            return BadRequest(f"{' and '.join(repeated)} sent more than once; send one")
        host = headers.get("host", "")
        name = _hostname(host)
        if name not in self._hosts and not _is_own_address(scope, name):
            return MisdirectedRequest(
                f"{host[:80]!r} is not a name of this service; use 127.0.0.1 or localhost, or set "
                "WHIPPLE_ALLOWED_HOSTS to the names of this service"
            )
        if scope["method"] not in SAFE_METHODS and not _is_own_site(headers, host):
            return CrossSiteRequest("send the request from a page of this service, or without a browser")
        return None


def _is_own_site(headers: Headers, host: str) -> bool:
    """Whether a write comes from a program, which sends neither header, or from a page of this service."""
    site, origin = headers.get("sec-fetch-site"), headers.get("origin")
    if site is not None and site not in OWN_SITE:
        return False
    if origin is None:
        return True
    try:
        return urlsplit(origin).netloc == host != ""
    except ValueError:
        return False


def _is_own_address(scope: types.Scope, name: str) -> bool:
    """Whether a ``Host`` is the numeric address that the connection was made to."""
    address = _address(name)
    return address is not None and address == _address((scope.get("server") or ("",))[0])


def _hostname(host: str) -> str:
    """A ``Host`` header without its port and brackets."""
    try:
        return urlsplit(f"//{host}").hostname or ""
    except ValueError:
        return ""


# The scopes that each scope includes.
INCLUDES = {
    Scope.READ: frozenset({Scope.READ}),
    Scope.SUBMIT: frozenset({Scope.SUBMIT, Scope.READ}),
    Scope.ADMIN: frozenset(Scope),
}


@dataclass(frozen=True)
class Caller:
    """The authenticated sender of a request."""

    name: str  # name of the API key; empty without a key
    scopes: frozenset[Scope]
    key_id: str | None = None
    has_session: bool = False  # whether the session of a browser stands in place of the key

    @staticmethod
    def of(key: KeyRow, *, has_session: bool = False) -> "Caller":
        """The sender of a request with a key."""
        return Caller(key.name, key.scopes, key.id, has_session)

    def may(self, scope: Scope) -> bool:
        """Whether the caller's scopes include ``scope``."""
        return any(scope in INCLUDES[own] for own in self.scopes)

    def owns(self, sweep: SweepStatus) -> bool:
        """Whether the sweep is the caller's own, or the caller has the scope ``admin``."""
        return sweep.owner == self.name or self.may(Scope.ADMIN)


WITHOUT_KEY = Caller("", frozenset(Scope))  # a user of this machine, or authenticated by the proxy

bearer: SecurityBase = HTTPBearer(
    scheme_name="API key",
    description="`Authorization: Bearer KEY`; optional on the service's own machine.",
    auto_error=False,
)
Credentials = Annotated[HTTPAuthorizationCredentials | None, Depends(bearer)]


def _admit(request: Request, required: SecurityScopes, credentials: Credentials) -> Caller:
    """The caller, if it has the scopes that an endpoint requires; raises Unauthorized, Forbidden, TooManyRequests."""
    known: KnownCallers = request.app.state.known_callers
    try:
        caller = authenticate(request, credentials)
    except Unauthorized:
        known.forget(request.scope)
        raise
    request.state.caller = caller
    known.remember(request.scope, caller)
    if not caller.may(Scope.ADMIN) and not hasattr(request.state, "rate"):  # router and endpoint ask both
        state = request.app.state
        request.state.rate = count_request(state.requests, caller.name, state.settings.quota_requests)
    for scope in map(Scope, required.scopes):
        if not caller.may(scope):
            raise Forbidden(
                f"the key {caller.name!r} lacks the scope `{scope}`; ask for a key that has it", scope=scope
            )
    return caller


async def authorize(request: Request, caller: Annotated[Caller, Depends(_admit)], form: FormFields) -> Caller:
    """The caller that was admitted before its form was read.

    Raises CrossSiteRequest for an order of a session without the token of a page.
    """
    if caller.has_session and request.method not in SAFE_METHODS:
        check_token(request, form)
    return caller


def authenticate(request: Request, credentials: HTTPAuthorizationCredentials | None) -> Caller:
    """The sender of a request, as of now; raises Unauthorized."""
    if credentials is not None:
        return Caller.of(key_of(request, credentials.credentials))
    if "authorization" in request.headers:
        raise Unauthorized("write the header as `Authorization: Bearer KEY`", key_was_sent=True)
    session = cookie(request, SESSION)
    if session and (key := request.app.state.store.keys.of_session(session)):
        return Caller.of(key, has_session=True)
    if _needs_no_key(request.scope, request.app.state.settings):
        return WITHOUT_KEY
    raise Unauthorized(
        "send `Authorization: Bearer KEY`; the operator of the service makes a key with `whipple keys create`",
        key_was_sent=False,
    )


def known_caller(request: Request) -> Caller | None:
    """The caller of a page that is open to everyone; None where none is known."""
    with suppress(Unauthorized, StoreUnavailable):
        return authenticate(request, None)
    return None


def key_of(request: Request, secret: str) -> KeyRow:
    """The usable key with a secret; raises Unauthorized, TooManyWrongKeys.

    Users behind one address share its limit, so a valid key is served whatever the others send.
    """
    keys, is_plausible = request.app.state.store.keys, 0 < len(secret) <= LONGEST_SECRET
    key: KeyRow | None = keys.find(secret) if is_plausible else None
    if key is None:
        number, seconds = request.app.state.wrong_keys.count(network_of(peer_of(request.scope)))
        if number > MOST_WRONG_KEYS:
            raise TooManyWrongKeys(seconds)
        request.state.refused_key = keys.find(secret, ended=True) if is_plausible else None
        raise Unauthorized("this key is unknown, revoked or expired; ask for another", key_was_sent=True)
    return key


def peer_of(scope: types.Scope) -> str:
    """The address of the peer, whatever the headers say; ``OWN_SOCKET`` for one without."""
    server = scope.get("server")
    if server is not None and server[1] is None:  # a path has no port
        return OWN_SOCKET
    text = str((scope.get("client") or ("",))[0])
    # A socket for both families writes an IPv4 peer as a mapped IPv6 address.
    return str(getattr(_address(text), "ipv4_mapped", None) or text)


def _needs_no_key(scope: types.Scope, settings: Settings) -> bool:
    """Whether a request comes from a user of this machine or from a declared proxy.

    One to a loopback service names the loopback: any other name came through a proxy.
    """
    peer = peer_of(scope)
    address, host = _address(peer), _hostname(Headers(scope=scope).get("host", ""))
    is_from_proxy = address is not None and any(address in network for network in settings.trusted_proxy)
    is_local = settings.trust_loopback and is_loopback(settings.host) and host in {*LOOPBACK_NAMES, settings.host}
    return peer == OWN_SOCKET or is_from_proxy or is_local


def requires(scope: Scope) -> params.Security:
    """A dependency that admits callers with ``scope`` only."""
    return params.Security(authorize, scopes=[scope.value])


Reader = Annotated[Caller, requires(Scope.READ)]
Submitter = Annotated[Caller, requires(Scope.SUBMIT)]
Administrator = Annotated[Caller, requires(Scope.ADMIN)]


WINDOW = 60.0  # s


class MinuteCounter:
    """Counts by name in windows of a minute; names beyond ``MOST_NAMES`` are counted together."""

    def __init__(self) -> None:
        self._end, self._numbers, self._mutex = 0.0, Counter[str](), Lock()

    def count(self, name: str) -> tuple[int, int]:
        """Count one more; its number in this minute, and the seconds until the next one."""
        now = time.monotonic()
        with self._mutex:
            if now >= self._end:
                self._end, self._numbers = now + WINDOW, Counter()
            if len(self._numbers) >= MOST_NAMES and name not in self._numbers:
                name = "others"
            self._numbers[name] += 1
            return self._numbers[name], math.ceil(self._end - now)


def count_request(counter: MinuteCounter, owner: str, quota: int) -> Mapping[str, str]:
    """Count a request of an owner; the fields of its response. Raises TooManyRequests beyond a quota for a minute.

    Fields are those of draft-ietf-httpapi-ratelimit-headers-10: ``RateLimit-Policy: "requests";q=6000;w=60`` and
    ``RateLimit: "requests";r=5999;t=42``, the requests that remain and the seconds until all are there again.
    """
    number, seconds = counter.count(owner)
    fields = {
        "RateLimit-Policy": f'"requests";q={quota};w={WINDOW:.0f}',
        "RateLimit": f'"requests";r={max(0, quota - number)};t={seconds}',
    }
    if number > quota:
        text = f"{number} requests of {owner!r} within {WINDOW:.0f} s; the quota is {quota}"
        raise TooManyRequests(text, {**fields, "Retry-After": str(seconds)})
    return fields


class KnownCallers:
    """The owners of keys and sessions that were valid when they came last: a request waits for its turn as one of them.

    Whoever is not known by them waits as its address. A request is authenticated after that, whatever is known.
    """

    def __init__(self) -> None:
        self._owners: dict[bytes, str] = {}  # by digests of what was sent, the latest last
        self._mutex = Lock()

    def name_of(self, scope: types.Scope) -> str:
        """The caller among which turns are shared."""
        owner = self._owners.get(_sent_by(scope))
        return f"address {network_of(peer_of(scope))}" if owner is None else f"key {owner}"

    def remember(self, scope: types.Scope, caller: Caller) -> None:
        """Know the sender of a request from now on; only of one with a key."""
        if caller.key_id is None:
            return
        sent = _sent_by(scope)
        with self._mutex:
            self._owners.pop(sent, None)
            self._owners[sent] = caller.name
            if len(self._owners) > MOST_NAMES:
                del self._owners[next(iter(self._owners))]

    def forget(self, scope: types.Scope) -> None:
        """Know the sender of a refused request no longer."""
        with self._mutex:
            self._owners.pop(_sent_by(scope), None)


def _sent_by(scope: types.Scope) -> bytes:
    """A digest of the key and the session that a request has."""
    request = Request(scope)
    return sha256("\n".join((request.headers.get("authorization", ""), cookie(request, SESSION))).encode()).digest()


def network_of(text: str) -> str:
    """An address, or of IPv6 the network of its host.

    >>> network_of("127.0.0.1"), network_of("2001:db8::1"), network_of("socket")
    ('127.0.0.1', '2001:0db8:0000:0000', 'socket')
    """
    address = _address(text)
    return text if address is None else address.exploded[:19]  # a host with IPv6 has the addresses of a /64
