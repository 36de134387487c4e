"""A service from Python: submit a sweep, wait for it, fetch cube and report.

>>> client = Client("http://127.0.0.1:8000")  # doctest: +SKIP
>>> sweep = client.submit("holes.yaml")  # doctest: +SKIP
>>> sweep.wait(); sweep.fetch("holes")  # doctest: +SKIP

Elsewhere than on the service's own machine it needs an API key: ``Client(url, key=...)``, or the
environment variable ``WHIPPLE_API_KEY``.
"""

import json
import os
import time
import uuid
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, fields
from pathlib import Path
from typing import TYPE_CHECKING, Any, Self

import httpx

from service.client.connection import Connection, ServiceError, Unreachable
from service.files.output_folders import check_same, held_in
from solver.errors import WhippleError
from studies.values.files import SWEEP_FILES

if TYPE_CHECKING:
    from studies.values.opening import Dataset

__all__ = [
    "Client",
    "Happening",
    "ServiceError",
    "StillRunning",
    "SweepHandle",
    "SweepStatus",
    "Unreachable",
]

DEFAULT_URL = "http://127.0.0.1:8000"
URL_VARIABLE = "WHIPPLE_SERVICE"
KEY_VARIABLE = "WHIPPLE_API_KEY"
TERMINAL = frozenset({"succeeded", "failed", "cancelled"})
POLL_SECONDS = 1.0  # how often ``wait`` asks
PATIENCE = 30.0  # s, for a service that has answered and is gone, or too busy

Document = Mapping[str, Any] | str | Path  # of a sweep, or its YAML or JSON file


class StillRunning(WhippleError):
    """The deadline of a wait passed before the sweep ended."""


@dataclass(frozen=True)
class SweepStatus:
    """A sweep at one moment; the words are those of the interface."""

    id: str
    name: str
    scenario: str
    owner: str
    priority: int
    keep: str
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
    def of(cls, answer: Mapping[str, Any]) -> Self:
        """The part of an answer that has a name here."""
        return cls(**{field.name: answer[field.name] for field in fields(cls)})

    @property
    def is_terminal(self) -> bool:
        """Nothing will change any more unless somebody asks."""
        return self.state in TERMINAL


@dataclass(frozen=True)
class Happening:
    """Something told in an event stream."""

    name: str  # "message": an event; "progress" of a running run; "end": how it ended
    number: int | None  # of an event
    content: Mapping[str, Any]


class Client:
    """A service at an address; without one, at that in ``WHIPPLE_SERVICE``, else on this machine."""

    def __init__(
        self,
        url: str | None = None,
        *,
        key: str | None = None,
        timeout: float = 60.0,
        patience: float = PATIENCE,
        transport: httpx.BaseTransport | None = None,
    ):
        self._connection = Connection(
            url or os.environ.get(URL_VARIABLE) or DEFAULT_URL,
            key=key or os.environ.get(KEY_VARIABLE) or None,
            timeout=timeout,
            patience=patience,
            transport=transport,
        )
        self.url = self._connection.url

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def close(self) -> None:
        """Give the connections back."""
        self._connection.close()

    # --- sweeps ----------------------------------------------------------------------------------

    def submit(
        self,
        sweep: Document,
        *,
        priority: int = 0,
        keep: str = "final",
        idempotency_key: str | None = None,
    ) -> "SweepHandle":
        """Submit a document, or the YAML or JSON file at a path; raises InvalidInput with findings.

        ``priority``: smaller is sooner, -100 to 100. ``keep``: ``numbers``, also the ``final`` state,
        also the ``film`` of each run. Whatever is sent with one ``idempotency_key`` is one sweep; without
        one, each call makes a key of its own, so that a connection that breaks does no harm.
        """
        headers = {"Idempotency-Key": idempotency_key or uuid.uuid4().hex}
        query = {"priority": str(priority), "keep": keep}
        answer = self._connection.json(
            "POST", "/v1/sweeps", params=query, **_body(sweep, headers=headers)
        )
        return SweepHandle(self, answer["id"])

    def estimate(self, sweep: Document) -> dict[str, Any]:
        """What a sweep would cost: runs, reused, core_seconds, seconds, bytes, and presets."""
        return self._connection.json("POST", "/v1/sweeps/estimate", **_body(sweep))

    def sweep(self, id: str) -> "SweepHandle":
        """The sweep of an id; whether there is one shows when it is asked."""
        return SweepHandle(self, id)

    def sweeps(self, state: str | None = None) -> Iterator[SweepStatus]:
        """Every sweep, the youngest first; or those in a state."""
        query = {} if state is None else {"state": state}
        return map(SweepStatus.of, self._connection.pages("/v1/sweeps", **query))

    # --- runs ------------------------------------------------------------------------------------

    def run(self, id: str) -> dict[str, Any]:
        """A run with its question."""
        return self._connection.json("GET", f"/v1/runs/{id}")

    def run_files(self, id: str) -> list[dict[str, Any]]:
        """The files that are kept of a run: name, size, sha256."""
        return self._connection.json("GET", f"/v1/runs/{id}/files")["items"]

    def fetch_run(self, id: str, out: str | Path) -> Path:
        """Every file of a run into a folder, which is returned."""
        folder = _folder(out)
        for file in self.run_files(id):
            self._connection.download(file["href"], folder / file["name"])
        return folder

    def log(self, id: str) -> str:
        """What the solver printed in the last attempt of a run; of a running one, until now."""
        return self._connection.text(f"/v1/runs/{id}/log")

    # --- the queue -------------------------------------------------------------------------------

    def queue(self) -> dict[str, Any]:
        """The queue as a whole: paused, blocked_reason, counts, oldest_queued, leader."""
        return self._connection.json("GET", "/v1/queue")

    def pause(self) -> dict[str, Any]:
        """Begin no more runs; those under way go on."""
        return self._connection.json("POST", "/v1/queue/pause")

    def resume(self) -> dict[str, Any]:
        """Begin runs again."""
        return self._connection.json("POST", "/v1/queue/resume")

    # --- catalogue -------------------------------------------------------------------------------

    def scenarios(self) -> list[dict[str, Any]]:
        """Every scenario with its parameters."""
        return self._items("scenarios")

    def materials(self) -> list[dict[str, Any]]:
        """Every material that ships."""
        return self._items("materials")

    def laws(self) -> list[dict[str, Any]]:
        """Every law."""
        return self._items("laws")

    def accuracies(self) -> list[dict[str, Any]]:
        """Every preset of resolutions and offsets."""
        return self._items("accuracies")

    def _items(self, kind: str) -> list[dict[str, Any]]:
        return self._connection.json("GET", f"/v1/{kind}")["items"]


class SweepHandle:
    """A sweep of a service."""

    def __init__(self, client: Client, id: str):
        self.client = client
        self.id = id
        self._connection = client._connection
        self._path = f"/v1/sweeps/{id}"

    def __repr__(self) -> str:
        return f"SweepHandle({self.client.url!r}, {self.id!r})"

    # --- look ------------------------------------------------------------------------------------

    def status(self) -> SweepStatus:
        """State, points by state, progress, time left."""
        return SweepStatus.of(self._connection.json("GET", self._path))

    def document(self) -> dict[str, Any]:
        """The sweep in its canonical form; it can be submitted again."""
        return self._connection.json("GET", f"{self._path}/document")

    def runs(self, state: str | None = None) -> Iterator[dict[str, Any]]:
        """The points with their runs, in the sweep's own order; for instance the ``failed`` ones."""
        query = {} if state is None else {"state": state}
        return self._connection.pages(f"{self._path}/runs", **query)

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

    def events(self, after: int | None = None) -> Iterator[Happening]:
        """What happened to the sweep and its runs, behind the event of a number, and what happens.

        Ends when the sweep has. A stream that breaks is taken up again where it was.
        """
        place = None if after is None else str(after)
        for message in self._connection.events(f"{self._path}/events", after=place):
            number = None if message.id is None else int(message.id)
            yield Happening(message.name, number, json.loads(message.data))

    def watch(self, tell: Callable[[Happening], object]) -> SweepStatus:
        """Tell all that happens, as it happens, until the sweep has ended; how it ended."""
        for happening in self.events():
            tell(happening)
        return self.status()

    # --- files -----------------------------------------------------------------------------------

    def fetch(self, out: str | Path, *, overwrite: bool = False) -> Path:
        """Cube and report into a folder, which is returned; raises ServiceError if they are not there yet.

        A folder that holds another sweep is refused (InvalidInput), unless that is to be replaced
        (``overwrite``).
        """
        folder = _folder(out)
        held = held_in(folder)
        if held is not None and not overwrite:
            check_same(folder, held, self.document())
        for name in SWEEP_FILES:
            self._connection.download(f"{self._path}/{name}", folder / name)
        return folder

    def open_cube(self) -> "Dataset":
        """The cube, opened where it is: what is looked at is loaded, not the file.

        After a retry another file has its address: open it again then. Raises ServiceError, and
        MissingExtra where the libraries for it are not installed.
        """
        from service.client.remote_cube import open_remote

        first = {"Range": "bytes=0-0"}
        self._connection.text(f"{self._path}/cube.nc", headers=first)  # says why, if there is none
        return open_remote(f"{self.client.url}{self._path}/cube.nc", self._connection.headers)

    # --- orders ----------------------------------------------------------------------------------

    def cancel(self) -> SweepStatus:
        """Stop; what was computed until now is published."""
        return self._order("POST", "/cancel")

    def retry(self, *, verdicts: bool = False) -> SweepStatus:
        """Compute again what an accident or a cancel ended (``verdicts``: what the solver gave up, too)."""
        return self._order("POST", "/retry", params={"verdicts": str(verdicts).lower()})

    def prioritise(self, priority: int) -> SweepStatus:
        """Let it come sooner (smaller) or later; runs under way go on."""
        return self._order("PATCH", "", json={"priority": priority})

    def delete(self) -> None:
        """Forget the sweep, which has to have ended."""
        self._connection.json("DELETE", self._path)

    def _order(self, method: str, path: str, **given: Any) -> SweepStatus:
        return SweepStatus.of(self._connection.json(method, f"{self._path}{path}", **given))


def _body(sweep: Document, headers: Mapping[str, str] | None = None) -> dict[str, Any]:
    """Body and headers for a sweep; what JSON cannot say stays text, and is refused there with its place."""
    content = json.dumps(_document(sweep), default=str).encode()
    return {"content": content, "headers": {"Content-Type": "application/json", **(headers or {})}}


def _document(sweep: Document) -> Mapping[str, Any]:
    if isinstance(sweep, Mapping):
        return sweep
    from studies.sweeps.document import read_sweep_file

    return read_sweep_file(Path(sweep))


def _folder(out: str | Path) -> Path:
    folder = Path(out)
    folder.mkdir(parents=True, exist_ok=True)
    return folder
