"""Registration: a verified ending becomes a result in the rows, another attempt, or a failure."""

import logging

from service.files.artifacts import LOG, Artifacts
from service.files.disk_space import Space
from service.files.lost_results import TooManyLost
from service.logs import about
from service.queue import retry
from service.queue.verification import VerifiedEnding
from service.records.jobs import Cause, Lease, State, Stored
from service.store import Store
from service.workers.attempt import Ending, legible
from service.workers.timings import Timings

log = logging.getLogger(__name__)


class Registrar:
    """Registers ended attempts; after it, an attempt is over whatever happens."""

    def __init__(self, store: Store, artifacts: Artifacts, space: Space, timings: Timings):
        self.backoff = retry.Backoff(timings)
        self.blocking: dict[str, str] = {}  # by publication: why its lost results are not forgotten
        self._store = store
        self._artifacts = artifacts
        self._space = space
        self._timings = timings

    def register(self, lease: Lease, verified: VerifiedEnding) -> None:
        """Register one ended attempt; raises StoreUnavailable when it has to be tried again later."""
        ending = verified.ending
        if not verified.losses:
            self.blocking.pop(lease.id, None)
        if ending.cause is None:
            counts = self._succeed(lease, verified)
        elif verified.losses:
            counts = self._lose_results(lease, verified)
        else:
            ending = retry.excuse_full_disk(ending, self._space)
            counts = self._retry_or_fail(lease, ending, verified.files)
        log.log(
            logging.INFO if counts and not verified.losses else logging.WARNING,
            "%s %s: %s",
            lease.kind,
            lease.key,
            (ending.reason or "done") if counts else "it arrived too late and is discarded",
            extra=about(lease),
        )

    def abandon(self, lease: Lease, error: Exception) -> None:
        """Fail an attempt whose ending cannot be registered."""
        reason = legible(f"the end of the attempt cannot be written to the database: {error}")
        self._store.leases.fail(lease, Cause.ERROR, failure=type(error).__name__, reason=reason)
        self.backoff.clear(lease)

    def _succeed(self, lease: Lease, verified: VerifiedEnding) -> bool:
        self.backoff.clear(lease)
        if verified.result is None:
            seconds, headline = verified.ending.seconds, verified.headline
            return self._store.leases.publish(lease, verified.files, seconds=seconds, headline=headline)
        counts = self._store.leases.finish(lease, verified.result)
        if counts:
            try:
                self._artifacts.discard_checkpoint(lease.id)
            except OSError as error:  # garbage collection removes it later
                log.warning("the checkpoint of %s cannot be removed yet: %s", lease.key, error)
        return counts

    def _retry_or_fail(self, lease: Lease, ending: Ending, files: tuple[Stored, ...]) -> bool:
        """Queue the job of an attempt without result again, or fail it."""
        assert ending.cause is not None
        cause, decision = ending.cause, retry.decide(lease, ending.cause, ending.checkpoint)
        if decision.again:
            state = self._store.leases.requeue(lease, cause, reason=ending.reason, crashes=decision.crashes)
            if cause is not Cause.LOST or state is not State.QUEUED:  # one that was stopped on request was not lost
                self.backoff.clear(lease)
            elif seconds := self.backoff.lose(lease, ending.checkpoint):
                message = "%s was lost again; the next attempt starts in %.0f s"
                log.warning(message, lease.key, seconds, extra=about(lease))
            return state is not None
        self.backoff.clear(lease)
        written = self._artifacts.attempt_directory(lease) / LOG
        return self._store.leases.fail(
            lease,
            cause,
            failure=ending.failure,
            reason=f"{ending.reason} (log: {self._artifacts.relative(written)})",
            crashes=decision.crashes,
            files=files,
        )

    def _lose_results(self, lease: Lease, verified: VerifiedEnding) -> bool:
        """Have lost results computed again; too many are verified again later, as a disk may come back."""
        try:
            counts = self._store.publications.lose_results(lease, verified.losses, most=retry.MOST_LOST_RESULTS)
        except TooManyLost as error:
            if lease.id not in self.blocking:
                ids = ", ".join(loss.run_id for loss in verified.losses)
                log.error("%s; in %s: %s", error, self._artifacts.root, ids, extra=about(lease))
            self.blocking[lease.id] = str(error)
            self.backoff.delay(lease, self._timings.lost_results_retry)
            return self._store.leases.requeue(lease, Cause.LOST, reason=str(error)) is not None
        self.blocking.pop(lease.id, None)
        return counts
