"""What an attempt left becomes a row: its result, another try, or its failure."""

import logging
from dataclasses import replace

from service.files.artifacts import LOG, Artifacts
from service.files.disk_space import Space, is_want_of_space
from service.files.lost_results import TooManyLost
from service.queue.backoff import Rests
from service.queue.verification import Found
from service.records.attempt import Ending, legible
from service.records.fault_points import point
from service.records.jobs import Cause, Claim, State, Stored, crashes_before, may_try_again
from service.records.logs import about
from service.store import Store

log = logging.getLogger(__name__)

REFUSED_SECONDS = 60.0  # until a publication that lost too many results looks for them again


class Registrar:
    """Brings ended attempts into their rows; after it, an attempt is over whatever happens."""

    def __init__(self, store: Store, artifacts: Artifacts, space: Space):
        self.rests = Rests()
        self.refused: dict[str, str] = {}  # by publication: why its lost results are not forgotten
        self._store = store
        self._artifacts = artifacts
        self._space = space

    def settle(self, claim: Claim, found: Found) -> None:
        """One ended attempt; raises StoreUnavailable when it has to be tried again later."""
        ending = found.ending
        if not found.losses:
            self.refused.pop(claim.id, None)
        if ending.cause is None:
            counts = self._register(claim, found)
        elif found.losses:
            counts = self._lose(claim, found)
        else:
            ending = self._excused(ending)
            counts = self._give_up(claim, ending, found.files)
        log.log(
            logging.INFO if counts and not found.losses else logging.WARNING,
            "%s %s: %s",
            claim.kind,
            claim.key,
            (ending.reason or "done") if counts else "too late, it no longer counts",
            extra=about(claim),
        )

    def abandon(self, claim: Claim, error: Exception) -> None:
        """Fail an attempt whose end cannot be brought into its row, however often it is tried."""
        reason = legible(f"its end cannot be brought into the database: {error}")
        self._store.fail(claim, Cause.ERROR, failure=type(error).__name__, reason=reason)
        self.rests.end(claim)

    def _register(self, claim: Claim, found: Found) -> bool:
        self.rests.end(claim)
        if found.result is None:
            point("publication-before-registration")
            seconds = found.ending.seconds
            counts = self._store.publish(claim, found.files, seconds=seconds)
            point("publication-after-commit")
            return counts
        point("result-before-registration")
        counts = self._store.finish(claim, found.result)
        point("result-after-commit")
        return self._end_with_result(claim, counts)

    def _give_up(self, claim: Claim, ending: Ending, files: tuple[Stored, ...]) -> bool:
        """An attempt without result: another try if the budget of its cause allows, else a failure."""
        assert ending.cause is not None
        cause, step = ending.cause, ending.checkpoint
        if may_try_again(cause, crashes_before(claim, step)):
            state = self._store.requeue(claim, cause, reason=ending.reason, crash_step=step)
            self._rest(claim, ending, state)
            return state is not None
        self.rests.end(claim)
        written = self._artifacts.attempt_directory(claim) / LOG
        return self._store.fail(
            claim,
            cause,
            failure=ending.failure,
            reason=f"{ending.reason} (log: {self._artifacts.relative(written)})",
            crash_step=step,
            files=files,
        )

    def _lose(self, claim: Claim, found: Found) -> bool:
        """Have lost results computed again; where these are too many, look again later: a disk may come back."""
        try:
            counts = self._store.lose_results(claim, found.losses)
        except TooManyLost as error:
            if claim.id not in self.refused:
                names = ", ".join(one.run_id for one in found.losses)
                log.error("%s; in %s: %s", error, self._artifacts.root, names, extra=about(claim))
            self.refused[claim.id] = str(error)
            self.rests.rest(claim, REFUSED_SECONDS)
            return self._store.requeue(claim, Cause.LOST, reason=str(error)) is not None
        self.refused.pop(claim.id, None)
        return counts

    def _rest(self, claim: Claim, ending: Ending, state: State | None) -> None:
        """Let it rest if it was lost again and again; one that was stopped on request was not."""
        if ending.cause is not Cause.LOST or state is not State.QUEUED:
            self.rests.end(claim)
            return
        seconds = self.rests.lose(claim, ending.checkpoint)
        if seconds:
            words = "%s was lost again; it rests for %.0f s"
            log.warning(words, claim.key, seconds, extra=about(claim))

    def _end_with_result(self, claim: Claim, counts: bool) -> bool:
        """Nobody goes on from the checkpoint of a run that has a result; what stays, care removes."""
        if counts:
            try:
                self._artifacts.discard_checkpoint(claim.id)
            except OSError as error:
                log.warning("the checkpoint of %s stays for now: %s", claim.key, error)
        return counts

    def _excused(self, ending: Ending) -> Ending:
        """An attempt that ended for want of disk space.

        If there was none at its end, that says nothing about its run: it was lost. If there was some
        again, it may be the run that never fits, which counts as a crash.
        """
        if not is_want_of_space(ending, self._space):
            return ending
        self._space.rest()
        cause = Cause.LOST if self._space.is_used_up(ending.free) else Cause.CRASH
        return replace(ending, cause=cause, reason=f"the disk was full: {ending.reason}")
