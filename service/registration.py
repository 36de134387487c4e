"""What an attempt left becomes a row: its result, another try, or its failure."""

import errno
import logging
from dataclasses import replace
from pathlib import Path

from service.artifacts import LOG, Artifacts, describe
from service.attempt import Ending
from service.faults import point
from service.jobs import (
    ANSWER,
    Cause,
    Claim,
    Kind,
    Result,
    Stored,
    StoreUnavailable,
    crashes_before,
    may_try_again,
)
from service.rereads import REREADS, Rereads, summary_of
from service.space import Space, is_want_of_space
from service.store import Store

log = logging.getLogger(__name__)

# Not the attempt's fault, and worth another look: no space for a name, no descriptor, no memory.
PASSING = frozenset({errno.ENOSPC, errno.EDQUOT, errno.EMFILE, errno.ENFILE, errno.ENOMEM})


class Registrar:
    """Brings ended attempts into their rows; after it, an attempt is over whatever happens."""

    def __init__(self, store: Store, artifacts: Artifacts, space: Space):
        self._store = store
        self._artifacts = artifacts
        self._space = space

    def settle(self, claim: Claim, ending: Ending) -> None:
        """One ended attempt; raises StoreUnavailable when it has to be tried again later.

        One that was lost may have done its work all the same, with nobody left to say so.
        """
        files = self._complete_files(claim) if ending.cause is Cause.LOST else ()
        if files:
            ending = Ending(None, "", "complete on disk", files, 0.0)
        if ending.cause is None:
            try:
                counts = self._register(claim, ending)
            except (OSError, ValueError, LookupError) as error:
                ending = _unusable(ending, error)
        if ending.cause is not None:
            ending = self._excused(ending)
            counts = self._give_up(claim, ending)
        log.log(
            logging.INFO if counts else logging.WARNING,
            "%s %s: %s",
            claim.kind,
            claim.key,
            (ending.reason or "done") if counts else "too late, it no longer counts",
            extra={"run": claim.key, "sweep": claim.sweep_id},
        )

    def _complete_files(self, claim: Claim) -> tuple[Stored, ...]:
        """What an attempt at a run left; publications are cheap, and made again."""
        return self._artifacts.complete_files(claim) if claim.kind is Kind.RUN else ()

    def _register(self, claim: Claim, ending: Ending) -> bool:
        """Registers complete files, after a look at their digests."""
        files = tuple(self._as_in_rows(file) for file in ending.files)
        damaged = [file.name for file in files if not self._artifacts.is_intact(file)]
        if damaged:
            raise ValueError(f"{', '.join(damaged)} does not match its checksum")
        self._artifacts.bring_to_disk(self._artifacts.attempt_directory(claim))
        if claim.kind is Kind.PUBLISH:
            point("publication-before-registration")
            rereads = self._rereads(files)
            counts = self._store.publish(claim, files, seconds=ending.seconds, rereads=rereads)
            point("publication-after-commit")
            return counts
        result = self._result(files, ending.seconds)
        point("result-before-registration")
        counts = self._store.finish(claim, result)
        point("result-after-commit")
        return self._end_with_result(claim, counts)

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

    def _give_up(self, claim: Claim, ending: Ending) -> bool:
        """An attempt without result: another try if the budget of its cause allows, else a failure."""
        assert ending.cause is not None
        cause, step = ending.cause, ending.checkpoint
        if may_try_again(cause, crashes_before(claim, step)):
            return self._store.requeue(claim, cause, reason=ending.reason, crash_step=step)
        written = self._artifacts.attempt_directory(claim) / LOG
        return self._store.fail(
            claim,
            cause,
            failure=ending.failure,
            reason=f"{ending.reason} (log: {self._artifacts.relative(written)})",
            crash_step=step,
            files=self._log_of_a_run(claim, written),
        )

    def _log_of_a_run(self, claim: Claim, written: Path) -> tuple[Stored, ...]:
        """The log of a run that failed; a publication keeps the files of the one before."""
        if claim.kind is not Kind.RUN:
            return ()
        try:
            return (self._as_in_rows(describe(written)),)
        except OSError:  # it wrote none, or cannot be read
            return ()

    def _end_with_result(self, claim: Claim, counts: bool) -> bool:
        """Nobody goes on from the checkpoint of a run that has a result; what stays, care removes."""
        if counts:
            try:
                self._artifacts.discard_checkpoint(claim.id)
            except OSError as error:
                log.warning("the checkpoint of %s stays for now: %s", claim.key, error)
        return counts

    def _excused(self, ending: Ending) -> Ending:
        """An attempt that ended for want of disk space says nothing about its run: it was lost."""
        if not is_want_of_space(ending, self._space):
            return ending
        self._space.rest()
        return replace(ending, cause=Cause.LOST, reason=f"the disk was full: {ending.reason}")

    def _as_in_rows(self, file: Stored) -> Stored:
        """A file that a worker described, with its path as rows have it."""
        return replace(file, path=self._artifacts.relative(Path(file.path)))

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
            reason=answer["reason"],
            failure=answer["failure"],
            summary=summary_of(answer),
            seconds=seconds or float(answer["provenance"].get("seconds", 0.0)),
        )


def _unusable(ending: Ending, error: Exception) -> Ending:
    """Files that cannot be registered are as good as a crash; raises StoreUnavailable if that may pass."""
    if isinstance(error, OSError) and error.errno in PASSING:
        raise StoreUnavailable(f"a result cannot be registered now: {error}") from error
    reason = f"its files cannot be registered: {error}"
    return replace(ending, cause=Cause.CRASH, failure=type(error).__name__, reason=reason)
