"""Files that are made when they are asked for, each by a child process and cached under the digest of its inputs: cubes
and reports of unfinished sweeps, results in the formats of other programs, and what pages draw of a run.

The API process opens no dataset, because netCDF4 crashes when threads share it. The child reads its inputs from stdin
and writes one file, within limits of time and memory.
"""

import hashlib
import json
import logging
import os
import resource
import shutil
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

from service import version
from service.api.errors import Busy, ConversionFailed, NotAvailable
from service.files.artifacts import Artifacts, digest
from service.records.jobs import VIEWS, PublishedRun, State, Stored
from service.workers.warm import environment
from studies.quantities.files import write_text
from studies.quantities.findings import MissingExtra

log = logging.getLogger(__name__)

SECONDS = 120  # limit for one file, including a second of imports
MEMORY = 2 << 30  # bytes of data of the child
MOST_FILES, MOST_BYTES = 100, 2 << 30  # in the cache; the least recently used are removed
MOST_WAITING = 4  # requests that wait while the file of another one is made; each holds a thread
MARK = ".sha256"
REFUSED = 3  # exit status of a child that cannot make the file, and says why in its output
# States of a run in a cube that differ from those of the queue.
CUBE_STATES = {State.QUEUED: "pending", State.CANCELLING: "running"}
PARTIAL, PARTIAL_REPORT = "partial.nc", "partial.html"


class Conversions:
    """The cache of these files; one is made at a time."""

    def __init__(self, folder: Path, *, seconds: int = SECONDS, memory: int = MEMORY):
        self._folder = folder
        self._seconds = seconds
        self._memory = memory
        self._making = threading.Lock()
        self._places = threading.BoundedSemaphore(MOST_WAITING)

    def partial_cube(
        self, document: Mapping[str, Any], outcomes: Sequence[PublishedRun], root: Path, state: str, kind: str = PARTIAL
    ) -> tuple[Path, str]:
        """The cube (or the report) of the results so far, and its SHA-256; raises as ``file`` does."""
        runs = [outcome.as_json(root) for outcome in outcomes]
        return self._file(kind, {"document": document, "outcomes": runs, "state": state})

    def file(
        self, kind: str, sources: Sequence[Stored], artifacts: Artifacts, *, wait: float = 0.0, **options: Any
    ) -> tuple[Path, str]:
        """The file of a kind (``MAKERS``) made from stored files, and its SHA-256.

        ``wait`` are the seconds for which it lets another file be made first. Raises Busy, ConversionFailed,
        BucketAway, and NotAvailable where this service lacks what it takes.
        """
        files = {source.name: [str(artifacts.local(source)), source.sha256] for source in sources}
        return self._file(kind, {"files": files, "options": options}, wait)

    def _file(self, kind: str, inputs: Mapping[str, Any], wait: float = 0.0) -> tuple[Path, str]:
        text = json.dumps(inputs)
        name = hashlib.sha256(f"{version()}\n{text}".encode()).hexdigest()
        file = self._folder / f"{name}.{kind}"
        try:
            sha256 = _whole(file)
            if sha256 is None:
                self._make(file, text, wait)
                sha256 = digest(file)
            # Used now; not modified, because Last-Modified and ETag are of its content.
            os.utime(file, (time.time(), file.stat().st_mtime))
            return file, sha256
        except FileNotFoundError:
            raise ConversionFailed("the data directory, or the file, was removed") from None

    def _make(self, file: Path, inputs: str, wait: float) -> None:
        if not self._may_begin(wait):
            raise Busy("another file is being made")
        try:
            # Without parents: a missing data directory means that its disk is not mounted.
            self._folder.mkdir(exist_ok=True)
            if _whole(file) is None:  # else another request waited for the same one
                self._run_child(file, inputs)
                write_text(_mark(file), digest(file))
            kept = 0
            files = [other for other in self._folder.iterdir() if other.suffix != MARK]
            files.sort(key=lambda other: -other.stat().st_atime)
            for number, other in enumerate(files):
                kept += other.stat().st_size
                if other != file and (number >= MOST_FILES or kept > MOST_BYTES):
                    _remove(other)
                    _remove(_mark(other))
        finally:
            self._making.release()

    def _may_begin(self, wait: float) -> bool:
        if not self._places.acquire(blocking=False):
            return False
        try:
            return self._making.acquire(timeout=wait)
        finally:
            self._places.release()

    def _run_child(self, file: Path, inputs: str) -> None:
        arguments = [str(file), str(self._seconds), str(self._memory)]
        try:
            subprocess.run(
                [sys.executable, "-P", "-m", "service.api.conversions", *arguments],
                input=inputs,
                env=environment(),
                capture_output=True,
                text=True,
                check=True,
                timeout=self._seconds,
            )
        except subprocess.TimeoutExpired:
            raise ConversionFailed(f"it took more than {self._seconds} s") from None
        except subprocess.CalledProcessError as error:
            if error.returncode == REFUSED:
                raise NotAvailable(error.stdout.strip()) from None
            log.error("a conversion failed (status %d)\n%s", error.returncode, error.stderr)
            raise ConversionFailed("the log of the service has the error under this request_id") from None


def _whole(file: Path) -> str | None:
    """The SHA-256 of a file that is as it was made; None: it is missing or damaged."""
    mark = _mark(file)
    sha256 = digest(file) if file.is_file() and mark.is_file() else None
    return sha256 if sha256 is None or sha256 == mark.read_text() else None


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
        MAKERS[kind](json.load(sys.stdin), file)
    except MissingExtra as error:
        print(error)
        sys.exit(REFUSED)


def _partial(inputs: Mapping[str, Any], file: Path) -> None:
    from studies.reports.publish import write_partial, write_partial_report

    outcomes = {run["run_id"]: _outcome(run) for run in inputs["outcomes"]}
    make = write_partial_report if file.name.endswith(PARTIAL_REPORT) else write_partial
    make(inputs["document"], outcomes, file, state=inputs["state"])


def _outcome(run: Mapping[str, Any]) -> Mapping[str, Any]:
    """A run's result, or its state and reason if there is none."""
    if run["path"] is None:
        state = State(run["state"])
        return {"state": CUBE_STATES.get(state, state.value), "reason": run["reason"]}
    file = Path(run["path"])
    if not file.is_file() or digest(file) != run["sha256"]:
        return {"state": "failed", "reason": f"the result of the run is lost or damaged: {file.name}"}
    return json.loads(file.read_bytes())


def _vtk(inputs: Mapping[str, Any], file: Path) -> None:
    from studies.quantities.files import zipped
    from studies.runs.exports import export_vtk

    zipped(lambda folder: export_vtk(_sources(inputs), folder), file)


def _zarr(inputs: Mapping[str, Any], file: Path) -> None:
    from studies.cubes.exports import export_zarr
    from studies.cubes.reading import open_cube

    [cube] = _sources(inputs).values()
    export_zarr(open_cube(cube), file)


def _film(inputs: Mapping[str, Any], file: Path) -> None:
    from studies.films.film_dataset import open_film
    from studies.reports.drawing.animation import animate

    [film] = _sources(inputs).values()
    animate(open_film(film), file, **inputs["options"])


def _view(inputs: Mapping[str, Any], file: Path) -> None:
    from studies.films.packed import write
    from studies.runs import views
    from studies.runs.run import Run

    _, view, _ = file.name.split(".")
    [source] = _sources(inputs).values()
    write(getattr(views, view)(Run.from_json(inputs["options"]["run"]), source), file)


def _sources(inputs: Mapping[str, Any]) -> dict[str, Path]:
    """The files of the inputs by name, as they were registered; raises OSError."""
    for path, sha256 in inputs["files"].values():
        if digest(Path(path)) != sha256:
            raise OSError(f"{path} is damaged")
    return {name: Path(path) for name, (path, _) in inputs["files"].items()}


MAKERS: Mapping[str, Callable[[Mapping[str, Any], Path], None]] = {
    PARTIAL: _partial,
    PARTIAL_REPORT: _partial,
    "vtk.zip": _vtk,
    "zarr.zip": _zarr,
    "gif": _film,
    "mp4": _film,
    **{f"{view}.view": _view for view in VIEWS},
}

if __name__ == "__main__":
    main(Path(sys.argv[1]), int(sys.argv[2]), int(sys.argv[3]))
