"""The supervisor: sends an attempt to a warm process, receives its messages, and ends it when it must end.

Called in a slot of an engine (``service.execution``). The process of a slot is replaced after a crash, an error, a
cancellation or a limit. The results are files in the attempt's folder; whatever happens touches this attempt alone.
"""

import errno
import math
import os
import signal
import time
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path

from service.files.artifacts import LOG, OF_A_RUN, describe
from service.files.disk_space import free_bytes
from service.records.jobs import AttemptProgress, Cause, Kind, Stored
from service.workers.attempt import Attempt, Ending, Report
from service.workers.timings import DEFAULT, Timings
from service.workers.warm import Slot, WarmProcess
from service.workers.warm_process import STATUS_MEMORY
from studies.quantities.files import ALL_RUNS_CSV, COVER, RESULT, SWEEP_FILES

SendProgress = Callable[[AttemptProgress], None]

# What each kind of job must leave behind, and what it may.
FILES = {Kind.RUN: (RESULT,), Kind.PUBLISH: SWEEP_FILES}
MORE_FILES = {Kind.RUN: OF_A_RUN[1:], Kind.PUBLISH: (ALL_RUNS_CSV, COVER, LOG)}

MOST_STARTS = 3  # processes that may die before they accept the attempt
BROKEN_MOUNT = frozenset({errno.EIO, errno.ESTALE, errno.EROFS, errno.ENOTCONN, errno.EHOSTDOWN})

LOG_BYTES = 16 << 20  # limit; of a longer log the first and the last quarter of it stay
CUT = b"\n... (here the log was too long)\n"
# A process that dies with this share of its memory limit in use is taken to have died of it, and so is one whose log
# ends (so many bytes) with one of these messages: libraries of other languages abort where Python raises.
AT_THE_LIMIT = 0.9
LOG_END = 4096
OUT_OF_MEMORY = (b"MemoryError", b"bad_alloc", b"ut of memory", b"Cannot allocate memory")

# An attempt has stalled after so many times its longest interval between two messages.
PATIENCE = 10.0

# Kernels are compiled and cubes are written without a message: a process that is busy for this share of the least limit
# has not stalled. A run that has begun its steps but takes none, however busy, has, after ``PATIENCE`` as long again.
BUSY_SHARE = 0.01

# A look at the attempt that comes later than this was frozen itself, with its machine or container (s).
LONGEST_LOOK = 1.0


@dataclass
class StallClock:
    """The time since an attempt was last heard, as far as it was watched."""

    least: float  # s, until it has stalled
    longest: float = 0.0  # interval between two messages, s
    quiet: float = 0.0  # since the last message, s
    idle: float = 0.0  # since the last message or work, s
    used: float = 0.0  # processor seconds when it was last seen at work

    def pass_by(self, seconds: float) -> None:
        """Let the time since the last look pass."""
        seconds = min(seconds, LONGEST_LOOK)
        self.quiet, self.idle = self.quiet + seconds, self.idle + seconds

    def hear(self) -> None:
        self.longest = max(self.longest, self.quiet)
        self.quiet = self.idle = 0.0

    def has_run_out(self, *, used: float, has_steps: bool) -> bool:
        """Whether the attempt has stalled; ``used``: the processor seconds of its process."""
        if used - self.used >= BUSY_SHARE * self.least:
            self.used, self.idle = used, 0.0
        limit = max(self.least, PATIENCE * self.longest)
        return self.idle > limit or (has_steps and self.quiet > PATIENCE * limit)


class Supervisor:
    """One attempt: its progress, and why it is ended."""

    def __init__(
        self,
        attempt: Attempt,
        send: SendProgress,
        timings: Timings = DEFAULT,
        is_wanted: Callable[[], bool] = lambda: True,
    ):
        self._attempt = attempt
        self._send = send
        self._is_wanted = is_wanted  # asked at every tick; an attempt that nobody can find again ends
        self._timings = timings
        self._directory = Path(attempt.directory)
        self._begin = self._cut_log = 0.0  # monotonic: of the attempt, and of the last look at its log
        self._sent = -math.inf
        self._progress: AttemptProgress = {}  # the last; with the step of the last checkpoint
        self._is_accepted = False  # by the process: from here on its death is the run's own
        self._stall = StallClock(attempt.stall_seconds)
        self._most_data = 0  # bytes that the process was seen to hold
        self._stop_at = self._leave_at = math.inf  # monotonic; set from other threads
        self._stopped_for: Cause | None = None

    def stop(self) -> None:
        self._stop_at = -math.inf

    def leave(self, seconds: float) -> None:
        """Ask for a checkpoint and the end, within so many seconds."""
        now = time.monotonic()
        self._leave_at, self._stop_at = now, min(self._stop_at, now + seconds)

    def run(self, slot: Slot) -> Ending:
        """Compute the attempt in the process of a slot; how it ended."""
        self._begin = self._cut_log = time.monotonic()
        try:
            return self._run(slot)
        except OSError as error:  # no folder, no process: the worker is broken, not the run
            return self._pause(type(error).__name__, str(error))

    def _run(self, slot: Slot) -> Ending:
        if self._must_end():
            return self._ending(Cause.LOST, "Stopped", "the attempt was stopped before it started")
        self._directory.mkdir(exist_ok=True)  # the folder above exists, unless the disk is away
        if not self._missing():  # Dask repeats a task whose worker died after it
            return self._collect()
        kill_wait = self._timings.kill_wait
        for _ in range(MOST_STARTS):
            process = slot.acquire()
            try:
                process.compute(self._attempt)
                last = self._watch(process)
                _cut(self._directory / LOG)
            except BaseException:
                process.end(kill_wait)
                raise
            if last is not None:
                is_clean = "error" not in last and not last["dirty"]
                if is_clean and self._stopped_for is None:
                    slot.release(process)
                else:
                    process.end(kill_wait)
                return self._judge(last)
            status = process.end(kill_wait)
            if self._stopped_for is Cause.STALLED and not self._is_accepted:
                self._stopped_for = None
            if self._is_accepted or self._stopped_for or status is None:
                return self._judge_dead(status)
        raise ChildProcessError("the process cannot be started; see the log of the worker")

    def _must_end(self) -> bool:
        """Whether somebody has asked it to stop or to leave."""
        return min(self._stop_at, self._leave_at) < math.inf

    def _pause(self, failure: str, reason: str) -> Ending:
        """End as lost after a pause, so that a broken worker gets little to do."""
        ending = self._ending(Cause.LOST, failure, f"the worker cannot compute: {reason}")
        end = time.monotonic() + self._timings.broken_worker_pause
        while time.monotonic() < end and not self._must_end():
            time.sleep(self._timings.supervisor_tick)
        return ending

    def _ending(
        self, cause: Cause | None, failure: str = "", reason: str = "", files: tuple[Stored, ...] = ()
    ) -> Ending:
        free = None
        with suppress(OSError):  # the disk does not tell
            free = free_bytes(self._directory.parent)
        seconds, checkpoint = time.monotonic() - self._begin, self._progress.get("checkpoint")
        return Ending(cause, failure, reason, files, seconds, checkpoint, free)

    # --- while it is under way -------------------------------------------------------------------

    def _watch(self, process: WarmProcess) -> Report | None:
        """The message that ends the attempt; None: the process ended without one."""
        timings, kill_at = self._timings, math.inf
        limit = self._begin + self._attempt.seconds_limit
        before, self._stall = time.monotonic(), StallClock(self._attempt.stall_seconds)
        while True:
            is_alive = process.is_alive()
            for message in process.receive(timings.supervisor_tick if is_alive else 0.0):
                if "dirty" in message:
                    return message
                self._note(message)
            now = time.monotonic()
            self._stall.pass_by(now - before)
            before = now
            if (not is_alive and not process.has_more()) or now > kill_at:
                return None
            if self._attempt.memory_limit is not None:
                self._most_data = max(self._most_data, process.data())
            if now - self._cut_log >= timings.message_interval:
                self._cut_log = now
                _cut(self._directory / LOG)
                used, has_steps = process.processor_seconds(), "fraction" in self._progress
                if self._stopped_for is None and self._stall.has_run_out(used=used, has_steps=has_steps):
                    self._stopped_for = Cause.STALLED
                    return None
            if not self._is_wanted():
                self.stop()
            if self._leave_at < now:
                self._leave_at = math.inf
                process.send({"leave": True})
            if self._stopped_for is None and now > min(limit, self._stop_at):
                self._stopped_for = Cause.LOST if now > self._stop_at else Cause.TIME_LIMIT
                process.send({"stop": True})
                kill_at = now + timings.stop_grace

    def _note(self, message: Report) -> None:
        """Note a message; send progress on when a checkpoint was written, else not too often."""
        self._stall.hear()
        self._is_accepted = self._is_accepted or "accepted" in message
        self._progress |= message.get("progress", {})
        if "fraction" not in self._progress or "progress" not in message:
            return
        now = time.monotonic()
        has_checkpoint = "checkpoint" in message.get("progress", {})
        if has_checkpoint or now - self._sent >= self._timings.message_interval:
            self._sent = now
            self._send({**self._progress, "seconds": now - self._begin})

    # --- how it ended ----------------------------------------------------------------------------

    def _judge(self, last: Report) -> Ending:
        """The ending, from the last message."""
        if "done" in last:  # also if it was about to be stopped
            missing = self._missing()
            if not missing:
                return self._collect()
            reason = f"the process ended without {', '.join(missing)}"
            return self._ending(Cause.ERROR, "MissingFile", reason)
        if "left" in last:
            return self._ending(Cause.LOST, "Left", "left on request, after a checkpoint")
        error = last["error"]
        if error["memory"]:
            return self._out_of_memory(error["failure"], error["reason"])
        if error["errno"] in BROKEN_MOUNT:
            return self._pause(error["failure"], error["reason"])
        return self._ending(Cause.ERROR, error["failure"], error["reason"])

    def _judge_dead(self, status: int | None) -> Ending:
        """The ending without a last message: the process was stopped, died, or does not even die."""
        if status is None:
            wait = self._timings.kill_wait
            reason = f"its process was killed, and has not ended {wait:g} s later"
            return self._pause("Stuck", reason)
        if self._stopped_for is Cause.LOST:
            return self._ending(Cause.LOST, "Stopped", "stopped on request")
        if self._stopped_for is Cause.TIME_LIMIT:
            limit = f"stopped after the limit of {self._attempt.seconds_limit:g} s"
            return self._ending(Cause.TIME_LIMIT, "TimeLimit", limit)
        if self._stopped_for is Cause.STALLED:
            reason = f"stalled: no progress for {self._stall.quiet:.0f} s"
            return self._ending(Cause.STALLED, "Stalled", reason)
        name = signal.Signals(-status).name if status < 0 else f"status {status}"
        if status == STATUS_MEMORY or self._died_of_its_limit():
            return self._out_of_memory(name, "the process died")
        return self._ending(Cause.CRASH, name, f"the process died: {name}")

    def _died_of_its_limit(self) -> bool:
        limit = self._attempt.memory_limit
        if limit is None:
            return False
        end = _last_bytes(self._directory / LOG, LOG_END)
        return self._most_data > AT_THE_LIMIT * limit or any(text in end for text in OUT_OF_MEMORY)

    def _out_of_memory(self, failure: str, reason: str) -> Ending:
        limit = self._attempt.memory_limit
        allowed = "" if limit is None else f"; a run may use {limit / 1e9:.3g} GB"
        return self._ending(Cause.MEMORY_LIMIT, failure, f"out of memory: {reason or failure}{allowed}")

    def _missing(self) -> list[str]:
        """Files that the attempt must leave, and has not."""
        names = FILES[self._attempt.kind]
        return [name for name in names if not (self._directory / name).is_file()]

    def _collect(self) -> Ending:
        kind = self._attempt.kind
        files = [self._directory / name for name in (*FILES[kind], *MORE_FILES[kind])]
        return self._ending(None, files=tuple(describe(file) for file in files if file.is_file()))


# --- the log of an attempt, which its process may write to meanwhile -------------------------------


def _last_bytes(log: Path, count: int) -> bytes:
    """The end of a log; empty if it cannot be read."""
    try:
        with log.open("rb") as opened:
            opened.seek(max(0, log.stat().st_size - count))
            return opened.read(count)
    except OSError:
        return b""


def _cut(log: Path) -> None:
    """Cut the middle out of a log that is too long."""
    quarter = LOG_BYTES // 4
    with suppress(OSError):  # no log, or a disk error
        if log.stat().st_size <= LOG_BYTES:
            return
        last = _last_bytes(log, quarter)
        os.truncate(log, quarter)
        with log.open("ab") as end:
            end.write(CUT + last)
