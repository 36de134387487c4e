"""What an attempt left, looked at: digests are compared and files brought to the disk, beside the turns.

A film may have gigabytes: whoever works through the queue does not wait for it, so this happens in
threads and touches no row. ``service.registration`` brings what was found into the rows.
"""

import errno
from collections.abc import Callable, Mapping
from concurrent.futures import Future, ThreadPoolExecutor, wait
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from service.artifacts import LOG, Artifacts, describe
from service.attempt import Ending, legible
from service.jobs import ANSWER, Cause, Claim, Kind, Result, Stored, StoreUnavailable
from service.rereads import REREADS, Rereads, summary_of

# Not the attempt's fault, and worth another look: no space for a name, no descriptor, no memory.
PASSING = frozenset({errno.ENOSPC, errno.EDQUOT, errno.EMFILE, errno.ENFILE, errno.ENOMEM})
THREADS = 4
WAIT_SECONDS = 0.1  # that a turn waits for the looks it begins: most take a few milliseconds


@dataclass(frozen=True)
class Found:
    """What an attempt left, safe on the disk."""

    ending: Ending  # its words legible; without a cause: the files are those of a result
    files: tuple[
        Stored, ...
    ]  # with paths as rows have them; of a failed run its log, if there is one
    result: Result | None = None  # of a run
    rereads: Rereads | None = None  # of a publication


class Inspector:
    """Looks at what attempts left; never at a row."""

    def __init__(self, artifacts: Artifacts):
        self._artifacts = artifacts

    def look(self, claim: Claim, ending: Ending) -> Found:
        """What one attempt left; raises StoreUnavailable when it has to be looked at again later.

        One that was lost may have done its work all the same, with nobody left to say so.
        """
        try:
            ending = self._completed(claim, ending)
            if ending.cause is None:
                return self._checked(claim, ending)
        except (OSError, ValueError, LookupError, TypeError, AttributeError) as error:
            ending = _unusable(ending, error)
        ending = replace(ending, failure=legible(ending.failure), reason=legible(ending.reason))
        return Found(ending, self._log_of_a_run(claim))

    def _completed(self, claim: Claim, ending: Ending) -> Ending:
        """The same, or its success; publications are cheap, and made again."""
        if ending.cause is not Cause.LOST or claim.kind is not Kind.RUN:
            return ending
        files = self._artifacts.complete_files(claim)
        return Ending(None, "", "complete on disk", files, 0.0) if files else ending

    def _checked(self, claim: Claim, ending: Ending) -> Found:
        """Complete files, after a look at their digests."""
        files = tuple(self._as_in_rows(file) for file in ending.files)
        damaged = [file.name for file in files if not self._artifacts.is_intact(file)]
        if damaged:
            raise ValueError(f"{', '.join(damaged)} does not match its checksum")
        self._artifacts.bring_to_disk(self._artifacts.attempt_directory(claim))
        if claim.kind is Kind.PUBLISH:
            return Found(ending, files, rereads=self._rereads(files))
        return Found(ending, files, result=self._result(files, ending.seconds))

    def _rereads(self, files: tuple[Stored, ...]) -> Rereads | None:
        """Results that were read again for a publication, after a look at their digests."""
        told = next((file for file in files if file.name == REREADS), None)
        if told is None:
            return None
        rereads = Rereads.from_json(self._artifacts.read_json(told))
        runs = [replace(one, answer=self._as_in_rows(one.answer)) for one in rereads.runs]
        for one in runs:
            if not self._artifacts.is_intact(one.answer):
                raise ValueError(f"{one.answer.path} does not match its checksum")
        return replace(rereads, runs=tuple(runs))

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


class Looks:
    """Looks under way in threads, by the keys of their attempts."""

    def __init__(self, inspector: Inspector, wake: Callable[[], None]):
        self._inspector = inspector
        self._wake = wake  # called when one is done
        self._threads = ThreadPoolExecutor(THREADS, thread_name_prefix="look")
        self._looks: dict[str, Future[Found]] = {}

    def begin(self, ended: Mapping[str, tuple[Claim, Ending]], *, seconds: float) -> None:
        """Look at these, unless that is under way; wait at most so long for the new ones."""
        new = [key for key in ended if key not in self._looks]
        for key in new:
            self._looks[key] = self._threads.submit(self._inspector.look, *ended[key])
        wait([self._looks[key] for key in new], timeout=seconds)
        for key in new:
            if not self._looks[key].done():
                self._looks[key].add_done_callback(lambda _: self._wake())

    def is_over(self, key: str) -> bool:
        """Whether it is known what an attempt left."""
        return key in self._looks and self._looks[key].done()

    def take(self, key: str) -> Found:
        """What an attempt left; it is looked at again when that is asked for again."""
        return self._looks.pop(key).result()

    def forget(self, key: str) -> None:
        """Nobody wants to know."""
        self._looks.pop(key, None)

    def close(self) -> None:
        """Begin no more of them."""
        self._threads.shutdown(wait=False, cancel_futures=True)


def _legible_or_none(text: Any) -> str | None:
    return None if text is None else legible(str(text))


def _unusable(ending: Ending, error: Exception) -> Ending:
    """Files that cannot be registered are as good as a crash; raises StoreUnavailable if that may pass."""
    if isinstance(error, OSError) and error.errno in PASSING:
        raise StoreUnavailable(f"a result cannot be registered now: {error}") from error
    if ending.cause is not None:  # it was lost, and nobody can say what it left
        return ending
    reason = f"its files cannot be registered: {error}"
    return replace(ending, cause=Cause.CRASH, failure=type(error).__name__, reason=reason)
