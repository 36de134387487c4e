"""What an attempt left, looked at: digests are compared and files brought to the disk, beside the turns.

A film may have gigabytes: whoever works through the queue does not wait for it, so this happens in
threads and touches no row. ``service.queue.registration`` brings what was found into the rows.

A disk that several machines share may be ill here, or show a file late: that is no fault of the
attempt's, so trouble of this kind has a while to pass before it is held against it.
"""

import errno
import logging
import time
from collections.abc import Callable, Mapping
from concurrent.futures import Future, ThreadPoolExecutor, wait
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import Any

from service.files.artifacts import LOG, Artifacts, describe
from service.files.lost_results import Loss, ResultsLost, list_in
from service.records.attempt import Ending, legible
from service.records.jobs import Cause, Claim, Kind, Result, Stored
from service.workers.supervisor import ILL
from solver.errors import WhippleError
from studies.values.files import ANSWER

log = logging.getLogger(__name__)

# Our own want, which says nothing about the attempt: no space for a name, no descriptor, no memory.
PASSING = frozenset({errno.ENOSPC, errno.EDQUOT, errno.EMFILE, errno.ENFILE, errno.ENOMEM})
# Of the disk or of the attempt: nobody can say at the first look.
DOUBTFUL = ILL | {errno.ENOENT}
DOUBT_SECONDS = 60.0  # for what is doubtful to pass; attributes of files on NFS are as old as that
AGAIN_SECONDS = 5.0  # between two looks at what one attempt left
THREADS = 4
WAIT_SECONDS = 0.1  # that a turn waits for the looks it begins: most take a few milliseconds


class LookAgain(WhippleError):
    """What an attempt left cannot be seen now; a little later it may be."""


class Damaged(ValueError):
    """A file is not what whoever wrote it said: it is damaged, or the disk does not show it yet."""


@dataclass(frozen=True)
class Found:
    """What an attempt left, safe on the disk."""

    ending: Ending  # its words legible; without a cause: the files are those of a result
    files: tuple[
        Stored, ...
    ]  # with paths as rows have them; of a failed run its log, if there is one
    result: Result | None = None  # of a run
    losses: tuple[Loss, ...] = ()  # results that a publication needs, and that are not there


class Inspector:
    """Looks at what attempts left; never at a row."""

    def __init__(self, artifacts: Artifacts):
        self._artifacts = artifacts

    def look(self, claim: Claim, ending: Ending, *, in_doubt: bool = False) -> Found:
        """What one attempt left; raises LookAgain for our own want and, ``in_doubt``, for trouble that may pass.

        One that was lost may have done its work all the same, with nobody left to say so.
        """
        try:
            completed = self._completed(claim, ending)
            if completed.cause is None:
                return self._checked(claim, completed)
            if ending.failure == ResultsLost.__name__:
                return self._without_results(claim, ending)
        except (OSError, ValueError, LookupError, TypeError, AttributeError) as error:
            if _is_passing(error) or (in_doubt and _is_doubtful(error)):
                raise LookAgain(f"a result cannot be registered now: {error}") from error
            ending = _unusable(ending, error)
        ending = replace(ending, failure=legible(ending.failure), reason=legible(ending.reason))
        return Found(ending, self._log_of_a_run(claim))

    def _without_results(self, claim: Claim, ending: Ending) -> Found:
        """A publication that could not read results: those that cannot be read here either are lost."""
        listed = list_in(self._artifacts.attempt_directory(claim))
        losses = tuple(one for one in listed if one.is_real())
        if not losses:
            ending = replace(ending, cause=Cause.LOST, reason=f"on its worker {ending.reason}")
        return Found(ending, (), losses=losses)

    def _completed(self, claim: Claim, ending: Ending) -> Ending:
        """The same, or its success; publications are cheap, and made again."""
        if ending.cause is not Cause.LOST or claim.kind is not Kind.RUN:
            return ending
        files = self._artifacts.complete_files(claim)
        return Ending(None, "", "complete on disk", files, 0.0) if files else ending

    def _checked(self, claim: Claim, ending: Ending) -> Found:
        """Complete files, after a look at their digests; a log to which somebody still writes is none."""
        told = [self._as_in_rows(file) for file in ending.files]
        damaged = [file.name for file in told if not self._artifacts.is_intact(file)]
        files = tuple(file for file in told if file.name not in damaged)
        if set(damaged) - {LOG}:
            raise Damaged(f"{', '.join(damaged)} does not match its checksum")
        self._artifacts.bring_to_disk(self._artifacts.attempt_directory(claim))
        if claim.kind is Kind.PUBLISH:
            return Found(ending, files)
        return Found(ending, files, result=self._result(files, ending.seconds))

    def _result(self, files: tuple[Stored, ...], seconds: float) -> Result:
        """What rows keep of a result: everything but histories."""
        if all(file.name != ANSWER for file in files):
            raise ValueError(f"there is no {ANSWER}")
        result = Result(
            files=files, succeeded=True, reason=None, failure=None, summary={}, seconds=seconds
        )
        answer = self._artifacts.read_json(result.answer)
        return replace(
            result,
            succeeded=answer["state"] == "succeeded",
            reason=_legible_or_none(answer["reason"]),
            failure=_legible_or_none(answer["failure"]),
            summary=summary_of(answer),
            seconds=seconds or float(answer["provenance"].get("seconds", 0.0)),
        )

    def _log_of_a_run(self, claim: Claim) -> tuple[Stored, ...]:
        """The log of a run without result; a publication keeps the files of the one before."""
        if claim.kind is not Kind.RUN:
            return ()
        folder = self._artifacts.attempt_directory(claim)
        try:
            log = self._as_in_rows(describe(folder / LOG))
            self._artifacts.bring_to_disk(folder)
        except OSError:  # it wrote none, or cannot be read
            return ()
        return (log,)

    def _as_in_rows(self, file: Stored) -> Stored:
        """A file that a worker described, with its path as rows have it."""
        return replace(file, path=self._artifacts.relative(Path(file.path)))


@dataclass(frozen=True)
class _Trouble:
    """What an attempt left could not be seen."""

    since: float  # monotonic
    not_before: float  # monotonic; of the next look


class Looks:
    """Looks under way in threads, by the keys of their attempts."""

    def __init__(self, inspector: Inspector, wake: Callable[[], None]):
        self._inspector = inspector
        self._wake = wake  # called when one is done
        self._threads = ThreadPoolExecutor(THREADS, thread_name_prefix="look")
        self._looks: dict[str, Future[Found]] = {}
        self._troubles: dict[str, _Trouble] = {}

    def begin(self, ended: Mapping[str, tuple[Claim, Ending]], *, seconds: float) -> None:
        """Look at these, unless that is under way or too early; wait at most so long for the new ones."""
        now, trouble = time.monotonic(), self._troubles
        new = [
            key
            for key in ended
            if key not in self._looks and (key not in trouble or trouble[key].not_before <= now)
        ]
        for key in new:
            in_doubt = key not in trouble or now - trouble[key].since < DOUBT_SECONDS
            look = partial(self._inspector.look, *ended[key], in_doubt=in_doubt)
            self._looks[key] = self._threads.submit(look)
        wait([self._looks[key] for key in new], timeout=seconds)
        for key in new:
            if not self._looks[key].done():
                self._looks[key].add_done_callback(lambda _: self._wake())

    def take(self, key: str) -> Found | None:
        """What an attempt left, None: it is not known yet; it is looked at again when asked for again."""
        if key not in self._looks or not self._looks[key].done():
            return None
        try:
            return self._looks.pop(key).result()
        except LookAgain as error:
            log.warning("%s: %s", key, error)
            now = time.monotonic()
            since = self._troubles[key].since if key in self._troubles else now
            self._troubles[key] = _Trouble(since, now + AGAIN_SECONDS)
            return None

    def forget(self, key: str) -> None:
        """Nobody wants to know."""
        self._looks.pop(key, None)
        self._troubles.pop(key, None)

    def clear(self) -> None:
        """Look at everything again: what was seen no longer counts."""
        self._looks.clear()

    def close(self) -> None:
        """Begin no more of them."""
        self._threads.shutdown(wait=False, cancel_futures=True)


def summary_of(answer: Mapping[str, Any]) -> dict[str, Any]:
    """What rows keep of a result (``RunResult.as_json``): everything but histories."""
    words = ("value", "uncertainty", "flags", "version")
    measured = {
        name: {word: one[word] for word in words if word in one}
        for name, one in answer["measurements"].items()
    }
    told = {key: answer[key] for key in ("flags", "numbers", "stop") if key in answer}
    return {"measurements": measured, **told}


def _legible_or_none(text: Any) -> str | None:
    return None if text is None else legible(str(text))


def _is_passing(error: Exception) -> bool:
    return isinstance(error, OSError) and error.errno in PASSING


def _is_doubtful(error: Exception) -> bool:
    is_ill = isinstance(error, OSError) and error.errno in DOUBTFUL
    return is_ill or isinstance(error, Damaged)


def _unusable(ending: Ending, error: Exception) -> Ending:
    """Files that cannot be registered are as good as a crash."""
    if ending.cause is not None:  # it was lost, and nobody can say what it left
        return ending
    reason = f"its files cannot be registered: {error}"
    return replace(ending, cause=Cause.CRASH, failure=type(error).__name__, reason=reason)
