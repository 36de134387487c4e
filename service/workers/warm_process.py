"""The warm process of a slot: takes order after order, and leaves when nobody holds its stdin.

Imports are paid once. Each order gets the folder of its attempt, where its log goes too, and its own
memory limit; what it changes of the process is put back behind it. One JSON object a line:

* stdin: ``{"order": ...}``, a ticket; ``{"stop": true}``: end at once; ``{"leave": true}``: write a
  checkpoint and give the order back. The end of stdin ends the process: it is its life line.
* stdout: ``{"taken": key}``, ``{"progress": ...}``, ``{"checkpoint": step}``, and for the end of an
  order one of ``{"done": {}}``, ``{"left": step}``, ``{"error": {"failure", "reason", "errno",
  "memory"}}``, each with ``"spent"``: whether the order left threads or processes behind.
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
import traceback
import warnings
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import contextmanager, suppress
from dataclasses import asdict
from importlib import import_module
from pathlib import Path
from queue import SimpleQueue
from typing import Any

from service.files.artifacts import LOG
from service.files.lost_results import Loss, leave_list
from service.records.jobs import Keep, Kind
from solver.errors import Interrupted

Words = Mapping[str, Any]
Tell = Callable[[Words], None]

# The module that knows how to make each kind of job.
TARGETS = {Kind.RUN: "studies.runs.execution", Kind.PUBLISH: "studies.reports.publish"}


STATUS_STOPPED, STATUS_ORPHAN, STATUS_MEMORY = 20, 21, 22
PR_SET_PDEATHSIG = 1  # prctl(2)
HOME = "/"  # where the process is between two orders, so that folders can be removed


def main() -> None:
    """Take orders until stdin ends."""
    die_with_parent()
    for wish in (signal.SIGINT, signal.SIGTERM):  # meant for those who then say a word on stdin
        signal.signal(wish, signal.SIG_IGN)
    resource.setrlimit(resource.RLIMIT_CORE, (0, resource.getrlimit(resource.RLIMIT_CORE)[1]))
    words, tell = _take_pipes()
    listener = _Listener(words)
    listener.start()
    while True:
        order = listener.orders.get()
        tell({"taken": order["key"]})
        end = _carry_out(order, tell, listener.leave.is_set)
        tell({**end, "spent": not _is_alone()})
        _give_memory_back()


# --- one order -----------------------------------------------------------------------------------


def _carry_out(order: Words, tell: Tell, leave: Callable[[], bool]) -> Words:
    """Compute what is asked; the words that end the order."""
    step: int | None = None

    def saved(now: int) -> None:
        nonlocal step
        step = now
        tell({"checkpoint": step})

    try:
        with (
            _at_home_again(),
            _logged(Path(order["directory"])),
            _memory_limit(order["memory_limit"]),
        ):
            perform(order, tell, saved, leave)
    except Interrupted:
        return {"left": step}
    except BaseException as error:  # whatever it is, the supervisor is told its name
        said = {"failure": type(error).__name__, "reason": str(error)}
        number = getattr(error, "errno", None)
        return {"error": {**said, "errno": number, "memory": _is_want_of_memory(error)}}
    return {"done": {}}


def perform(
    order: Words, tell: Tell, saved: Callable[[int], None], leave: Callable[[], bool]
) -> None:
    """Compute a run, or publish a sweep, into the folder of the order."""
    kind, spec, directory = Kind(order["kind"]), order["spec"], Path(order["directory"])
    target = import_module(order["targets"] or TARGETS[kind])
    if kind is Kind.PUBLISH:
        answers = _answers(spec["outcomes"], directory)
        target.publish(spec["document"], answers, directory)
        return
    run = target.Run.from_json(spec)
    if order["run"] not in (None, run.id):
        target.refuse(order["run"], directory)
        return
    target.execute(
        run,
        directory,
        lambda told: tell({"progress": _finite(asdict(told))}),
        threads=order["threads"],
        checkpoint=Path(order["checkpoint"]) if order["checkpoint"] else None,
        leave=leave,
        saved=saved,
        film=order["keep"] == Keep.FILM,
        say=_say,
    )


def _say(line: str) -> None:
    """Into the attempt's log, at once: who looks on wants to see it. But the log is not the work."""
    with suppress(OSError):  # no space
        print(line, flush=True)


def _answers(outcomes: Iterable[Words], directory: Path) -> dict[str, Words]:
    """The result of each run of a sweep, or why there is none; raises ResultsLost."""
    found = {one["run_id"]: one for one in outcomes}
    registered = [Loss(id, one["path"], one["sha256"]) for id, one in found.items() if one["path"]]
    if losses := [one for one in registered if one.is_real()]:
        leave_list(losses, directory)
    return {id: _answer(one) for id, one in found.items()}


def _answer(outcome: Words) -> Words:
    if outcome["path"] is None:
        return {"state": outcome["state"], "reason": outcome["reason"]}
    return json.loads(Path(outcome["path"]).read_bytes())


def _finite(value: Any) -> Any:
    """The same with None for NaN and infinity, which JSON does not have."""
    if isinstance(value, Mapping):
        return {name: _finite(one) for name, one in value.items()}
    return None if isinstance(value, float) and not math.isfinite(value) else value


def _is_want_of_memory(error: BaseException | None) -> bool:
    """Whether there was no memory, here or in what this was raised from."""
    while error is not None:
        if isinstance(error, MemoryError) or getattr(error, "errno", None) == errno.ENOMEM:
            return True
        error = error.__cause__ or error.__context__
    return False


# --- around an order -----------------------------------------------------------------------------


@contextmanager
def _logged(directory: Path) -> Iterator[None]:
    """Whatever is printed, by Python, libraries or a dying interpreter, goes to the attempt's log."""
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
        with suppress(OSError):  # no space; the supervisor is told what it was all the same
            traceback.print_exc()
        raise
    finally:
        _flush()
        for place, before in enumerate(kept, start=1):
            os.dup2(before, place)
            os.close(before)


@contextmanager
def _at_home_again() -> Iterator[None]:
    """Put back what an order may change of its process."""
    environment, path, printers = dict(os.environ), list(sys.path), (sys.stdout, sys.stderr)
    mask = os.umask(0)
    os.umask(mask)
    try:
        with warnings.catch_warnings():
            yield
    finally:
        sys.stdout, sys.stderr = printers
        os.umask(mask)
        os.chdir(HOME)
        sys.path[:] = path
        if environment != dict(os.environ):
            os.environ.clear()
            os.environ.update(environment)


@contextmanager
def _memory_limit(limit: int | None) -> Iterator[None]:
    """Let the process hold so many bytes of data; there is room again to say that it was too little."""
    _, most = resource.getrlimit(resource.RLIMIT_DATA)
    soft = most if limit is None else limit if most == resource.RLIM_INFINITY else min(limit, most)
    resource.setrlimit(resource.RLIMIT_DATA, (soft, most))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_DATA, (most, most))


def _flush() -> None:
    """Bring what is printed so far into the log, also what libraries hold back."""
    for stream in (sys.stdout, sys.stderr):
        with suppress(OSError, ValueError):  # no space, or closed by somebody
            stream.flush()
    ctypes.CDLL(None).fflush(None)


def _is_alone() -> bool:
    """Whether nothing that an order started is left: no thread but ours, no process."""
    if threading.active_count() > 2:
        return False
    try:
        os.waitid(os.P_ALL, 0, os.WEXITED | os.WNOHANG | os.WNOWAIT)
    except ChildProcessError:
        return True
    return False


def _give_memory_back() -> None:
    """What an order held must not count against the next one.

    What outlives an order, modules above all, is not looked at again: that would take longer (90 ms,
    2026-11) than a small run.
    """
    gc.collect()
    gc.freeze()
    with suppress(AttributeError):  # another C library
        ctypes.CDLL(None).malloc_trim(0)


# --- the process ---------------------------------------------------------------------------------


class _Listener(threading.Thread):
    """Reads stdin: the one thread that hears a word while an order is carried out."""

    def __init__(self, descriptor: int):
        super().__init__(name="listener", daemon=True)
        self._descriptor = descriptor
        self.orders: SimpleQueue[Words] = SimpleQueue()
        self.leave = threading.Event()

    def run(self) -> None:
        try:
            with os.fdopen(self._descriptor, "rb") as lines:
                for line in lines:
                    self._take(line)
        except MemoryError:
            os._exit(STATUS_MEMORY)
        os._exit(STATUS_ORPHAN)

    def _take(self, line: bytes) -> None:
        words = json.loads(line)
        if "stop" in words:
            os._exit(STATUS_STOPPED)
        if "leave" in words:
            self.leave.set()
        if "order" in words:
            self.leave.clear()
            self.orders.put(words["order"])


def die_with_parent() -> None:
    """On Linux the system kills us with our parent, even if compiled code blocks every thread."""
    if sys.platform == "linux":
        ctypes.CDLL(None).prctl(PR_SET_PDEATHSIG, signal.SIGKILL)


def _take_pipes() -> tuple[int, Tell]:
    """Keep stdin and stdout for the supervisor: nothing that an order starts reads or writes them."""
    words = os.dup(0)
    with open(os.devnull, "rb") as nothing:
        os.dup2(nothing.fileno(), 0)
    ours = os.fdopen(os.dup(1), "w", encoding="utf-8")
    os.dup2(2, 1)

    def tell(words: Words) -> None:
        try:
            print(json.dumps(words), file=ours, flush=True)
        except BrokenPipeError:  # nobody is there any more
            os._exit(STATUS_ORPHAN)

    return words, tell


if __name__ == "__main__":
    main()
