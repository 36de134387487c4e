"""Parts of a cube, and cubes that are not complete: made in a process of their own, and kept a while.

The process that answers requests never opens a dataset: the libraries for that crash when threads share
them. One child does, one order after the other; it is started when it is first needed, may take so much
memory and so many seconds for an order, and leaves when the service does, however that ends (its stdin
ends). What it makes lies in a folder under the digest of what was asked for, so that the same question
is answered by the same file; the files that nobody asked for lately make room for others.
"""

import hashlib
import json
import logging
import os
import resource
import selectors
import signal
import subprocess
import sys
import threading
import time
import traceback
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from dataclasses import asdict, dataclass
from pathlib import Path
from queue import SimpleQueue
from typing import Any

from service.artifacts import digest
from service.errors import Busy, SliceFailed
from service.jobs import Outcome, State
from solver.errors import WhippleError
from studies.errors import Finding, InvalidInput

log = logging.getLogger(__name__)

SECONDS = 120.0  # that an order may take; the first one waits for the libraries too
MEMORY = 2 << 30  # bytes of data that the child may hold
MOST_WAITING = 4  # orders that wait for their turn; each holds a thread
MOST_BYTES = 512 << 20  # of all files that are kept
MOST_FILES = 500
LEAVE_SECONDS = 1.0  # that the child gets to leave when the service does
SMALLER = "ask for a smaller part, or fetch cube.nc"
VERSION = 1  # of what the child makes; part of each digest

# States of a run, in the words that a cube has for them.
WORDS = {State.QUEUED: "pending", State.CANCELLING: "running"}


@dataclass(frozen=True)
class Part:
    """Which part of a cube."""

    variables: tuple[str, ...]  # none: what was measured
    at: Mapping[str, tuple[str, ...]]  # values of axes, as a user wrote them
    form: str  # "json" or "nc"


class Slices:
    """The folder of what was made, and the child that makes it."""

    def __init__(self, folder: Path, *, seconds: float = SECONDS, memory: int = MEMORY):
        self._folder = folder
        self._seconds = seconds
        self._memory = memory
        self._turn = threading.Lock()  # one order at a time
        self._waiting = threading.BoundedSemaphore(MOST_WAITING + 1)
        self._child: subprocess.Popen[bytes] | None = None
        self._closed = False

    def part(self, cube: Path, sha256: str, part: Part) -> tuple[Path, str]:
        """A file with a part of a cube, and its digest; raises InvalidInput, Busy, SliceFailed."""
        order = {"do": "part", "cube": str(cube), "sha256": sha256, **asdict(part)}
        return self._made([sha256, asdict(part)], part.form, order)

    def partial_cube(
        self, document: Mapping[str, Any], outcomes: Sequence[Outcome], root: Path, state: str
    ) -> tuple[Path, str]:
        """The cube of a sweep as far as it is, and its digest; raises Busy, SliceFailed."""
        known = {one.run_id: _answer(one, root) for one in outcomes}
        order = {"do": "cube", "document": document, "outcomes": known, "state": state}
        question = [document, [(one.run_id, one.state, one.sha256) for one in outcomes], state]
        return self._made(question, "nc", order)

    def close(self) -> None:
        """End the child; nothing is made any more."""
        self._closed = True
        child = self._child
        if child is None:
            return
        assert child.stdin is not None
        with suppress(OSError):
            child.stdin.close()
        with suppress(subprocess.TimeoutExpired):
            child.wait(LEAVE_SECONDS)
        _kill(child)

    # --- files -----------------------------------------------------------------------------------

    def _made(self, question: Any, form: str, order: Mapping[str, Any]) -> tuple[Path, str]:
        """The file that answers a question: as it lies there, or made now."""
        text = json.dumps([VERSION, question], sort_keys=True)
        file = self._folder / f"{hashlib.sha256(text.encode()).hexdigest()}.{form}"
        with self._in_line():
            if not file.is_file():
                self._make_folder()
                self._carry_out({**order, "file": str(file)})
                self._make_room(file)
            with suppress(FileNotFoundError):  # another service may share the folder
                os.utime(file)
                return file, digest(file)
        raise Busy("what was made had to make room at once; ask again")

    def _make_folder(self) -> None:
        """The folder, but not the data directory that it is in: that is there, or its disk is away."""
        try:
            self._folder.mkdir(exist_ok=True)
        except FileNotFoundError:
            raise SliceFailed("the data directory is not there") from None

    @contextmanager
    def _in_line(self) -> Iterator[None]:
        """One order at a time, and a short line of those that wait."""
        if not self._waiting.acquire(blocking=False):
            raise Busy(f"{MOST_WAITING} others wait for a part of a cube")
        try:
            with self._turn:
                yield
        finally:
            self._waiting.release()

    def _make_room(self, newest: Path) -> None:
        """Remove the files that nobody asked for lately, until the rest is small enough."""
        files = [(file, file.stat()) for file in self._folder.iterdir() if file.is_file()]
        files.sort(key=lambda one: one[1].st_mtime, reverse=True)
        total = 0
        for count, (file, status) in enumerate(files):
            total += status.st_size
            if (total > MOST_BYTES or count >= MOST_FILES) and file != newest:
                file.unlink(missing_ok=True)

    # --- the child -------------------------------------------------------------------------------

    def _carry_out(self, order: Mapping[str, Any]) -> None:
        """Let the child carry out an order; one that fails or is late is replaced."""
        was_there = self._child is not None
        try:
            answer = self._ask(order)
        except _Died:  # an old one may have died since its last order
            if not was_there:
                raise
            answer = self._ask(order)
        if "refused" in answer:
            raise InvalidInput(Finding(**one) for one in answer["refused"])
        if "trace" in answer:
            log.error("a part of a cube could not be made\n%s", answer["trace"])
            raise SliceFailed("the log of the service has it under this request_id")
        if "failed" in answer:
            raise SliceFailed(answer["failed"])

    def _ask(self, order: Mapping[str, Any]) -> dict[str, Any]:
        """The child's answer; raises SliceFailed when there is none, and then it is no more."""
        if self._closed:
            raise Busy("the service is about to leave")
        child = self._child
        if child is None or child.poll() is not None:
            child = self._child = _start(self._memory)
        try:
            line = _line_from(child, order, self._seconds)
        except BaseException:
            self._child = None
            _kill(child)
            raise
        return json.loads(line)


class _Died(SliceFailed):
    """The child went away without an answer."""


def _answer(outcome: Outcome, root: Path) -> dict[str, Any]:
    """How a run ended, or stands, for the child: a file with its digest, or words."""
    state = WORDS.get(outcome.state, outcome.state.value)
    if outcome.path is None or outcome.state not in (State.SUCCEEDED, State.FAILED):
        return {"state": state, "reason": outcome.reason}
    return {"path": str(root / outcome.path), "sha256": outcome.sha256}


def _start(memory: int) -> "subprocess.Popen[bytes]":
    path = os.pathsep.join(os.path.abspath(entry) for entry in sys.path)
    return subprocess.Popen(
        [sys.executable, "-P", "-m", "service.slices", str(memory)],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        stderr=subprocess.DEVNULL,  # what goes wrong is part of the answer
        env={**os.environ, "PYTHONPATH": path, "OMP_NUM_THREADS": "1"},
        start_new_session=True,
        bufsize=0,
    )


def _line_from(child: "subprocess.Popen[bytes]", order: Mapping[str, Any], seconds: float) -> bytes:
    """The line that the child answers to an order; raises SliceFailed if it dies, or is late."""
    assert child.stdin is not None
    assert child.stdout is not None
    end = time.monotonic() + seconds
    with suppress(BrokenPipeError):  # it has died; its stdout says so
        line = memoryview(json.dumps(order).encode() + b"\n")
        while line:
            line = line[child.stdin.write(line) or 0 :]
    answer = b""
    with selectors.DefaultSelector() as selector:
        selector.register(child.stdout, selectors.EVENT_READ)
        while not answer.endswith(b"\n"):
            if not selector.select(max(0.0, end - time.monotonic())):
                raise SliceFailed(f"it took more than {seconds:g} s; {SMALLER}")
            chunk = os.read(child.stdout.fileno(), 1 << 16)
            if not chunk:
                raise _Died(f"the process that makes it died; {SMALLER}")
            answer += chunk
    return answer


def _kill(child: "subprocess.Popen[bytes]") -> None:
    with suppress(ProcessLookupError):
        os.killpg(child.pid, signal.SIGKILL)
    child.wait()
    for pipe in (child.stdin, child.stdout):
        assert pipe is not None
        with suppress(OSError):
            pipe.close()


# --- in the child ---------------------------------------------------------------------------------


class Damaged(WhippleError):
    """A file is not the one that was registered."""


def main(memory: int) -> None:
    """Carry out orders from stdin, a JSON line each, until it ends."""
    resource.setrlimit(resource.RLIMIT_DATA, (memory, memory))
    ours = os.fdopen(os.dup(1), "w", encoding="utf-8")
    os.dup2(2, 1)  # what libraries print is no answer
    orders: SimpleQueue[bytes] = SimpleQueue()
    threading.Thread(target=_read, args=(orders,), name="life line", daemon=True).start()
    while True:
        print(json.dumps(_carried_out(json.loads(orders.get()))), file=ours, flush=True)


def _read(orders: "SimpleQueue[bytes]") -> None:
    """Pass orders on; leave at once when nobody can give another."""
    for line in sys.stdin.buffer:
        orders.put(line)
    os._exit(0)


def _carried_out(order: Mapping[str, Any]) -> dict[str, Any]:
    """Make what is ordered, and say what is to be said."""
    try:
        DO[order["do"]](order)
    except InvalidInput as error:
        return {"refused": error.as_json()}
    except MemoryError:
        return {"failed": f"it does not fit into the memory that is allowed; {SMALLER}"}
    except Damaged as error:
        return {"failed": str(error)}
    except Exception:  # whatever it is, the service goes on, and so does this process
        return {"trace": traceback.format_exc()}
    return {"made": order["file"]}


def _make_part(order: Mapping[str, Any]) -> None:
    from studies import slices

    file = Path(order["cube"])
    if digest(file) != order["sha256"]:
        raise Damaged("the cube is damaged: its checksum differs; retry the sweep")
    slices.write_part(file, order["variables"], order["at"], Path(order["file"]))


def _make_cube(order: Mapping[str, Any]) -> None:
    from studies import slices

    outcomes = {run_id: _result(one) for run_id, one in order["outcomes"].items()}
    slices.write_partial(order["document"], outcomes, Path(order["file"]), state=order["state"])


def _result(outcome: Mapping[str, Any]) -> Mapping[str, Any]:
    """A run's result, or why there is none."""
    if "path" not in outcome:
        return outcome
    file = Path(outcome["path"])
    if not file.is_file() or digest(file) != outcome["sha256"]:
        return {"state": "failed", "reason": f"its result is lost or damaged: {file.name}"}
    return json.loads(file.read_bytes())


DO = {"part": _make_part, "cube": _make_cube}

if __name__ == "__main__":
    main(int(sys.argv[1]))
