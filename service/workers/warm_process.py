"""The warm process of a slot: computes attempt after attempt, until its stdin ends.

Imports are paid once. Each attempt gets its folder, where its log goes too, and its own memory limit. Stdin brings
an ``Order`` a line, as JSON, and its end ends the process; stdout takes a ``Report`` a line.
"""

import ctypes
import errno
import gc
import json
import math
import os
import resource
import signal
import sys
import threading
import time
import traceback
import warnings
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import contextmanager, suppress
from importlib import import_module
from pathlib import Path
from queue import SimpleQueue
from typing import TYPE_CHECKING

from service import memory
from service.files.artifacts import LOG
from service.files.lost_results import Loss, leave_list
from service.records.jobs import AttemptProgress, Keep, Kind, Outcome
from service.workers.attempt import Attempt, Report
from solver.errors import Interrupted
from studies.quantities.files import SECTIONS
from studies.runs.results import Progress, RunControl

if TYPE_CHECKING:
    from pydantic import JsonValue

Send = Callable[[Report], None]

# The module that computes each kind of job.
TARGETS = {Kind.RUN: "studies.runs.execution", Kind.PUBLISH: "studies.reports.publish"}

STATUS_STOPPED, STATUS_ORPHAN, STATUS_MEMORY = 20, 21, 22
STEP_INTERVAL = 1.0  # s
PR_SET_PDEATHSIG = 1  # prctl(2)
HOME = "/"  # where the process is between two attempts, so that folders can be removed


def main() -> None:
    """Import the modules in the arguments, then compute attempts until stdin ends."""
    die_with_parent()
    for wish in (signal.SIGINT, signal.SIGTERM):  # the parent gets them too, and sends a message
        signal.signal(wish, signal.SIG_IGN)
    resource.setrlimit(resource.RLIMIT_CORE, (0, resource.getrlimit(resource.RLIMIT_CORE)[1]))
    stdin, send = _take_pipes()
    listener = _Listener(stdin)
    listener.start()
    with memory.importing():
        for module in sys.argv[1:]:
            import_module(module)
    while True:
        attempt = listener.attempts.get()
        send({"accepted": attempt.key})
        last = _compute(attempt, send, listener.leave.is_set)
        send({**last, "dirty": _is_dirty()})
        # The memory of an attempt does not count against the next one. What outlives it, modules above all, is frozen:
        # to collect it again takes longer (90 ms, 2026-11) than a small run.
        gc.collect()
        gc.freeze()
        memory.give_back()


# --- one attempt ---------------------------------------------------------------------------------


def _compute(attempt: Attempt, send: Send, must_stop: Callable[[], bool]) -> Report:
    """Compute an attempt; the message that ends it."""
    try:
        with warnings.catch_warnings(), _logged(Path(attempt.directory)), _memory_limit(attempt.memory_limit):
            perform(attempt, send, must_stop)
    except Interrupted:
        return {"left": True}
    except BaseException as error:  # whatever it is, the supervisor reports it
        code = getattr(error, "errno", None)
        is_memory = _is_want_of_memory(error)
        return {"error": {"failure": type(error).__name__, "reason": str(error), "errno": code, "memory": is_memory}}
    return {"done": True}


def perform(attempt: Attempt, send: Send, must_stop: Callable[[], bool]) -> None:
    """Compute a run, or publish a sweep, into the folder of the attempt."""
    spec, directory = attempt.spec, Path(attempt.directory)
    target = import_module(attempt.targets or TARGETS[attempt.kind])
    if "outcomes" in spec:
        outcomes = spec["outcomes"]
        places = {"places": spec["places"]} if "places" in spec else {}
        target.publish(spec["document"], _answers(outcomes, directory), directory, _sections(outcomes), **places)
        return
    run = target.Run.from_json(spec)
    if attempt.run not in (None, run.id):
        target.refuse(attempt.run, directory)
        return
    stepped = 0.0  # monotonic: of the last message about it

    def after_step() -> bool:
        nonlocal stepped
        now = time.monotonic()
        if now - stepped >= STEP_INTERVAL:
            stepped = now
            send({"stepped": True})
        return must_stop()

    control = RunControl(
        progress=lambda progress: send({"progress": _finite(progress)}),
        log=_log,
        checkpointed=lambda step: send({"progress": {"checkpoint": step}}),
        must_stop=after_step,
    )
    target.execute(
        run,
        directory,
        control,
        threads=attempt.threads,
        checkpoint=Path(attempt.checkpoint) if attempt.checkpoint else None,
        film=attempt.keep == Keep.FILM,
    )


def _log(line: str) -> None:
    """Print a line into the attempt's log, flushed for live readers; the run goes on if the log cannot be written."""
    with suppress(OSError):  # no space
        print(line, flush=True)


def _answers(outcomes: Iterable[Outcome], directory: Path) -> "dict[str, Mapping[str, JsonValue]]":
    """The result of each run of a sweep, or why there is none; raises ResultsLost."""
    registered = [
        Loss(outcome["run_id"], outcome["path"], outcome["sha256"] or "") for outcome in outcomes if outcome["path"]
    ]
    if losses := [result for result in registered if result.is_real()]:
        leave_list(losses, directory)
    return {
        outcome["run_id"]: json.loads(Path(outcome["path"]).read_bytes())
        if outcome["path"]
        else {"state": outcome["state"], "reason": outcome["reason"]}
        for outcome in outcomes
    }


def _sections(outcomes: Iterable[Outcome]) -> dict[str, Path]:
    """The sections of each run that has kept them, beside its result."""
    files = {outcome["run_id"]: Path(outcome["path"]).with_name(SECTIONS) for outcome in outcomes if outcome["path"]}
    return {id: file for id, file in files.items() if file.is_file()}


def _finite(progress: Progress) -> AttemptProgress:
    """The progress of a run with None in place of NaN and infinity, which JSON does not have."""
    measured = {name: value if math.isfinite(value) else None for name, value in progress.measured.items()}
    left = progress.eta_seconds
    return {
        "time": progress.time,
        "end_time": progress.end_time,
        "step": progress.step,
        "fraction": progress.fraction,
        "eta_seconds": left if left is not None and math.isfinite(left) else None,
        "measured": measured,
    }


def _is_want_of_memory(error: BaseException | None) -> bool:
    """Whether this error, or one that it was raised from, is a lack of memory."""
    while error is not None:
        if isinstance(error, MemoryError) or getattr(error, "errno", None) == errno.ENOMEM:
            return True
        error = error.__cause__ or error.__context__
    return False


# --- around an attempt ----------------------------------------------------------------------------


@contextmanager
def _logged(directory: Path) -> Iterator[None]:
    """Send what Python, libraries or a dying interpreter print to the attempt's log."""
    directory.mkdir(exist_ok=True)
    kept = os.dup(1), os.dup(2)
    log = os.open(directory / LOG, os.O_WRONLY | os.O_APPEND | os.O_CREAT, 0o644)
    os.dup2(log, 1)
    os.dup2(log, 2)
    os.close(log)
    os.chdir(directory)
    try:
        yield
    except Interrupted:
        raise
    except BaseException:
        with suppress(OSError):  # no space; the supervisor is sent the error all the same
            traceback.print_exc()
        raise
    finally:
        os.chdir(HOME)
        _flush()
        for place, before in enumerate(kept, start=1):
            os.dup2(before, place)
            os.close(before)


@contextmanager
def _memory_limit(limit: int | None) -> Iterator[None]:
    """Let the process hold so many bytes of data; afterwards there is room again to report an error."""
    _, most = resource.getrlimit(resource.RLIMIT_DATA)
    soft = most if limit is None else limit if most == resource.RLIM_INFINITY else min(limit, most)
    resource.setrlimit(resource.RLIMIT_DATA, (soft, most))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_DATA, (most, most))


def _flush() -> None:
    """Write what is printed so far into the log, also what libraries hold back."""
    for stream in (sys.stdout, sys.stderr):
        with suppress(OSError, ValueError):  # no space, or closed by somebody
            stream.flush()
    ctypes.CDLL(None).fflush(None)


def _is_dirty() -> bool:
    """Whether an attempt left something running: a thread beside main and listener, or a process."""
    if threading.active_count() > 2:
        return True
    try:
        os.waitid(os.P_ALL, 0, os.WEXITED | os.WNOHANG | os.WNOWAIT)
    except ChildProcessError:
        return False
    return True


# --- the process ---------------------------------------------------------------------------------


class _Listener(threading.Thread):
    """Reads stdin, also while an attempt is computed."""

    def __init__(self, descriptor: int):
        super().__init__(name="listener", daemon=True)
        self._descriptor = descriptor
        self.attempts: SimpleQueue[Attempt] = SimpleQueue()
        self.leave = threading.Event()

    def run(self) -> None:
        try:
            with os.fdopen(self._descriptor, "rb") as lines:
                for line in lines:
                    message = json.loads(line)
                    if "stop" in message:
                        os._exit(STATUS_STOPPED)
                    if "leave" in message:
                        self.leave.set()
                    if "attempt" in message:
                        self.leave.clear()
                        self.attempts.put(Attempt(**message["attempt"]))
        except MemoryError:
            os._exit(STATUS_MEMORY)
        os._exit(STATUS_ORPHAN)


def die_with_parent() -> None:
    """Let Linux kill this process with its parent, even if compiled code blocks every thread."""
    ctypes.CDLL(None).prctl(PR_SET_PDEATHSIG, signal.SIGKILL)


def _take_pipes() -> tuple[int, Send]:
    """Keep stdin and stdout for the supervisor: nothing that an attempt starts reads or writes them."""
    stdin = os.dup(0)
    with open(os.devnull, "rb") as nothing:
        os.dup2(nothing.fileno(), 0)
    stdout = os.fdopen(os.dup(1), "w", encoding="utf-8")
    os.dup2(2, 1)

    def send(message: Report) -> None:
        try:
            print(json.dumps(message), file=stdout, flush=True)
        except BrokenPipeError:  # the supervisor has ended
            os._exit(STATUS_ORPHAN)

    return stdin, send


if __name__ == "__main__":
    main()
