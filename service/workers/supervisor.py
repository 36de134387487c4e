"""The supervisor: gives an attempt to a warm process, listens to it, and ends it when it must end.

Called in a slot of an engine (``service.execution``). ``service.workers.warm`` has the processes; a slot has one of
them, which is replaced after a crash, an error, a cancel or a limit.

The answer is files in the attempt's folder. Whatever happens touches this attempt alone.
"""

import errno
import math
import signal
import time
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path

from service.files import attempt_log
from service.files.artifacts import LOG, OF_A_RUN, describe
from service.files.disk_space import free_bytes
from service.records.attempt import Attempt, Ending
from service.records.jobs import Cause, Kind, Stored
from service.workers import warm
from service.workers.warm import Slot, Words
from service.workers.warm_process import STATUS_MEMORY
from studies.values.files import ANSWER, OF_A_SWEEP

Tell = Callable[[Words], None]

# What each kind of job must leave behind, and what it may.
FILES = {Kind.RUN: (ANSWER,), Kind.PUBLISH: OF_A_SWEEP}
MORE_FILES = {Kind.RUN: OF_A_RUN[1:], Kind.PUBLISH: (LOG,)}

TRIES = 3  # processes that may die before they take an order
TICK = 0.1  # s, how often stop and limits are looked at
PATIENCE = 0.5  # s, between the word "stop" and the kill
LEAVE_SECONDS = 8.0  # between the word "leave" and the word "stop"
STOP_SECONDS = 3.0 * PATIENCE  # for an attempt that was told to stop to be gone
TELL_INTERVAL = 1.0  # s, between two pieces of progress
PAUSE_SECONDS = 20.0  # of a worker on which nothing works: others take what there is to do
ILL = frozenset({errno.EIO, errno.ESTALE, errno.EROFS, errno.ENOTCONN, errno.EHOSTDOWN})  # a mount

# A process that dies with this share of its memory limit in use is taken to have died of it, and so is one whose
# last words in the log (so many bytes) are among these: libraries of other languages abort where Python raises.
AT_THE_LIMIT = 0.9
LAST_WORDS = 4096
WANT_OF_MEMORY = (b"MemoryError", b"bad_alloc", b"ut of memory", b"Cannot allocate memory")


class Supervisor:
    """One attempt: its order, what is heard of it, and why it is ended."""

    def __init__(self, ticket: Attempt, tell: Tell):
        self._ticket = ticket
        self._tell = tell
        self._directory = Path(ticket.directory)
        self._begin = self._looked = (
            0.0  # monotonic: of the attempt, and of the last look at its log
        )
        self._told = -math.inf
        self._progress: Words | None = None
        self._checkpoint: int | None = None
        self._taken = False  # the order: from here on a death is the run's own
        self._most_data = 0  # bytes that the process was seen to hold
        self._stop_at = self._leave_at = math.inf  # monotonic; set from other threads
        self._cut: Cause | None = None  # why we ended it, if we did

    def stop(self) -> None:
        """Ask for the end; ``run`` sees to it."""
        self._stop_at = -math.inf

    def leave(self, seconds: float) -> None:
        """Ask for a checkpoint and the end, within so many seconds."""
        now = time.monotonic()
        self._leave_at, self._stop_at = now, min(self._stop_at, now + seconds)

    def run(self, slot: Slot) -> Ending:
        """Compute the attempt in the process of a slot, and say how it ended."""
        self._begin = self._looked = time.monotonic()
        try:
            return self._run(slot)
        except OSError as error:  # no folder, no process: it is the worker that is ill, not the run
            return self.pause(type(error).__name__, str(error))

    def _run(self, slot: Slot) -> Ending:
        if self._is_unwanted():
            return self.ending(Cause.LOST, "Stopped", "stopped before it began")
        self._directory.mkdir(exist_ok=True)  # without its parents: they are there if the disk is
        # Done before: the worker that held the answer died, and Dask asks again.
        if not self._missing():
            return self._collect()
        for _ in range(TRIES):
            child = slot.acquire()
            try:
                child.take(self._ticket)
                end = self._watch(child)
                attempt_log.cut(self._directory / LOG)
            except BaseException:
                child.end()
                raise
            if end is not None:
                self._let_go(child, end, slot)
                return self._judge(end)
            status = child.end()
            if self._taken or self._cut or status is None:
                return self._judge_dead(status)
        raise ChildProcessError("a process cannot be started; the log of the worker says why")

    def _is_unwanted(self) -> bool:
        """Whether it was asked to stop or to leave."""
        return min(self._stop_at, self._leave_at) < math.inf

    def pause(self, failure: str, reason: str) -> Ending:
        """How an attempt ends where nothing works; told late, so that this worker gets little to do."""
        ending = self.ending(Cause.LOST, failure, f"its worker cannot compute: {reason}")
        end = time.monotonic() + PAUSE_SECONDS
        while time.monotonic() < end and not self._is_unwanted():
            time.sleep(TICK)
        return ending

    def ending(
        self,
        cause: Cause | None,
        failure: str = "",
        reason: str = "",
        files: tuple[Stored, ...] = (),
    ) -> Ending:
        """An ending, now."""
        seconds = time.monotonic() - self._begin
        return Ending(cause, failure, reason, files, seconds, self._checkpoint, self._free())

    def _free(self) -> int | None:
        """Space left on the disk of the attempt; None: the disk does not say."""
        with suppress(OSError):
            return free_bytes(self._directory.parent)
        return None

    # --- while it is under way -------------------------------------------------------------------

    def _watch(self, child: warm.Child) -> Words | None:
        """The words that end the order; None when there are none to come."""
        limit, kill_at = self._begin + self._ticket.seconds_limit, math.inf
        while True:
            is_alive = child.is_alive()
            for words in child.hear(TICK if is_alive else 0.0):
                if self._is_end(words):
                    return words
            now = time.monotonic()
            if (not is_alive and not child.has_more()) or now > kill_at:
                return None
            self._weigh(child)
            self._mind_log(now)
            if self._leave_at < now:
                self._leave_at = math.inf
                child.say({"leave": True})
            if self._cut is None and now > min(limit, self._stop_at):
                self._cut = Cause.LOST if now > self._stop_at else Cause.TIME_LIMIT
                child.say({"stop": True})
                kill_at = now + PATIENCE

    def _is_end(self, words: Words) -> bool:
        """Take in what the process says, and pass on what others should hear of."""
        if "taken" in words:
            self._taken = True
        elif "progress" in words:
            self._progress = words["progress"]
            if time.monotonic() - self._told >= TELL_INTERVAL:
                self._pass_on()
        elif "checkpoint" in words:
            self._checkpoint = words["checkpoint"]
            self._pass_on()
        return "spent" in words

    def _pass_on(self) -> None:
        if self._progress is None:
            return
        self._told = time.monotonic()
        told = {**self._progress, "seconds": self._told - self._begin}
        if self._checkpoint is not None:
            told["checkpoint"] = self._checkpoint
        self._tell(told)

    def _weigh(self, child: warm.Child) -> None:
        if self._ticket.memory_limit is not None:
            self._most_data = max(self._most_data, child.data())

    def _mind_log(self, now: float) -> None:
        if now - self._looked >= TELL_INTERVAL:
            self._looked = now
            attempt_log.cut(self._directory / LOG)

    # --- how it ended ----------------------------------------------------------------------------

    def _let_go(self, child: warm.Child, end: Words, slot: Slot) -> None:
        """Keep the process for the next order, unless something may be wrong with it."""
        is_fit = ("done" in end or "left" in end) and not end["spent"] and self._cut is None
        if is_fit:
            slot.release(child)
        else:
            child.end()

    def _judge(self, end: Words) -> Ending:
        """From the last words."""
        if "done" in end:  # also if it was about to be stopped
            missing = self._missing()
            if not missing:
                return self._collect()
            reason = f"the process ended without {', '.join(missing)}"
            return self.ending(Cause.ERROR, "MissingFile", reason)
        if "left" in end:
            return self.ending(Cause.LOST, "Left", "left on request, after a checkpoint")
        error = end["error"]
        if error["memory"]:
            return self._out_of_memory(error["failure"], error["reason"])
        if error["errno"] in ILL:
            return self.pause(error["failure"], error["reason"])
        return self.ending(Cause.ERROR, error["failure"], error["reason"])

    def _judge_dead(self, status: int | None) -> Ending:
        """Without last words: we ended it, or it died, or it cannot even die."""
        if status is None:
            return self.pause(
                "Stuck", f"its process was killed, and has not ended {warm.KILL_SECONDS:g} s later"
            )
        if self._cut is Cause.LOST:
            return self.ending(Cause.LOST, "Stopped", "stopped on request")
        if self._cut is Cause.TIME_LIMIT:
            limit = f"stopped after the limit of {self._ticket.seconds_limit:g} s"
            return self.ending(Cause.TIME_LIMIT, "TimeLimit", limit)
        name = signal.Signals(-status).name if status < 0 else f"status {status}"
        if status == STATUS_MEMORY or self._died_of_its_limit():
            return self._out_of_memory(name, "the process died")
        return self.ending(Cause.CRASH, name, f"the process died: {name}")

    def _died_of_its_limit(self) -> bool:
        limit = self._ticket.memory_limit
        if limit is None:
            return False
        last = attempt_log.last_bytes(self._directory / LOG, LAST_WORDS)
        return self._most_data > AT_THE_LIMIT * limit or any(one in last for one in WANT_OF_MEMORY)

    def _out_of_memory(self, failure: str, reason: str) -> Ending:
        limit = self._ticket.memory_limit
        allowed = "" if limit is None else f"; a run may use {limit / 1e9:.3g} GB"
        return self.ending(
            Cause.MEMORY_LIMIT, failure, f"out of memory: {reason or failure}{allowed}"
        )

    def _missing(self) -> list[str]:
        """Files that the attempt must leave, and has not."""
        names = FILES[self._ticket.kind]
        return [name for name in names if not (self._directory / name).is_file()]

    def _collect(self) -> Ending:
        """The files of an attempt that succeeded."""
        kind = self._ticket.kind
        files = [self._directory / name for name in (*FILES[kind], *MORE_FILES[kind])]
        return self.ending(None, files=tuple(describe(file) for file in files if file.is_file()))
