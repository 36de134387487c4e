"""Files that are made when they are asked for, each by a child process and cached under the digest of its inputs: cubes
and reports of unfinished sweeps, results in the formats of other programs, and what pages draw of a run.

The API process opens no dataset, because netCDF4 crashes when threads share it. Few children work at once, for each
caller one, and whoever waits for them has no turn and no thread.
"""

import hashlib
import json
import logging
import math
import os
import resource
import shutil
import sys
import time
from collections.abc import AsyncIterator, Awaitable, Callable, Mapping, Sequence
from contextlib import asynccontextmanager, suppress
from dataclasses import dataclass, replace
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, TypedDict, Unpack

import anyio
from pydantic import JsonValue
from starlette.concurrency import run_in_threadpool

from service import version
from service.api.errors import Busy, ConversionFailed, NotAvailable
from service.api.turns import Places, Turn
from service.files.artifacts import Artifacts, digest
from service.records.jobs import Outcome, State, Stored
from service.workers.warm import environment
from solver.registry import points
from studies.quantities.files import write_text
from studies.quantities.findings import MissingExtra

if TYPE_CHECKING:
    from studies.runs.run import RunSpec

log = logging.getLogger(__name__)

SECONDS = 120  # limit for one file, including a second of imports
MEMORY = 2 << 30  # bytes of data of the child
MOST_FILES, MOST_BYTES = 100, 2 << 30  # in the cache; the least recently used are removed
MOST_AT_ONCE = 2  # children, of as many callers
MOST_WAITING, MOST_WAITING_OF_A_CALLER = 64, 8  # requests
WAIT_SECONDS = 30.0  # for which a request waits until its file is begun, or another request has made it
NICENESS = 5  # nice(2) of a child, as of one that reads documents: the process that answers requests comes first
LARGE = 500  # points of a sweep whose results so far take seconds to put together,
PART_SECONDS = 60.0  # and are put together once in this time
MARK = ".sha256"
REFUSED = 3  # exit status of a child that cannot make the file, and says why in its output
# States of a run in a cube that differ from those of the queue.
CUBE_STATES = {State.QUEUED: "pending", State.CANCELLING: "running"}
PARTIAL, PARTIAL_REPORT = "partial.nc", "partial.html"


class FileOptions(TypedDict, total=False):
    """How a file is made: what the colours of a film show, or the run of a view."""

    field: str
    run: "RunSpec"


class FileInputs(TypedDict, total=False):
    """The inputs of a file that a child process makes: results so far, or stored files."""

    document: Mapping[str, JsonValue]
    outcomes: Sequence[Outcome]
    state: str
    files: Mapping[str, tuple[str, str]]  # path and SHA-256, by name
    options: FileOptions


@dataclass(frozen=True)
class MadeFile:
    """A file of the cache."""

    path: Path
    sha256: str
    age: float | None = None  # s; of results so far that were put together for an earlier request


class Conversions:
    """The cache of these files; each caller makes one at a time."""

    def __init__(
        self,
        folder: Path,
        *,
        seconds: float = SECONDS,
        memory: int = MEMORY,
        wait_seconds: float = WAIT_SECONDS,
        part_seconds: float = PART_SECONDS,
    ):
        self._folder = folder
        self._seconds, self._wait_seconds, self._part_seconds = seconds, wait_seconds, part_seconds
        self._memory = memory
        self._places = Places(MOST_AT_ONCE, 1, waiting=MOST_WAITING, waiting_of_a_caller=MOST_WAITING_OF_A_CALLER)
        self._under_way: dict[Path, anyio.Event] = {}
        # The results so far of large sweeps, by sweep and kind, with the time (monotonic) when they were made.
        self._parts: dict[tuple[str, str], tuple[float, MadeFile]] = {}

    async def partial(
        self, kind: str, sweep: str, gather: Callable[[], FileInputs], turn: Turn, *, is_large: bool
    ) -> MadeFile:
        """The cube (or the report) of the results so far of a sweep, which ``gather`` names; raises as ``file`` does.

        That of a large sweep is made once a minute: until then it is the last one.
        """

        async def latest() -> MadeFile | None:
            return await self._latest_part(sweep, kind) if is_large else None

        part = await latest()
        if part is not None:
            return part
        made = await self._file(kind, await run_in_threadpool(gather), turn, latest)
        if made.age is None:
            now = time.monotonic()
            recent = {key: part for key, part in self._parts.items() if now - part[0] < self._part_seconds}
            self._parts = {**recent, (sweep, kind): (now, made)}
        return made

    async def file(
        self, kind: str, sources: Sequence[Stored], artifacts: Artifacts, turn: Turn, **options: Unpack[FileOptions]
    ) -> MadeFile:
        """The file of a kind (``makers``) made from stored files that are on the disk.

        Raises Busy, TooManyRequests, ConversionFailed, and NotAvailable where this service lacks what it takes.
        """
        files = {source.name: (str(artifacts.path(source)), source.sha256) for source in sources}
        return await self._file(kind, {"files": files, "options": options}, turn)

    async def _latest_part(self, sweep: str, kind: str) -> MadeFile | None:
        """The latest results so far, if they are whole and not a minute old."""
        ended, made = self._parts.get((sweep, kind), (-math.inf, None))
        age = time.monotonic() - ended
        if made is None or age >= self._part_seconds or await run_in_threadpool(_whole, made.path) is None:
            return None
        return replace(made, age=age)

    async def _file(
        self, kind: str, inputs: FileInputs, turn: Turn, other: Callable[[], Awaitable[MadeFile | None]] | None = None
    ) -> MadeFile:
        """The file of these inputs, or the ``other`` one that was made while it waited."""
        text = await run_in_threadpool(json.dumps, inputs)
        name = hashlib.sha256(f"{version()}\n{text}".encode()).hexdigest()
        file = self._folder / f"{name}.{kind}"
        try:
            sha256 = await run_in_threadpool(_whole, file)
            if sha256 is None:
                async with turn.waiting(), self._place(file, turn.caller):
                    made = None if other is None else await other()
                    if made is not None:
                        return made
                    sha256 = await self._make(file, text)
        except FileNotFoundError:
            raise ConversionFailed("the data directory, or the file, was removed") from None
        return MadeFile(file, sha256)

    @asynccontextmanager
    async def _place(self, file: Path, caller: str) -> AsyncIterator[None]:
        """A place to make a file that nobody else makes meanwhile; raises Busy, TooManyRequests."""
        try:
            with anyio.fail_after(self._wait_seconds):
                await self._places.acquire(caller)
                while file in self._under_way:
                    self._places.release(caller)
                    await self._under_way[file].wait()
                    await self._places.acquire(caller)
        except TimeoutError:
            raise Busy("other files are being made") from None
        ended = self._under_way[file] = anyio.Event()
        try:
            yield
        finally:
            del self._under_way[file]
            ended.set()
            self._places.release(caller)

    async def _make(self, file: Path, inputs: str) -> str:
        """Make a file, unless another request did while this one waited; its SHA-256."""
        # Without parents: a missing data directory means that its disk is not mounted.
        self._folder.mkdir(exist_ok=True)
        sha256 = await run_in_threadpool(_whole, file)
        if sha256 is None:
            await self._run_child(file, inputs)
            sha256 = await run_in_threadpool(_marked, file)
        await run_in_threadpool(_tidy, self._folder, file)
        return sha256

    async def _run_child(self, file: Path, inputs: str) -> None:
        arguments = [str(file), str(math.ceil(self._seconds)), str(self._memory)]
        # From its start on: the interpreter alone computes for a tenth of a second.
        command = ["nice", "-n", str(NICENESS), sys.executable, "-P", "-m", __name__, *arguments]
        try:
            with anyio.fail_after(self._seconds):
                ended = await anyio.run_process(command, input=inputs.encode(), env=environment(), check=False)
        except TimeoutError:
            raise ConversionFailed(f"it took more than {self._seconds:g} s") from None
        if ended.returncode == REFUSED:
            raise NotAvailable(ended.stdout.decode().strip())
        if ended.returncode:
            log.error("a conversion failed (status %d)\n%s", ended.returncode, ended.stderr.decode(errors="replace"))
            raise ConversionFailed("the log of the service has the error under this request_id")


def _marked(file: Path) -> str:
    """The SHA-256 of a file that was made, which stands beside it from now on."""
    sha256 = digest(file)
    write_text(_mark(file), sha256)
    return sha256


def _tidy(folder: Path, made: Path) -> None:
    """Remove the files of a cache that were not used for the longest time, beyond its limits."""
    used: dict[Path, os.stat_result] = {}
    for file in folder.iterdir():
        with suppress(FileNotFoundError):  # a part of a file that is whole by now
            used[file] = file.stat()
    kept = 0
    files = sorted((file for file in used if file.suffix != MARK), key=lambda file: -used[file].st_atime)
    for number, file in enumerate(files):
        kept += used[file].st_size
        if file != made and (number >= MOST_FILES or kept > MOST_BYTES):
            _remove(file)
            _remove(_mark(file))


def _whole(file: Path) -> str | None:
    """The SHA-256 of a file that is as it was made, and is used now; None: it is missing or damaged."""
    mark = _mark(file)
    if not (file.is_file() and mark.is_file()) or (sha256 := digest(file)) != mark.read_text():
        return None
    os.utime(file, (time.time(), file.stat().st_mtime))  # its Last-Modified stays that of its content
    return sha256


def _mark(file: Path) -> Path:
    """The file with the digest of a file."""
    return file.with_name(f"{file.name}{MARK}")


def _remove(path: Path) -> None:
    """Remove a file, or the folder that a child left which was killed."""
    if path.is_dir():
        shutil.rmtree(path, ignore_errors=True)
    else:
        path.unlink(missing_ok=True)


# --- in the child process -------------------------------------------------------------------------


def main(file: Path, seconds: int, memory: int) -> None:
    """Make the file from the inputs on stdin; its kind is what follows the first dot of its name."""
    resource.setrlimit(resource.RLIMIT_DATA, (memory, memory))
    # Ends the child if the service was killed.
    resource.setrlimit(resource.RLIMIT_CPU, (seconds, seconds))
    _, _, kind = file.name.partition(".")
    try:
        makers()[kind](json.load(sys.stdin), file)
    except MissingExtra as error:
        print(error)
        sys.exit(REFUSED)


def _partial(inputs: FileInputs, file: Path) -> None:
    from studies.reports.publish import write_partial, write_partial_report

    outcomes = {run["run_id"]: _outcome(run) for run in inputs["outcomes"]}
    run_ids = [run["run_id"] for run in inputs["outcomes"]]
    make = write_partial_report if file.name.endswith(PARTIAL_REPORT) else write_partial
    make(inputs["document"], outcomes, file, state=inputs["state"], run_ids=run_ids)


def _outcome(run: Outcome) -> Mapping[str, JsonValue]:
    """A run's result, or its state and reason if there is none."""
    if run["path"] is None:
        state = State(run["state"])
        return {"state": CUBE_STATES.get(state, state.value), "reason": run["reason"]}
    file = Path(run["path"])
    if not file.is_file() or digest(file) != run["sha256"]:
        return {"state": "failed", "reason": f"the result of the run is lost or damaged: {file.name}"}
    return json.loads(file.read_bytes())


def _zarr(inputs: FileInputs, file: Path) -> None:
    from studies.cubes.exports import export_zarr
    from studies.cubes.opening import whole_cube

    [cube] = sources_of(inputs).values()
    export_zarr(whole_cube(cube), file)


def sources_of(inputs: FileInputs) -> dict[str, Path]:
    """The files of the inputs by name, as they were registered; raises OSError."""
    for path, sha256 in inputs["files"].values():
        if digest(Path(path)) != sha256:
            raise OSError(f"{path} is damaged")
    return {name: Path(path) for name, (path, _) in inputs["files"].items()}


Maker = Callable[[FileInputs, Path], None]  # makes the file of the inputs


@cache
def makers() -> Mapping[str, Maker]:
    """What makes the files of each kind; features add theirs by entry points ``whipple.service.conversions``."""
    made: dict[str, Maker] = {PARTIAL: _partial, PARTIAL_REPORT: _partial, "zarr.zip": _zarr}
    for point in points("service.conversions"):
        made |= point.load()
    return made


if __name__ == "__main__":
    main(Path(sys.argv[1]), int(sys.argv[2]), int(sys.argv[3]))
