"""A service from Python: submit a sweep, wait for it, fetch cube and report.

>>> client = Client("http://127.0.0.1:8000")  # doctest: +SKIP
>>> sweep = client.submit("holes.yaml")  # doctest: +SKIP
>>> sweep.wait(); sweep.fetch("holes")  # doctest: +SKIP

A service on another machine needs an API key: ``Client(url, key=...)``, or the environment variable
``WHIPPLE_API_KEY``.
"""

import hashlib
import json
import math
import os
import re
import tempfile
import time
import uuid
import zipfile
from collections.abc import Callable, Iterator, Mapping
from contextlib import nullcontext, suppress
from dataclasses import dataclass
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING, Any, Self, TypedDict, Unpack

import httpx

from service.cli.progress import watched_progress
from service.client.connection import UNIX, Connection, RequestOptions, ServiceError, Unreachable
from service.client.runs import RunDocument
from service.files import SOCKET
from service.files.output_folders import check_same, held_in
from service.notebooks.folder import SweepFolder, sweep_table, table
from service.records.jobs import KEY_VARIABLE, SweepStatus
from solver.errors import WhippleError
from studies.quantities.files import ARCHIVE, CUBE, DIGESTS, RUNS_CSV, SWEEP_FILES
from studies.quantities.findings import Finding, InvalidInput, MissingExtra
from studies.quantities.parameters import Plain
from studies.sweeps.document import document_of

if TYPE_CHECKING:
    from studies.cubes.opening import DataTree
    from studies.notebooks.figures import Figures

__all__ = ["Client", "ServiceError", "StillRunning", "SweepEvent", "SweepHandle", "SweepStatus", "Unreachable"]

DEFAULT_URL = "http://127.0.0.1:8000"
URL_VARIABLE = "WHIPPLE_SERVICE"
DATA_VARIABLE, DEFAULT_DATA = "WHIPPLE_DATA", "whipple-data"  # as in ``service.settings``, which takes 0.15 s
BLOCK = 1 << 18  # bytes of a request for parts of a cube
POLL_SECONDS = 1.0  # interval between two requests of ``wait``
MOST_CANDIDATES = 10  # ids that an ambiguous beginning lists
_PREFIX = re.compile("[0-9a-f]{1,31}")  # beginning of an id, which has 32 digits
PATIENCE = 30.0  # s, for a service that restarts or is busy

SweepSource = Mapping[str, Any] | str | Path  # a sweep, or its YAML or JSON file


class StillRunning(WhippleError):
    """The deadline of a wait passed before the sweep ended."""


@dataclass(frozen=True)
class SweepEvent:
    """A message of an event stream."""

    name: str  # "message": an event; "progress" of a running run; "end": the final state
    number: int | None  # of an event
    content: Mapping[str, Any]


class FileDocument(TypedDict):
    """A stored file of a run."""

    name: str
    size: int  # bytes
    sha256: str
    href: str


class PointRun(TypedDict):
    """The run of a point, as far as the client reads it."""

    id: str
    state: str
    attempt: int
    cause: str | None
    reason: str | None


class PointDocument(TypedDict):
    """A point of a sweep, and its run."""

    ordinal: int
    state: str
    coordinates: Mapping[str, float | str]  # SI
    run: PointRun


class QueueDocument(TypedDict):
    """The queue as a whole."""

    paused: str | None
    blocked_reason: str | None
    deletion_paused: str | None
    counts: Mapping[str, int]
    oldest_queued: str | None
    leader: str | None


class Client:
    """A service at ``url``, by default at ``WHIPPLE_SERVICE``, else of the data directory, else on this machine."""

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
            url or os.environ.get(URL_VARIABLE) or _own_socket() or DEFAULT_URL,
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
        """Close the connections."""
        self._connection.close()

    def submit(
        self, sweep: SweepSource, *, priority: int = 0, keep: str = "final", idempotency_key: str | None = None
    ) -> "SweepHandle":
        """Submit a document, or the YAML or JSON file at a path; raises InvalidInput with findings.

        Sweeps of smaller ``priority`` (-100 to 100) are computed first. ``keep`` selects the files kept for each
        run: ``numbers``, also the ``final`` state, or also the ``film``. Submissions with one
        ``idempotency_key`` are one sweep; by default each call uses a new key, so that a connection may break.
        """
        headers = {"Idempotency-Key": idempotency_key or uuid.uuid4().hex}
        query = {"priority": str(priority), "keep": keep}
        options: RequestOptions = {**_body(sweep, headers=headers), "params": query}
        body = self._connection.json("POST", "/v1/sweeps", **options)
        return SweepHandle(self, body["id"])

    def estimate(self, sweep: SweepSource) -> dict[str, Plain]:
        """The cost of a sweep: runs, reused, core_seconds, seconds, bytes, and presets."""
        return self._connection.json("POST", "/v1/sweeps/estimate", **_body(sweep))

    def sweep(self, id: str) -> "SweepHandle":
        """The sweep of an id; its first request reports whether it exists."""
        return SweepHandle(self, id)

    def find_sweep(self, prefix: str) -> "SweepHandle":
        """The sweep whose id begins so; raises InvalidInput with the candidates if they are several."""
        return self.sweep(self._whole_id("sweeps", prefix, "name"))

    def sweeps(self, state: str | None = None) -> Iterator[SweepStatus]:
        """Every sweep, newest first; or those in a state."""
        return map(SweepStatus.from_json, self._connection.pages("/v1/sweeps", state=state))

    def run(self, id: str) -> RunDocument:
        """A run with its parameters."""
        return RunDocument(self._connection.json("GET", f"/v1/runs/{id}"), self._connection)

    def find_run(self, prefix: str) -> str:
        """The id of the run whose id begins so; raises InvalidInput with the candidates if they are several."""
        return self._whole_id("runs", prefix, "state")

    def run_files(self, id: str) -> list[FileDocument]:
        """The stored files of a run: name, size, sha256."""
        return self._items(f"runs/{id}/files")

    def fetch_run(self, id: str, out: str | Path) -> Path:
        """Download every file of a run into a folder, which is returned."""
        folder = _folder(out)
        for file in self.run_files(id):
            self._connection.download(file["href"], folder / file["name"])
        return folder

    def log(self, id: str) -> str:
        """The output of the solver in the last attempt of a run, up to now."""
        return self._connection.request("GET", f"/v1/runs/{id}/log").text

    def queue(self) -> QueueDocument:
        """The queue as a whole: paused, blocked_reason, counts, oldest_queued, leader."""
        return self._connection.json("GET", "/v1/queue")

    def pause(self) -> QueueDocument:
        """Start no more runs; running ones continue."""
        return self._connection.json("POST", "/v1/queue/pause")

    def resume(self) -> QueueDocument:
        """Start runs again."""
        return self._connection.json("POST", "/v1/queue/resume")

    def scenarios(self) -> list[dict[str, Plain]]:
        """Every scenario with its parameters."""
        return self._items("scenarios")

    def materials(self) -> list[dict[str, Plain]]:
        """Every material that ships."""
        return self._items("materials")

    def laws(self) -> list[dict[str, Plain]]:
        """Every law."""
        return self._items("laws")

    def _whole_id(self, kind: str, prefix: str, label: str) -> str:
        """The only id that begins so; what is no prefix of an id stays as it is, for the service to refuse."""
        if not _PREFIX.fullmatch(prefix):
            return prefix
        query = {"prefix": prefix, "limit": str(MOST_CANDIDATES)}
        items = self._items(kind, params=query)
        if len(items) > 1:
            candidates = ", ".join(f"{item['id'][:16]} ({item[label]})" for item in items)
            cure = f"write more of it: {candidates}"
            raise InvalidInput([Finding("ID", prefix, "the beginning of one id", cure)])
        return items[0]["id"] if items else prefix

    def _items(self, path: str, **options: Unpack[RequestOptions]) -> list[Any]:
        return self._connection.json("GET", f"/v1/{path}", **options)["items"]


def _own_socket() -> str | None:
    """The address of the socket in the data directory, if there is one that this user made."""
    place = Path(os.environ.get(DATA_VARIABLE) or DEFAULT_DATA) / SOCKET
    with suppress(OSError):
        if place.is_socket() and place.stat().st_uid == os.geteuid():
            return f"{UNIX}{place}"
    return None


class SweepHandle:
    """A sweep of a service."""

    def __init__(self, client: Client, id: str):
        self.client = client
        self.id = id
        self._connection = client._connection
        self._path = f"/v1/sweeps/{id}"

    def __repr__(self) -> str:
        return f"SweepHandle({self.client.url!r}, {self.id!r})"

    def _repr_html_(self) -> str:
        """The sweep as it stands, for a notebook; its address alone where the service does not respond."""
        try:
            return sweep_table(self.status(), f"{self.client.url}{self._path}/report.html")
        except WhippleError as error:
            return table(repr(self), [("error", error)])

    def status(self) -> SweepStatus:
        """State, points by state, progress, time left."""
        return SweepStatus.from_json(self._connection.json("GET", self._path))

    def document(self) -> dict[str, Plain]:
        """The sweep in its canonical form, which can be submitted again."""
        return self._connection.json("GET", f"{self._path}/document")

    def runs(self, state: str | None = None) -> Iterator[PointDocument]:
        """The points with their runs, in the sweep's own order; for example the ``failed`` ones."""
        return self._connection.pages(f"{self._path}/runs", state=state)

    def wait(
        self, timeout: float | None = None, on_progress: Callable[[SweepStatus], None] | None = None
    ) -> SweepStatus:
        """Wait until the sweep has ended; raises StillRunning after ``timeout`` seconds.

        ``on_progress`` is called with each status. Without it a bar shows the progress on a terminal and in a
        notebook, and nothing does elsewhere.
        """
        deadline = math.inf if timeout is None else time.monotonic() + timeout
        with watched_progress(self.status().name) if on_progress is None else nullcontext(on_progress) as show:
            while True:
                status = self.status()
                show(status)
                if status.is_terminal:
                    return status
                if time.monotonic() > deadline:
                    raise StillRunning(f"sweep {self.id} is {status.state} after {timeout:g} s")
                time.sleep(POLL_SECONDS)

    def events(self, after: int | None = None) -> Iterator[SweepEvent]:
        """Events of the sweep and its runs: those after a number, then new ones, until the sweep has ended.

        A stream that breaks is resumed.
        """
        last_id = None if after is None else str(after)
        for message in self._connection.events(f"{self._path}/events", after=last_id):
            number = None if message.id is None else int(message.id)
            yield SweepEvent(message.name, number, json.loads(message.data))

    def fetch(self, out: str | Path, *, overwrite: bool = False, every_column: bool = False) -> Path:
        """Download cube and report into a folder, which is returned; raises ServiceError before they exist.

        A folder that holds another sweep is refused (InvalidInput), unless ``overwrite`` is set. With ``every_column``
        ``runs.csv`` has every column.
        """
        folder = _folder(out)
        held = held_in(folder)
        if held is not None and not overwrite:
            check_same(folder, held, self.document())
        for name in SWEEP_FILES:
            query = "?all=true" if every_column and name == RUNS_CSV else ""
            self._connection.download(f"{self._path}/{name}{query}", folder / name)
        return folder

    def fetch_archive(self, file: str | Path) -> Path:
        """Download every file of the sweep and of its runs as one ZIP file; each is checked against its digest."""
        _folder(Path(file).parent)
        return self._connection.download(f"{self._path}/{ARCHIVE}", Path(file), check=_check_archive)

    def open_cube(self) -> "DataTree":
        """The cube, opened remotely: accessed values are loaded, not the file.

        A retry replaces the file: open it again afterwards. Raises ServiceError, and MissingExtra if the
        libraries are not installed.
        """
        import studies.notebooks.figures  # noqa: F401 # its figures: cube.whipple

        if self.client.url.startswith(UNIX):
            cure = f"fetch the cube, or set {URL_VARIABLE} and {KEY_VARIABLE}"
            raise InvalidInput([Finding("url", self.client.url, "http://HOST:PORT, for parts of a cube", cure)])
        # Reports why there is no cube.
        self._connection.request("GET", f"{self._path}/cube.nc", headers={"Range": "bytes=0-0"})
        return open_remote(f"{self.client.url}{self._path}/cube.nc", self._connection.headers)

    def plot(self) -> "Figures":
        """The figures of the report, drawn from the cube, which is downloaded; raises ServiceError without one."""
        with tempfile.TemporaryDirectory() as folder:
            self._connection.download(f"{self._path}/{CUBE}", Path(folder) / CUBE)
            return SweepFolder(folder).plot()

    def cancel(self) -> SweepStatus:
        """Stop the sweep; the results so far are published."""
        return self._command("POST", "/cancel")

    def retry(self, *, verdicts: bool = False) -> SweepStatus:
        """Compute cancelled, failed and lost runs again; ``verdicts``: also those that the solver rejected."""
        return self._command("POST", "/retry", params={"verdicts": str(verdicts).lower()})

    def prioritise(self, priority: int) -> SweepStatus:
        """Change the priority: sweeps of smaller numbers are computed first; running runs continue."""
        return self._command("PATCH", "", json={"priority": priority})

    def pin(self, *, pinned: bool = True) -> SweepStatus:
        """Keep the sweep from being deleted, or no longer."""
        return self._command("PUT" if pinned else "DELETE", "/pin")

    def delete(self) -> None:
        """Delete the sweep, which must have ended."""
        self._connection.json("DELETE", self._path)

    def _command(self, method: str, path: str, **options: Unpack[RequestOptions]) -> SweepStatus:
        return SweepStatus.from_json(self._connection.json(method, f"{self._path}{path}", **options))


def open_remote(url: str, headers: Mapping[str, str]) -> "DataTree":
    """The dataset at an address; closing it closes the connection. Raises MissingExtra and InvalidInput."""
    try:
        import fsspec

        # fsspec and xarray would import these later.
        for name in ("aiohttp", "h5netcdf"):
            import_module(name)
    except ImportError as error:
        raise MissingExtra(
            f"opening a cube remotely needs more libraries ({error}): pip install 'whipple[remote]'; or fetch the cube"
        ) from None
    from studies.cubes.opening import open_file

    file = fsspec.open(url, cache_type="blockcache", block_size=BLOCK, headers=dict(headers))
    return open_file(file.open(), url)


def _body(sweep: SweepSource, headers: Mapping[str, str] | None = None) -> RequestOptions:
    """Body and headers of a submission; values that JSON lacks are sent as text, which the service refuses."""
    content = json.dumps(document_of(sweep), default=str).encode()
    return {"content": content, "headers": {"Content-Type": "application/json", **(headers or {})}}


def _check_archive(file: Path) -> None:
    """Raise ServiceError unless an archive has the files, with the digests, that it says."""
    with zipfile.ZipFile(file) as archive:
        expected = dict(line.split("  ", 1)[::-1] for line in archive.read(DIGESTS).decode().splitlines())
        received = {}
        for name in {*archive.namelist()} - {DIGESTS}:
            with archive.open(name) as stored:
                received[name] = hashlib.file_digest(stored, "sha256").hexdigest()  # type: ignore[arg-type]
    if wrong := sorted(name for name in {*expected, *received} if expected.get(name) != received.get(name)):
        raise ServiceError(200, "Damaged download", f"{wrong[0]} of the archive: the digest is wrong")


def _folder(out: str | Path) -> Path:
    folder = Path(out)
    folder.mkdir(parents=True, exist_ok=True)
    return folder
