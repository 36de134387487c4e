"""A process for each attempt: the supervisor that starts and watches it, and the process itself.

The supervisor is called in a worker of the engine; it starts ``python -m service.worker`` and talks
to it over pipes:

* stdin: one line, the order; then nothing, but it stays open. It is the life line: the word
  ``stop`` or its end makes the child leave, so no child survives its supervisor.
* stdout: one JSON object a line: progress, or ``{"error": ...}`` before it leaves with status 1.
* stderr: into ``log.txt`` of the attempt's folder, with whatever libraries print.

The answer is files in the attempt's folder. Crash, time limit and cancel touch this attempt alone.
"""

import ctypes
import json
import math
import os
import selectors
import signal
import subprocess
import sys
import threading
import time
import traceback
from collections.abc import Callable, Mapping
from contextlib import suppress
from dataclasses import asdict, dataclass
from importlib import import_module
from pathlib import Path
from typing import IO, Any

from service.artifacts import LOG, describe, digest
from service.jobs import Cause, Kind, Stored

Tell = Callable[[Mapping[str, Any]], None]

# What each kind of job leaves behind, and the module that knows how to make it.
FILES = {Kind.RUN: ("result.json",), Kind.PUBLISH: ("cube.nc", "report.html", "report.json")}
TARGETS = {Kind.RUN: "studies.run", Kind.PUBLISH: "studies.publish"}

STOP = b"stop\n"
STATUS_ERROR, STATUS_STOPPED, STATUS_ORPHAN = 1, 20, 21
TICK = 0.1  # s, how often stop and limit are looked at
PATIENCE = 0.5  # s, between the word "stop" and the kill
TELL_INTERVAL = 1.0  # s, between two pieces of progress
PR_SET_PDEATHSIG = 1  # prctl(2)

# One thread in each run: a sweep fills the cores with runs. Read when numba and BLAS are imported.
SINGLE_THREAD = dict.fromkeys(
    ("NUMBA_NUM_THREADS", "OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"), "1"
)


@dataclass(frozen=True)
class Ticket:
    """The order for one attempt, as it travels to a worker."""

    key: str  # of the claim
    kind: Kind
    directory: str  # of the attempt; files go here
    spec: Mapping[str, Any]  # a run as JSON; or document and outcomes of a sweep
    seconds_limit: float
    targets: str | None  # a module in place of TARGETS


@dataclass(frozen=True)
class Ending:
    """How an attempt ended."""

    cause: Cause | None  # None: its files are complete
    failure: str  # short kind: "SIGABRT", "MemoryError"; "" for none
    reason: str  # for people
    files: tuple[Stored, ...]  # absolute paths
    seconds: float  # wall clock


# --- the supervisor ------------------------------------------------------------------------------

_SUPERVISORS: dict[str, "Supervisor"] = {}


def supervise(ticket: Ticket, tell: Tell) -> Ending:
    """Compute one attempt in a process of its own, and say how it ended."""
    supervisor = _SUPERVISORS[ticket.key] = Supervisor(ticket, tell)
    try:
        return supervisor.run()
    except OSError as error:  # no space for its folder, no memory for a process
        return supervisor.ending(Cause.ERROR, type(error).__name__, str(error))
    finally:
        del _SUPERVISORS[ticket.key]


def stop(keys: list[str] | None = None) -> None:
    """Stop these attempts, or all, if they run in this process."""
    for key, supervisor in list(_SUPERVISORS.items()):
        if keys is None or key in keys:
            supervisor.stop()


class Supervisor:
    """Starts the process of one attempt, listens to it, and ends it when it must end."""

    def __init__(self, ticket: Ticket, tell: Tell):
        self._ticket = ticket
        self._tell = tell
        self._directory = Path(ticket.directory)
        self._begin = time.monotonic()
        self._told = self._begin - TELL_INTERVAL
        self._stop = threading.Event()
        self._error: Mapping[str, str] | None = None
        self._cut: Cause | None = None  # why we ended it, if we did

    def stop(self) -> None:
        """Ask for the end; ``run`` sees to it."""
        self._stop.set()

    def run(self) -> Ending:
        """The whole life of the process."""
        self._directory.mkdir(parents=True, exist_ok=True)
        with (self._directory / LOG).open("ab") as log:
            process = subprocess.Popen(
                [sys.executable, "-P", "-m", "service.worker"],
                stdin=subprocess.PIPE,
                stdout=subprocess.PIPE,
                stderr=log,
                cwd=self._directory,
                env=_environment(),
                start_new_session=True,
                bufsize=0,
            )
        with process:
            try:
                self._order(process)
                self._watch(process)
            finally:
                _kill(process)
        return self._judge(process.returncode)

    def ending(
        self,
        cause: Cause | None,
        failure: str = "",
        reason: str = "",
        files: tuple[Stored, ...] = (),
    ) -> Ending:
        """An ending, now."""
        return Ending(cause, failure, reason, files, time.monotonic() - self._begin)

    def _order(self, process: subprocess.Popen[bytes]) -> None:
        """Write the order, a long one piece by piece."""
        assert process.stdin is not None
        line = memoryview(json.dumps(asdict(self._ticket)).encode() + b"\n")
        with suppress(BrokenPipeError):  # it died at once; its status says why
            while line:
                line = line[process.stdin.write(line) or 0 :]

    def _watch(self, process: subprocess.Popen[bytes]) -> None:
        """Listen until the process ends, or is ended."""
        assert process.stdout is not None
        limit, kill_at = self._begin + self._ticket.seconds_limit, None
        with selectors.DefaultSelector() as selector:
            selector.register(process.stdout, selectors.EVENT_READ)
            lines = _Lines(process.stdout)
            while process.poll() is None:
                if selector.get_map() and selector.select(TICK):
                    self._hear(lines)
                    if lines.ended:
                        selector.unregister(process.stdout)
                elif not selector.get_map():
                    _wait(process, TICK)
                now = time.monotonic()
                if self._cut is None and (self._stop.is_set() or now > limit):
                    self._cut = Cause.LOST if self._stop.is_set() else Cause.TIME_LIMIT
                    _ask_to_stop(process)
                    kill_at = now + PATIENCE
                if kill_at is not None and now > kill_at:
                    return
            while not lines.ended and selector.select(0):
                self._hear(lines)

    def _hear(self, lines: "_Lines") -> None:
        """Pass progress on, at most so often; keep an error for the end."""
        for line in lines.read():
            try:
                words = json.loads(line)
            except ValueError:
                continue  # cut short by a kill
            now = time.monotonic()
            if "error" in words:
                self._error = words["error"]
            elif now - self._told >= TELL_INTERVAL:
                self._told = now
                self._tell({**words, "seconds": now - self._begin})

    def _judge(self, status: int) -> Ending:
        """How it ended, from its status and its files."""
        if status == 0:  # also if it was about to be stopped
            return self._collect()
        if self._cut is Cause.LOST:
            return self.ending(Cause.LOST, "Stopped", "stopped on request")
        if self._cut is Cause.TIME_LIMIT:
            limit = f"stopped after the limit of {self._ticket.seconds_limit:g} s"
            return self.ending(Cause.TIME_LIMIT, "TimeLimit", limit)
        if self._error is not None:
            return self.ending(Cause.ERROR, self._error["failure"], self._error["reason"])
        name = signal.Signals(-status).name if status < 0 else f"status {status}"
        return self.ending(Cause.CRASH, name, f"the process died: {name}")

    def _collect(self) -> Ending:
        """The files of a process that says it succeeded."""
        files = [self._directory / name for name in FILES[self._ticket.kind]]
        missing = [file.name for file in files if not file.is_file()]
        if missing:
            reason = f"the process ended without {', '.join(missing)}"
            return self.ending(Cause.ERROR, "MissingFile", reason)
        return self.ending(None, files=tuple(describe(file) for file in files))


class _Lines:
    """Lines from a pipe, without waiting for the rest of one."""

    def __init__(self, pipe: IO[bytes]):
        self._descriptor = pipe.fileno()
        self._rest = b""
        self.ended = False

    def read(self) -> list[bytes]:
        """The lines that are complete now."""
        chunk = os.read(self._descriptor, 1 << 16)
        self.ended = not chunk
        *lines, self._rest = (self._rest + chunk).split(b"\n")
        return lines


def _environment() -> dict[str, str]:
    """Ours, one thread, the same modules, and a trace in the log when the interpreter dies."""
    path = os.pathsep.join(os.path.abspath(entry) for entry in sys.path)
    return {**os.environ, **SINGLE_THREAD, "PYTHONPATH": path, "PYTHONFAULTHANDLER": "1"}


def _ask_to_stop(process: subprocess.Popen[bytes]) -> None:
    assert process.stdin is not None
    with suppress(BrokenPipeError):  # it is gone already
        process.stdin.write(STOP)


def _kill(process: subprocess.Popen[bytes]) -> None:
    """End the process and everything that it started."""
    with suppress(ProcessLookupError):  # nothing is left
        os.killpg(process.pid, signal.SIGKILL)


def _wait(process: subprocess.Popen[bytes], seconds: float) -> None:
    with suppress(subprocess.TimeoutExpired):  # the caller looks again
        process.wait(seconds)


# --- the process ---------------------------------------------------------------------------------


def main() -> int:
    """Take one order from stdin, carry it out, and leave."""
    _die_with_parent()
    tell = _take_stdout()
    order = json.loads(_read_line())
    threading.Thread(target=_hold_life_line, name="life line", daemon=True).start()
    try:
        perform(
            Kind(order["kind"]), order["spec"], Path(order["directory"]), tell, order["targets"]
        )
    except Exception as error:  # whatever it is, the supervisor is told its name
        traceback.print_exc()
        tell({"error": {"failure": type(error).__name__, "reason": str(error)}})
        return STATUS_ERROR
    return 0


def perform(
    kind: Kind, spec: Mapping[str, Any], directory: Path, tell: Tell, targets: str | None
) -> None:
    """Compute a run, or publish a sweep, into ``directory``."""
    target = import_module(targets or TARGETS[kind])
    if kind is Kind.RUN:
        target.execute(
            target.Run.from_json(spec), directory, lambda told: tell(_finite(asdict(told)))
        )
        return
    answers = {one["run_id"]: _answer(one) for one in spec["outcomes"]}
    target.publish(spec["document"], answers, directory)


def _answer(outcome: Mapping[str, Any]) -> Mapping[str, Any]:
    """A run's result, or why there is none."""
    if outcome["path"] is None:
        return {"state": outcome["state"], "reason": outcome["reason"]}
    file = Path(outcome["path"])
    if not file.is_file() or digest(file) != outcome["sha256"]:
        return {"state": "failed", "reason": f"its result is lost or damaged: {file.name}"}
    return json.loads(file.read_bytes())


def _finite(value: Any) -> Any:
    """The same with None for NaN and infinity, which JSON does not have."""
    if isinstance(value, Mapping):
        return {name: _finite(one) for name, one in value.items()}
    return None if isinstance(value, float) and not math.isfinite(value) else value


def _die_with_parent() -> None:
    """On Linux the system kills us with our parent, even if compiled code blocks every thread."""
    if sys.platform == "linux":
        ctypes.CDLL(None).prctl(PR_SET_PDEATHSIG, signal.SIGKILL)


def _take_stdout() -> Tell:
    """Keep stdout for what we tell; what others print goes to the log."""
    ours = os.fdopen(os.dup(1), "w", encoding="utf-8")
    os.dup2(2, 1)

    def tell(words: Mapping[str, Any]) -> None:
        print(json.dumps(words), file=ours, flush=True)

    return tell


def _read_line() -> bytes:
    """The order; if the parent died before it was written, leave."""
    line = b""
    while not line.endswith(b"\n"):
        chunk = os.read(0, 1 << 16)
        if not chunk:
            os._exit(STATUS_ORPHAN)
        line += chunk
    return line


def _hold_life_line() -> None:
    """Leave when told to, or when nobody holds the other end any more."""
    os._exit(STATUS_STOPPED if os.read(0, len(STOP)) else STATUS_ORPHAN)


if __name__ == "__main__":
    sys.exit(main())
