"""Cubes of unfinished sweeps, each made by a child process and cached under the digest of its inputs.

The API process opens no dataset, because netCDF4 crashes when threads share it. The child reads the sweep's document
and the outcomes of its runs from stdin and writes one file, within limits of time and memory.
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

from service import version
from service.api.errors import Busy, PartialCubeFailed
from service.files.artifacts import digest
from service.records.jobs import PublishedRun, State

log = logging.getLogger(__name__)

SECONDS = 120  # limit for one cube, including a second of imports
MEMORY = 2 << 30  # bytes of data of the child
MOST_FILES = 20  # in the cache; the least recently used are removed
# States of a run in a cube that differ from those of the queue.
CUBE_STATES = {State.QUEUED: "pending", State.CANCELLING: "running"}


class PartialCubes:
    """The cache of partial cubes; one is made at a time."""

    def __init__(self, folder: Path, *, seconds: int = SECONDS, memory: int = MEMORY):
        self._folder = folder
        self._seconds = seconds
        self._memory = memory
        self._making = threading.Lock()

    def file(
        self, document: Mapping[str, Any], outcomes: Sequence[PublishedRun], root: Path, state: str
    ) -> tuple[Path, str]:
        """The cube of the results so far, and its SHA-256; raises Busy, PartialCubeFailed."""
        runs = [outcome.as_json(root) for outcome in outcomes]
        inputs = json.dumps({"document": document, "outcomes": runs, "state": state})
        name = hashlib.sha256(f"{version()}\n{inputs}".encode()).hexdigest()
        file = self._folder / f"{name}.nc"
        try:
            if not file.is_file():
                self._make(file, inputs)
            os.utime(file)
            return file, digest(file)
        except FileNotFoundError:
            raise PartialCubeFailed("the data directory, or the file, was removed") from None

    def _make(self, file: Path, inputs: str) -> None:
        if not self._making.acquire(blocking=False):
            raise Busy("another partial cube is being made")
        try:
            # Without parents: a missing data directory means that its disk is not mounted.
            self._folder.mkdir(exist_ok=True)
            self._run_child(file, inputs)
            files = sorted(self._folder.iterdir(), key=lambda other: -other.stat().st_mtime)
            for other in files[MOST_FILES:]:
                other.unlink(missing_ok=True)
        finally:
            self._making.release()

    def _run_child(self, file: Path, inputs: str) -> None:
        arguments = [str(file), str(self._seconds), str(self._memory)]
        path = os.pathsep.join(os.path.abspath(entry) for entry in sys.path)
        try:
            subprocess.run(
                [sys.executable, "-P", "-m", "service.api.partial_cubes", *arguments],
                input=inputs,
                env={**os.environ, "PYTHONPATH": path, "OMP_NUM_THREADS": "1"},
                capture_output=True,
                text=True,
                check=True,
                timeout=self._seconds,
            )
        except subprocess.TimeoutExpired:
            raise PartialCubeFailed(f"the partial cube took more than {self._seconds} s") from None
        except subprocess.CalledProcessError as error:
            log.error("a partial cube failed (status %d)\n%s", error.returncode, error.stderr)
            raise PartialCubeFailed("the log of the service has the error under this request_id") from None


# --- in the child process -------------------------------------------------------------------------


def main(file: Path, seconds: int, memory: int) -> None:
    """Make the partial cube of the inputs on stdin."""
    resource.setrlimit(resource.RLIMIT_DATA, (memory, memory))
    # Ends the child if the service was killed.
    resource.setrlimit(resource.RLIMIT_CPU, (seconds, seconds))
    from studies.reports.publish import write_partial

    inputs = json.load(sys.stdin)
    outcomes = {run["run_id"]: _outcome(run) for run in inputs["outcomes"]}
    write_partial(inputs["document"], outcomes, file, state=inputs["state"])


def _outcome(run: Mapping[str, Any]) -> Mapping[str, Any]:
    """A run's result, or its state and reason if there is none."""
    if run["path"] is None:
        state = State(run["state"])
        return {"state": CUBE_STATES.get(state, state.value), "reason": run["reason"]}
    file = Path(run["path"])
    if not file.is_file() or digest(file) != run["sha256"]:
        return {"state": "failed", "reason": f"the result of the run is lost or damaged: {file.name}"}
    return json.loads(file.read_bytes())


if __name__ == "__main__":
    main(Path(sys.argv[1]), int(sys.argv[2]), int(sys.argv[3]))
