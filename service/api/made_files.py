"""Files that a child process makes on request, cached under the digest of what they are made from.

The API process opens no dataset, because netCDF4 crashes when threads share it, and loads no array. A child reads its
inputs from stdin and writes one file, within limits of time and memory.
"""

import hashlib
import json
import logging
import os
import resource
import subprocess
import sys
import threading
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

from service import version
from service.api.errors import Busy, RequestError
from service.files.artifacts import digest

log = logging.getLogger(__name__)

SECONDS = 120  # limit for one file, including a second of imports
MEMORY = 2 << 30  # bytes of data of the child
MOST_FILES = 20  # in the cache; the least recently used are removed


class MadeFiles:
    """A cache of files of one kind; one is made at a time."""

    module = __name__  # the child runs it: ``run_child`` in its ``__main__``
    noun = "file"
    suffix = ""
    failure: type[RequestError] = RequestError
    wait = 0.0  # s that a request waits for another one's file, before it is refused

    def __init__(self, folder: Path, *, seconds: int = SECONDS, memory: int = MEMORY):
        self._folder = folder
        self._seconds = seconds
        self._memory = memory
        self._making = threading.Lock()

    def made_from(self, inputs: Mapping[str, Any]) -> tuple[Path, str]:
        """The file of some inputs, and its SHA-256; raises Busy, or the ``failure`` of its kind."""
        text = json.dumps(inputs)
        name = hashlib.sha256(f"{version()}\n{text}".encode()).hexdigest()
        file = self._folder / f"{name}{self.suffix}"
        try:
            if not file.is_file():
                self._make(file, text)
            os.utime(file)
            return file, digest(file)
        except FileNotFoundError:
            raise self.failure("the data directory, or the file, was removed") from None

    def _make(self, file: Path, inputs: str) -> None:
        if not self._making.acquire(timeout=self.wait):
            raise Busy(f"another {self.noun} is being made")
        try:
            # Without parents: a missing data directory means that its disk is not mounted.
            self._folder.mkdir(exist_ok=True)
            if not file.is_file():
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
                [sys.executable, "-P", "-m", self.module, *arguments],
                input=inputs,
                env={**os.environ, "PYTHONPATH": path, "OMP_NUM_THREADS": "1"},
                capture_output=True,
                text=True,
                check=True,
                timeout=self._seconds,
            )
        except subprocess.TimeoutExpired:
            raise self.failure(f"the {self.noun} took more than {self._seconds} s") from None
        except subprocess.CalledProcessError as error:
            log.error("a %s failed (status %d)\n%s", self.noun, error.returncode, error.stderr)
            raise self.failure("the log of the service has the error under this request_id") from None


def run_child(make: Callable[[dict[str, Any], Path], object]) -> None:
    """Make a file of the inputs on stdin, in the child process."""
    file, seconds, memory = Path(sys.argv[1]), int(sys.argv[2]), int(sys.argv[3])
    resource.setrlimit(resource.RLIMIT_DATA, (memory, memory))
    # Ends the child if the service was killed.
    resource.setrlimit(resource.RLIMIT_CPU, (seconds, seconds))
    make(json.load(sys.stdin), file)
