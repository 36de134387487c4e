"""A service from Python: submit a sweep, wait for it, fetch cube and report.

>>> client = Client("http://127.0.0.1:8000")  # doctest: +SKIP
>>> sweep = client.submit("holes.yaml")  # doctest: +SKIP
>>> sweep.wait(); sweep.fetch("holes")  # doctest: +SKIP
"""

import hashlib
import json
import os
import time
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, fields
from pathlib import Path
from typing import Any

import httpx

from solver.errors import WhippleError
from studies.errors import Finding, InvalidInput

DEFAULT_URL = "http://127.0.0.1:8000"
FILES = ("cube.nc", "report.html", "report.json")
TERMINAL = frozenset({"succeeded", "failed", "cancelled"})
POLL_SECONDS = 1.0  # how often ``wait`` asks


class ServiceError(WhippleError):
    """The service refused, or failed; ``status`` is the HTTP status."""

    def __init__(self, status: int, title: str, detail: str):
        super().__init__(f"{title}: {detail}" if detail else title)
        self.status = status


class Unreachable(WhippleError):
    """No service answers at this address."""


class StillRunning(WhippleError):
    """The deadline of a wait passed before the sweep ended."""


@dataclass(frozen=True)
class SweepStatus:
    """A sweep at one moment; the words are those of the interface."""

    id: str
    name: str
    scenario: str
    state: str
    reason: str | None  # why cube and report could not be made
    planned: int
    reused: int
    new: int
    counts: Mapping[str, int]  # points by state
    progress: float  # 0 to 1
    eta_seconds: float | None
    links: Mapping[str, str]

    @classmethod
    def of(cls, answer: Mapping[str, Any]) -> "SweepStatus":
        """The part of an answer that has a name here."""
        return cls(**{field.name: answer[field.name] for field in fields(cls)})

    @property
    def is_terminal(self) -> bool:
        """Nothing will change any more unless somebody asks."""
        return self.state in TERMINAL


class Client:
    """A service at an address."""

    def __init__(
        self,
        url: str = DEFAULT_URL,
        *,
        timeout: float = 60.0,
        transport: httpx.BaseTransport | None = None,
    ):
        self.url = url.rstrip("/")
        self._http = httpx.Client(base_url=self.url, timeout=timeout, transport=transport)

    def __enter__(self) -> "Client":
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def close(self) -> None:
        """Give the connections back."""
        self._http.close()

    def submit(self, sweep: Mapping[str, Any] | str | Path) -> "SweepHandle":
        """Submit a document, or the YAML or JSON file at a path; raises InvalidInput with findings."""
        answer = self._json("POST", "/v1/sweeps", **_body(sweep))
        return SweepHandle(self, answer["id"])

    def estimate(self, sweep: Mapping[str, Any] | str | Path) -> dict[str, Any]:
        """What a sweep would cost: runs, reused, core_seconds, seconds, bytes, and presets."""
        return self._json("POST", "/v1/sweeps/estimate", **_body(sweep))

    def sweep(self, id: str) -> "SweepHandle":
        """The sweep of an id; whether there is one shows when it is asked."""
        return SweepHandle(self, id)

    def sweeps(self) -> Iterator[SweepStatus]:
        """Every sweep, the youngest first."""
        return map(SweepStatus.of, self._pages("/v1/sweeps"))

    def run(self, id: str) -> dict[str, Any]:
        """A run with its question."""
        return self._json("GET", f"/v1/runs/{id}")

    def scenarios(self) -> list[dict[str, Any]]:
        """Every scenario with its parameters."""
        return self._json("GET", "/v1/scenarios")["items"]

    def materials(self) -> list[dict[str, Any]]:
        """Every material that ships."""
        return self._json("GET", "/v1/materials")["items"]

    def laws(self) -> list[dict[str, Any]]:
        """Every law."""
        return self._json("GET", "/v1/laws")["items"]

    def accuracies(self) -> list[dict[str, Any]]:
        """Every preset of resolutions and offsets."""
        return self._json("GET", "/v1/accuracies")["items"]

    def _json(self, method: str, path: str, **given: Any) -> Any:
        with _reaching(self.url):
            response = self._http.request(method, path, **given)
        _check(response)
        return response.json() if response.content else None

    def _pages(self, path: str, **query: str) -> Iterator[dict[str, Any]]:
        cursor: dict[str, str] = {}
        while True:
            page = self._json("GET", path, params=query | cursor)
            yield from page["items"]
            if page["next_cursor"] is None:
                return
            cursor = {"cursor": page["next_cursor"]}

    def _download(self, path: str, file: Path) -> None:
        """Stream a file to its place: whole and with the right digest, or not at all."""
        partial = file.with_name(f".{file.name}.{os.getpid()}.tmp")
        try:
            with _reaching(self.url), self._http.stream("GET", path) as response:
                if response.is_error:
                    response.read()
                _check(response)
                digest = _write(response, partial)
            if f'"{digest}"' != response.headers.get("etag"):
                raise ServiceError(200, "The download is damaged", f"{path}: the digest differs")
            partial.replace(file)
        finally:
            partial.unlink(missing_ok=True)


class SweepHandle:
    """A sweep of a service."""

    def __init__(self, client: Client, id: str):
        self.client = client
        self.id = id
        self._path = f"/v1/sweeps/{id}"

    def __repr__(self) -> str:
        return f"SweepHandle({self.client.url!r}, {self.id!r})"

    def status(self) -> SweepStatus:
        """State, points by state, progress, time left."""
        return SweepStatus.of(self.client._json("GET", self._path))

    def document(self) -> dict[str, Any]:
        """The sweep in its canonical form; it can be submitted again."""
        return self.client._json("GET", f"{self._path}/document")

    def wait(
        self,
        timeout: float | None = None,
        on_progress: Callable[[SweepStatus], None] = lambda status: None,
    ) -> SweepStatus:
        """Wait until the sweep has ended; raises StillRunning after ``timeout`` seconds."""
        deadline = None if timeout is None else time.monotonic() + timeout
        while True:
            status = self.status()
            on_progress(status)
            if status.is_terminal:
                return status
            if deadline is not None and time.monotonic() > deadline:
                raise StillRunning(f"sweep {self.id} is {status.state} after {timeout:g} s")
            time.sleep(POLL_SECONDS)

    def runs(self, state: str | None = None) -> Iterator[dict[str, Any]]:
        """The points with their runs, in the sweep's own order; for instance the ``failed`` ones."""
        query = {} if state is None else {"state": state}
        return self.client._pages(f"{self._path}/runs", **query)

    def fetch(self, out: str | Path) -> Path:
        """Cube and report into a folder, which is returned; raises ServiceError if they are not there yet."""
        folder = Path(out)
        folder.mkdir(parents=True, exist_ok=True)
        for name in FILES:
            self.client._download(f"{self._path}/{name}", folder / name)
        return folder

    def cancel(self) -> SweepStatus:
        """Stop; what was computed until now is published."""
        return SweepStatus.of(self.client._json("POST", f"{self._path}/cancel"))

    def retry(self, *, verdicts: bool = False) -> SweepStatus:
        """Compute again what an accident or a cancel ended (``verdicts``: what the solver gave up, too)."""
        query = {"verdicts": str(verdicts).lower()}
        return SweepStatus.of(self.client._json("POST", f"{self._path}/retry", params=query))

    def delete(self) -> None:
        """Forget the sweep, which has to have ended."""
        self.client._json("DELETE", self._path)


@contextmanager
def _reaching(url: str) -> Iterator[None]:
    """Turn a failed connection into Unreachable."""
    try:
        yield
    except (httpx.TransportError, httpx.InvalidURL, httpx.UnsupportedProtocol) as error:
        raise Unreachable(
            f"no answer from {url} ({error}); is `whipple serve` running there?"
        ) from error


def _body(sweep: Mapping[str, Any] | str | Path) -> dict[str, Any]:
    """Body and headers for a sweep; what JSON cannot say stays text, and is refused there with its place."""
    content = json.dumps(_document(sweep), default=str).encode()
    return {"content": content, "headers": {"Content-Type": "application/json"}}


def _document(sweep: Mapping[str, Any] | str | Path) -> Mapping[str, Any]:
    if isinstance(sweep, Mapping):
        return sweep
    from studies.sweep_document import read_sweep_file

    return read_sweep_file(Path(sweep))


def _check(response: httpx.Response) -> None:
    """Raise what a problem document says."""
    if not response.is_error:
        return
    try:
        problem = response.json()
        findings = [_finding(one) for one in problem.get("errors") or ()]
        title, detail = problem["title"], problem.get("detail") or ""
    except (ValueError, KeyError, TypeError, AttributeError):  # not from this service
        findings, title, detail = [], f"HTTP {response.status_code}", response.text[:200]
    if findings:
        raise InvalidInput(findings)
    raise ServiceError(response.status_code, title, detail)


def _finding(one: Mapping[str, str]) -> Finding:
    return Finding(*(one[field.name] for field in fields(Finding)))


def _write(response: httpx.Response, file: Path) -> str:
    """Write a body to a file, to the disk, and return its SHA-256."""
    digest = hashlib.sha256()
    with file.open("wb") as stream:
        for chunk in response.iter_bytes():
            digest.update(chunk)
            stream.write(chunk)
        stream.flush()
        os.fsync(stream.fileno())
    return digest.hexdigest()
