"""Requests of the client: repeated after a lost connection, with errors as exceptions.

An address that never responded fails at once; one that has responded may be restarting, and is asked again for
``patience`` seconds. Every request may be sent twice: a submission has an idempotency key, and every other command
names a state, not a change.
"""

import hashlib
import math
import time
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass, fields
from pathlib import Path
from typing import Any, TypedDict, TypeVar, Unpack

import httpx

from solver.errors import WhippleError
from studies.quantities.files import write_atomically
from studies.quantities.findings import Finding, InvalidInput

T = TypeVar("T")

FIRST_PAUSE, LONGEST_PAUSE = 0.2, 5.0  # s, between two attempts
UNIX = "unix:"  # begins the address of a socket, before its path
STREAM_TIMEOUT = 60.0  # s; an event stream sends something every 15 s
TEMPORARY = frozenset({429, 502, 503, 504})  # statuses of the service, or of a proxy in front of it
# Errors that a server causes; others mean that nothing listens at the address.
BROKEN = (httpx.RemoteProtocolError, httpx.ReadError, httpx.ReadTimeout)


class RequestOptions(TypedDict, total=False):
    """What a request has besides its method and path, as httpx takes it."""

    params: Mapping[str, str]
    headers: Mapping[str, str]
    content: bytes
    json: Mapping[str, int]


class ServiceError(WhippleError):
    """The service refused a request, or failed; ``status`` is the HTTP status."""

    def __init__(self, status: int, title: str, detail: str, retry_after: str = ""):
        super().__init__(f"{title}: {detail}" if detail else title)
        self.status = status
        self.seconds = float(retry_after) if retry_after.isdigit() else 0.0  # until it may pass


class Unreachable(WhippleError):
    """No service responds at the address."""


class Connection:
    def __init__(
        self, url: str, *, key: str | None, timeout: float, patience: float, transport: httpx.BaseTransport | None
    ):
        self.url = url.rstrip("/")
        self.headers = {} if key is None else {"Authorization": f"Bearer {key}"}
        base = self.url
        if base.startswith(UNIX):
            base, transport = "http://localhost", httpx.HTTPTransport(uds=base.removeprefix(UNIX))
        self._http = httpx.Client(base_url=base, timeout=timeout, transport=transport, headers=self.headers)
        self._patience = patience
        self._has_responded = False

    def close(self) -> None:
        self._http.close()

    def json(self, method: str, path: str, **options: Unpack[RequestOptions]) -> Any:
        """The JSON body of a response; raises InvalidInput, ServiceError, Unreachable."""
        response = self.request(method, path, **options)
        return response.json() if response.content else None

    def pages(self, path: str, **query: str | None) -> Iterator[Any]:
        """The items of all pages of a list; a ``query`` of None is left out."""
        given = {name: value for name, value in query.items() if value is not None}
        while True:
            page = self.json("GET", path, params=given)
            yield from page["items"]
            if page["next_cursor"] is None:
                return
            given["cursor"] = page["next_cursor"]

    def download(self, path: str, file: Path, check: Callable[[Path], None] | None = None) -> Path:
        """Stream a file to its place: whole and with the right digest, or not at all.

        ``check`` raises in place of the digest, for a file that is made while it is sent.
        """

        def fetch(part: Path) -> None:
            def attempt(_repeated: bool) -> None:
                # A redirect leads to the bucket of the service, and has the digest of the file.
                with self._http.stream("GET", path, follow_redirects=True) as response:
                    self._check(response)
                    digest = _write(response, part)
                tag = (response.history or [response])[0].headers.get("etag")
                if check is not None:
                    check(part)
                elif f'"{digest}"' != tag:
                    raise ServiceError(200, "Damaged download", f"{path}: the digest is wrong")

            self._repeat(attempt)

        return write_atomically(file, fetch)

    def events(self, path: str, *, after: str | None) -> Iterator["ServerEvent"]:
        """Messages of an event stream after an id, until one is named ``end``.

        A stream that breaks is resumed: every message arrives once.
        """
        retries = _Retries(self._patience)
        while True:
            position = {} if after is None else {"Last-Event-ID": after}
            headers = {"Accept": "text/event-stream", **position}
            try:
                with self._http.stream("GET", path, headers=headers, timeout=STREAM_TIMEOUT) as response:
                    self._check(response)
                    retries = _Retries(self._patience)
                    for message in server_events(response.iter_lines()):
                        after = message.id or after
                        yield message
                        if message.name == "end":
                            return
                # Closed in order: the service stops.
                time.sleep(FIRST_PAUSE)
            except (httpx.TransportError, ServiceError) as error:
                self._wait(retries, error)

    def request(self, method: str, path: str, **options: Unpack[RequestOptions]) -> httpx.Response:
        """The response to a request; raises InvalidInput, ServiceError, Unreachable."""

        def attempt(repeated: bool) -> httpx.Response:
            response = self._http.request(method, path, **options)
            if method == "DELETE" and response.status_code == 404 and repeated:
                # Deleted by an earlier attempt, whose response was lost.
                response.status_code = 204
            self._check(response)
            return response

        return self._repeat(attempt)

    def _repeat(self, attempt: Callable[[bool], T]) -> T:
        """The result of ``attempt``, repeated while errors may pass; its argument: whether this is a repetition."""
        retries = _Retries(self._patience)
        while True:
            try:
                return attempt(retries.count > 0)
            except (httpx.TransportError, ServiceError) as error:
                self._wait(retries, error)
            except httpx.InvalidURL as error:
                raise Unreachable(f"{self.url!r} is not an address ({error}); write http://HOST:PORT") from error

    def _check(self, response: httpx.Response) -> None:
        """Raise the error that a response reports."""
        is_problem = "problem+json" in response.headers.get("content-type", "")
        self._has_responded |= is_problem or not response.is_error
        if response.is_error:
            response.read()  # the body of the error: a streamed response has none yet
            raise _error_of(response)

    def _wait(self, retries: "_Retries", error: httpx.TransportError | ServiceError) -> None:
        """Wait before another attempt; raises the error if there is to be none."""
        if isinstance(error, ServiceError):
            if error.status not in TEMPORARY or not self._has_responded or not retries.wait(error.seconds):
                raise error
            return
        may_return = self._has_responded or isinstance(error, BROKEN)
        if isinstance(error, httpx.UnsupportedProtocol) or not may_return or not retries.wait():
            raise Unreachable(f"no response from {self.url} ({error}); is `whipple serve` running there?") from error


class _Retries:
    """Pauses between attempts, up to ``patience`` seconds in all."""

    def __init__(self, patience: float):
        self.count = 0
        self._patience = patience
        self._end = math.inf

    def wait(self, at_least: float = 0.0) -> bool:
        """Wait, each time longer; False if the patience is used up."""
        now = time.monotonic()
        if not self.count:
            self._end = now + self._patience
        pause = max(at_least, min(LONGEST_PAUSE, FIRST_PAUSE * 2.0**self.count))
        self.count += 1
        if now + pause > self._end:
            return False
        time.sleep(pause)
        return True


def _error_of(response: httpx.Response) -> WhippleError:
    """The exception for a problem document, or for an error page of another program."""
    status, retry_after = response.status_code, response.headers.get("retry-after", "")
    try:
        problem = response.json()
        findings = [Finding(*(item[field.name] for field in fields(Finding))) for item in problem.get("errors") or ()]
        if findings:
            return InvalidInput(findings, more=int(problem.get("more_errors") or 0))
        return ServiceError(status, problem["title"], problem.get("detail") or "", retry_after)
    except (ValueError, KeyError, TypeError, AttributeError):
        return ServiceError(status, f"HTTP {status}", response.text[:200], retry_after)


def _write(response: httpx.Response, file: Path) -> str:
    """Write a body to a file, and return its SHA-256."""
    digest = hashlib.sha256()
    with file.open("wb") as stream:
        for chunk in response.iter_bytes():
            digest.update(chunk)
            stream.write(chunk)
    return digest.hexdigest()


@dataclass(frozen=True)
class ServerEvent:
    """A message of an event stream."""

    name: str  # "message" unless the stream names it
    id: str | None  # None leaves the position of the client as it is
    data: str


def server_events(lines: Iterable[str]) -> Iterator[ServerEvent]:
    """The messages of a stream without its comments; an empty line ends each message.

    >>> [(message.name, message.id, message.data)
    ...  for message in server_events(["id: 7", "data: {}", "", ": comment", "data: incomplete"])]
    [('message', '7', '{}')]
    """
    values: dict[str, str] = {}
    data: list[str] = []
    for line in lines:
        if line:
            name, _, value = line.partition(":")
            value = value.removeprefix(" ")
            if name == "data":
                data.append(value)
            elif name:
                values[name] = value
            continue
        if data:
            yield ServerEvent(values.get("event", "message"), values.get("id"), "\n".join(data))
        values, data = {}, []
