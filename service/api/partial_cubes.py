"""Cubes of sweeps that have not ended, each made by a child process and kept under the digest of its question.

The API process opens no dataset, because netCDF4 crashes when threads share it. The child reads the sweep's document
and the outcomes of its runs from stdin, writes one file, and may take so much memory and so many seconds.
"""

import hashlib
import json
import logging
import os
import resource
import subprocess
import sys
import threading
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from service.api.errors import Busy, PartialCubeFailed
from service.files.artifacts import digest
from service.records.jobs import PublishedRun, State
from service.records.version import version

log = logging.getLogger(__name__)

SECONDS = 120  # for one cube; a second of them is the import of the libraries
MEMORY = 2 << 30  # bytes of data of the child
MOST_FILES = 20  # that are kept, the last used
STATES = {State.QUEUED: "pending", State.CANCELLING: "running"}  # as a cube calls them


class PartialCubes:
    """The folder of partial cubes; it makes one at a time."""

    def __init__(self, folder: Path, *, seconds: int = SECONDS, memory: int = MEMORY):
        self._folder = folder
        self._seconds = seconds
        self._memory = memory
        self._making = threading.Lock()

    def file(
        self, document: Mapping[str, Any], outcomes: Sequence[PublishedRun], root: Path, state: str
    ) -> tuple[Path, str]:
        """The cube of what the runs have left until now, and its SHA-256; raises Busy, PartialCubeFailed."""
        plain = [outcome.as_json(root) for outcome in outcomes]
        order = json.dumps({"document": document, "outcomes": plain, "state": state})
        name = hashlib.sha256(f"{version()}\n{order}".encode()).hexdigest()
        file = self._folder / f"{name}.nc"
        try:
            if not file.is_file():
                self._make(file, order)
            os.utime(file)
            return file, digest(file)
        except FileNotFoundError:
            raise PartialCubeFailed("the data directory, or the file, was removed") from None

    def _make(self, file: Path, order: str) -> None:
        if not self._making.acquire(blocking=False):
            raise Busy("another partial cube is being made")
        try:
            # Not the data directory: where that is missing, its disk is away.
            self._folder.mkdir(exist_ok=True)
            self._run_child(file, order)
            files = [(other.stat().st_mtime, other) for other in self._folder.iterdir()]
            for _, other in sorted(files, reverse=True)[MOST_FILES:]:
                other.unlink(missing_ok=True)
        finally:
            self._making.release()

    def _run_child(self, file: Path, order: str) -> None:
        arguments = [str(file), str(self._seconds), str(self._memory)]
        path = os.pathsep.join(os.path.abspath(entry) for entry in sys.path)
        try:
            subprocess.run(
                [sys.executable, "-P", "-m", "service.api.partial_cubes", *arguments],
                input=order,
                env={**os.environ, "PYTHONPATH": path, "OMP_NUM_THREADS": "1"},
                capture_output=True,
                text=True,
                check=True,
                timeout=self._seconds,
            )
        except subprocess.TimeoutExpired:
            raise PartialCubeFailed(f"it took more than {self._seconds} s") from None
        except subprocess.CalledProcessError as error:
            log.error("a partial cube failed (status %d)\n%s", error.returncode, error.stderr)
            raise PartialCubeFailed("the log of the service has it under this request_id") from None


def main(file: Path, seconds: int, memory: int) -> None:
    """Make the partial cube that stdin asks for; the child process."""
    resource.setrlimit(resource.RLIMIT_DATA, (memory, memory))
    # Ends the child where the service was killed.
    resource.setrlimit(resource.RLIMIT_CPU, (seconds, seconds))
    from studies.reports.publish import write_partial

    order = json.load(sys.stdin)
    outcomes = {plain["run_id"]: _read_outcome(plain) for plain in order["outcomes"]}
    write_partial(order["document"], outcomes, file, state=order["state"])


def _read_outcome(plain: Mapping[str, Any]) -> Mapping[str, Any]:
    """A run's result, or state and reason where there is none."""
    if plain["path"] is None:
        state = State(plain["state"])
        return {"state": STATES.get(state, state.value), "reason": plain["reason"]}
    file = Path(plain["path"])
    if not file.is_file() or digest(file) != plain["sha256"]:
        return {"state": "failed", "reason": f"its result is lost or damaged: {file.name}"}
    return json.loads(file.read_bytes())


if __name__ == "__main__":
    main(Path(sys.argv[1]), int(sys.argv[2]), int(sys.argv[3]))
