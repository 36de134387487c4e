"""The client's way to a service: requests that are sent again after a lost connection, and what a refusal means.

An address that never answered is told at once: it is wrong, or nothing runs there. One that has
answered is waited for, ``patience`` seconds long, when its connection breaks or it says that asking
again may succeed: it may be starting anew. Whatever is sent can be sent twice: a submission has a key
that makes it count once, and every other order asks for a state, not for a change.
"""

import hashlib
import math
import time
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import fields
from pathlib import Path
from typing import Any

import httpx

from service.client.server_events import ServerEvent, messages
from solver.errors import WhippleError
from studies.values.errors import Finding, InvalidInput
from studies.values.files import write_atomically

FIRST_PAUSE, LONGEST_PAUSE = 0.2, 5.0  # s, between two attempts
QUIET_SECONDS = 60.0  # an event stream says something every 15 s
PASSING = frozenset({502, 503, 504})  # of the service, and of a proxy in front of it


class ServiceError(WhippleError):
    """The service refused, or failed; ``status`` is the HTTP status."""

    def __init__(self, status: int, title: str, detail: str):
        super().__init__(f"{title}: {detail}" if detail else title)
        self.status = status


class Unreachable(WhippleError):
    """No service answers at this address."""


class Connection:
    """Requests to one service."""

    def __init__(
        self,
        url: str,
        *,
        key: str | None,
        timeout: float,
        patience: float,
        transport: httpx.BaseTransport | None,
    ):
        self.url = url.rstrip("/")
        self.headers = {} if key is None else {"Authorization": f"Bearer {key}"}
        self._http = httpx.Client(
            base_url=self.url, timeout=timeout, transport=transport, headers=self.headers
        )
        self._patience = patience
        self._has_answered = False

    def close(self) -> None:
        """Give the connections back."""
        self._http.close()

    def json(self, method: str, path: str, **given: Any) -> Any:
        """The answer to a request; raises InvalidInput, ServiceError, Unreachable."""
        response = self._send(method, path, **given)
        return response.json() if response.content else None

    def text(self, path: str, **given: Any) -> str:
        """A file that is text."""
        return self._send("GET", path, **given).text

    def pages(self, path: str, **query: str) -> Iterator[dict[str, Any]]:
        """The items of all pages of a list."""
        cursor: dict[str, str] = {}
        while True:
            page = self.json("GET", path, params=query | cursor)
            yield from page["items"]
            if page["next_cursor"] is None:
                return
            cursor = {"cursor": page["next_cursor"]}

    def download(self, path: str, file: Path) -> Path:
        """Stream a file to its place: whole and with the right digest, or not at all."""
        return write_atomically(file, lambda part: self._fetch(path, part))

    def _fetch(self, path: str, part: Path) -> None:
        attempts = _Attempts(self._patience)
        while True:
            try:
                with self._http.stream("GET", path) as response:
                    self._check_stream(response)
                    digest = _write(response, part)
                break
            except (httpx.TransportError, _Passing) as error:
                self._again(attempts, error)
        if f'"{digest}"' != response.headers.get("etag"):
            raise ServiceError(200, "The download is damaged", f"{path}: the digest differs")

    def events(self, path: str, *, after: str | None) -> Iterator[ServerEvent]:
        """Messages of an event stream behind a number, until one is named ``end``.

        A stream that breaks is taken up again where it was: nothing is missed, nothing told twice.
        """
        attempts, pause = _Attempts(self._patience), FIRST_PAUSE
        while True:
            place = {} if after is None else {"Last-Event-ID": after}
            headers = {"Accept": "text/event-stream", **place}
            try:
                with self._http.stream(
                    "GET", path, headers=headers, timeout=httpx.Timeout(QUIET_SECONDS)
                ) as response:
                    self._check_stream(response)
                    attempts = _Attempts(self._patience)
                    for message in messages(response.iter_lines()):
                        after, pause = message.id or after, message.retry or pause
                        if message.data:
                            yield message
                        if message.name == "end":
                            return
                time.sleep(min(pause, LONGEST_PAUSE))  # it was closed in order: the service leaves
            except (httpx.TransportError, _Passing) as error:
                self._again(attempts, error)

    def _send(self, method: str, path: str, **given: Any) -> httpx.Response:
        attempts = _Attempts(self._patience)
        while True:
            try:
                with _readable(self.url):
                    response = self._http.request(method, path, **given)
                if method == "DELETE" and response.status_code == 404 and attempts.made:
                    response.status_code = 204  # it was done, and the answer was lost
                self._check(response)
            except (httpx.TransportError, _Passing) as error:
                self._again(attempts, error)
            else:
                return response

    def _check_stream(self, response: httpx.Response) -> None:
        if response.is_error:
            response.read()
        self._check(response)

    def _check(self, response: httpx.Response) -> None:
        """Raise what an answer says that is none."""
        is_ours = not response.is_error or "problem+json" in response.headers.get(
            "content-type", ""
        )
        self._has_answered = self._has_answered or is_ours
        if not response.is_error:
            return
        error = _refusal(response)
        if response.status_code in PASSING and self._has_answered:
            raise _Passing(error, response.headers.get("retry-after", ""))
        raise error

    def _again(self, attempts: "_Attempts", error: "httpx.TransportError | _Passing") -> None:
        """Wait before another attempt; raises what the last one came to when there is to be none."""
        if isinstance(error, _Passing):
            if not attempts.wait(error.seconds):
                raise error.refusal
        elif not self._may_come_back(error) or not attempts.wait():
            raise Unreachable(
                f"no answer from {self.url} ({error}); is `whipple serve` running there?"
            ) from error

    def _may_come_back(self, error: httpx.TransportError) -> bool:
        met = httpx.RemoteProtocolError | httpx.ReadError | httpx.ReadTimeout
        was_there = self._has_answered or isinstance(error, met)
        return was_there and not isinstance(error, httpx.UnsupportedProtocol)


class _Passing(Exception):
    """A refusal that may pass: another service leads, the store is locked, too many ask."""

    def __init__(self, refusal: Exception, retry_after: str):
        super().__init__(str(refusal))
        self.refusal = refusal
        self.seconds = float(retry_after) if retry_after.isdigit() else 0.0


class _Attempts:
    """How often a request was sent, and how long there is still patience."""

    def __init__(self, patience: float):
        self.made = 0
        self._patience = patience
        self._end = math.inf

    def wait(self, seconds: float = 0.0) -> bool:
        """Wait a little longer each time, at least so long; whether there is another attempt."""
        now = time.monotonic()
        if not self.made:
            self._end = now + self._patience
        pause = max(seconds, min(LONGEST_PAUSE, FIRST_PAUSE * 2.0**self.made))
        self.made += 1
        if now + pause > self._end:
            return False
        time.sleep(pause)
        return True


@contextmanager
def _readable(url: str) -> Iterator[None]:
    """An address that is none is no service either."""
    try:
        yield
    except httpx.InvalidURL as error:
        raise Unreachable(f"{url!r} is no address ({error}); write http://HOST:PORT") from error


def _refusal(response: httpx.Response) -> WhippleError:
    """What a problem document says."""
    try:
        problem = response.json()
        findings = [_finding(one) for one in problem.get("errors") or ()]
        more = int(problem.get("more_errors") or 0)
        title, detail = problem["title"], problem.get("detail") or ""
    except (ValueError, KeyError, TypeError, AttributeError):  # not from this service
        findings, more = [], 0
        title, detail = f"HTTP {response.status_code}", response.text[:200]
    if findings:
        return InvalidInput(findings, more=more)
    return ServiceError(response.status_code, title, detail)


def _finding(one: Mapping[str, str]) -> Finding:
    return Finding(*(one[field.name] for field in fields(Finding)))


def _write(response: httpx.Response, file: Path) -> str:
    """Write a body to a file, and return its SHA-256."""
    digest = hashlib.sha256()
    with file.open("wb") as stream:
        for chunk in response.iter_bytes():
            digest.update(chunk)
            stream.write(chunk)
    return digest.hexdigest()
