"""Verification of results: files are compared with their digests and synced to the disk, in threads beside the ticks.

A film may have gigabytes, and the dispatcher does not wait for it. Verification touches no row;
``service.queue.registration`` does. A disk that several machines share may fail, or show a file late: that is no fault
of the attempt, so such errors are retried for a while before they count.
"""

import errno
import json
import logging
import time
from collections.abc import Callable, Iterable, Mapping
from concurrent.futures import Future, ThreadPoolExecutor, wait
from dataclasses import dataclass, replace
from pathlib import Path

from service.files.artifacts import FOR_PUBLICATIONS, LOG, Artifacts, describe
from service.files.lost_results import Loss, ResultsLost, list_in
from service.files.stores import FilesAway
from service.records.jobs import Cause, Kind, Lease, MeasurementSummary, Result, Stored, Summary
from service.workers.attempt import Ending, legible
from service.workers.supervisor import BROKEN_MOUNT
from service.workers.timings import Timings
from solver.errors import WhippleError
from studies.convergence.experience import MeshError, without_mesh_error
from studies.quantities.files import COVER, RESULT
from studies.quantities.measured import Measured
from studies.reports.cover import read_cover
from studies.runs.results import RunResult

log = logging.getLogger(__name__)

# This process lacks space for a name, a descriptor or memory, which says nothing about the attempt.
OWN_SHORTAGE = frozenset({errno.ENOSPC, errno.EDQUOT, errno.EMFILE, errno.ENFILE, errno.ENOMEM})
# The disk or the attempt may be at fault: the first error does not tell.
TRANSIENT_ERRORS = BROKEN_MOUNT | {errno.ENOENT}
THREADS = 4


class Unreadable(WhippleError):
    """The files of an attempt cannot be read now; a little later they may be."""


class Damaged(ValueError):
    """A file does not match its digest: it is damaged, or the disk does not show all of it yet."""


@dataclass(frozen=True)
class VerifiedEnding:
    """How an attempt ended, with files that are safe on the disk."""

    ending: Ending  # legible; without a cause, the files are those of a result
    files: tuple[Stored, ...]  # paths as in rows; of a failed run its log, if there is one
    result: Result | None = None  # of a run
    losses: tuple[Loss, ...] = ()  # results that a publication needs and that cannot be read
    headline: str = ""  # of a publication


@dataclass(frozen=True)
class _Retry:
    """An attempt whose files could not be read."""

    since: float  # monotonic: of the first error
    not_before: float  # monotonic: of the next try


class Verification:
    """Verifications under way in threads, by the keys of their attempts."""

    def __init__(
        self,
        artifacts: Artifacts,
        wake: Callable[[], None],
        timings: Timings,
        files_of: Callable[[str], Iterable[Stored]],
    ):
        self._artifacts = artifacts
        self._files_of = files_of  # registered files of a run
        self._wake = wake  # called when a verification is done later than waited for
        self._timings = timings
        self._threads = ThreadPoolExecutor(THREADS, thread_name_prefix="verification")
        self._running: dict[str, Future[VerifiedEnding]] = {}
        self._retries: dict[str, _Retry] = {}

    def begin(self, ended: Mapping[str, tuple[Lease, Ending]], *, seconds: float) -> None:
        """Start to verify the endings that are not in progress or delayed; wait up to ``seconds``."""
        now, begun = time.monotonic(), list[Future[VerifiedEnding]]()
        for key, (lease, ending) in ended.items():
            retry = self._retries.get(key)
            if key in self._running or (retry is not None and retry.not_before > now):
                continue
            may_retry = retry is None or now - retry.since < self._timings.verification_retry_limit
            self._running[key] = self._threads.submit(self._verify_and_keep, lease, ending, may_retry)
            begun.append(self._running[key])
        for late in wait(begun, timeout=seconds).not_done:
            late.add_done_callback(lambda _: self._wake())

    def take(self, key: str) -> VerifiedEnding | None:
        """The verified ending of an attempt; None: it is not verified yet."""
        if key not in self._running or not self._running[key].done():
            return None
        try:
            return self._running.pop(key).result()
        except Unreadable as error:
            log.warning("%s: %s", key, error)
            now = time.monotonic()
            since = self._retries[key].since if key in self._retries else now
            self._retries[key] = _Retry(since, now + self._timings.verification_retry)
            return None

    def forget(self, key: str) -> None:
        self._running.pop(key, None)
        self._retries.pop(key, None)

    def clear(self) -> None:
        """Verify everything again: the data directory was away, or another service leads."""
        self._running.clear()
        self._retries.clear()

    def close(self) -> None:
        """Begin no more verifications."""
        self._threads.shutdown(wait=False, cancel_futures=True)

    # --- in a thread -----------------------------------------------------------------------------

    def _verify_and_keep(self, lease: Lease, ending: Ending, may_retry: bool) -> VerifiedEnding:
        """Verify one ending, and write its files to the bucket; raises Unreadable, also while the bucket is away."""
        try:
            verified = self._verify(lease, ending, may_retry)
            self._artifacts.keep(verified.files)
        except FilesAway as error:
            raise Unreadable(f"a result cannot be registered now: {error}") from error
        return verified

    def _verify(self, lease: Lease, ending: Ending, may_retry: bool) -> VerifiedEnding:
        """Verify one ending; raises Unreadable for a shortage of our own and, with ``may_retry``, for errors that pass.

        A lost attempt may be complete on the disk, with nobody left to report it; publications are cheap, and made
        again.
        """
        try:
            if ending.cause is Cause.LOST and lease.kind is Kind.RUN:
                files = self._artifacts.complete_files(lease)
                if files:
                    complete = Ending(None, "", "complete on disk", files, 0.0)
                    return self._verify_files(lease, complete)
            if ending.cause is None:
                return self._verify_files(lease, ending)
            if ending.failure == ResultsLost.__name__:
                return self._verify_losses(lease, ending)
        except FilesAway:
            raise
        except (OSError, ValueError, LookupError, TypeError, AttributeError) as error:
            code = error.errno if isinstance(error, OSError) else None
            is_transient = code in TRANSIENT_ERRORS or isinstance(error, Damaged)
            if code in OWN_SHORTAGE or (may_retry and is_transient):
                raise Unreadable(f"a result cannot be registered now: {error}") from error
            if ending.cause is None:  # files that cannot be registered are as good as a crash
                reason = f"the files of the attempt cannot be registered: {error}"
                failure = type(error).__name__
                ending = replace(ending, cause=Cause.CRASH, failure=failure, reason=reason)
        ending = replace(ending, failure=legible(ending.failure), reason=legible(ending.reason))
        return VerifiedEnding(ending, self._log_of_a_run(lease))

    def _verify_losses(self, lease: Lease, ending: Ending) -> VerifiedEnding:
        """The results that a publication could not read, and that neither disk nor bucket has here."""
        listed = list_in(self._artifacts.attempt_directory(lease))
        for stored in (file for loss in listed for file in self._files_of(loss.run_id)):
            if stored.name in FOR_PUBLICATIONS:
                self._artifacts.local(stored)
        losses = tuple(loss for loss in listed if loss.is_real())
        if not losses:
            ending = replace(ending, cause=Cause.LOST, reason=f"the worker reports: {ending.reason}")
        return VerifiedEnding(ending, (), losses=losses)

    def _verify_files(self, lease: Lease, ending: Ending) -> VerifiedEnding:
        """Complete files with the right digests; a log that is still written to is left out."""
        reported = [self._as_in_rows(file) for file in ending.files]
        damaged = {file.name for file in reported if not self._artifacts.is_intact(file)}
        if damaged - {LOG}:
            raise Damaged(f"{', '.join(sorted(damaged))} does not match its checksum")
        files = tuple(file for file in reported if file.name not in damaged)
        self._artifacts.bring_to_disk(self._artifacts.attempt_directory(lease))
        if lease.kind is Kind.PUBLISH:
            cover = next((self._artifacts.path(file) for file in files if file.name == COVER), None)
            return VerifiedEnding(ending, files, headline=legible(read_cover(cover).headline) if cover else "")
        return VerifiedEnding(ending, files, result=self._result(files, ending.seconds))

    def _result(self, files: tuple[Stored, ...], seconds: float) -> Result:
        """The part of a result that rows store: all fields except histories."""
        answer_file = next((file for file in files if file.name == RESULT), None)
        if answer_file is None:
            raise ValueError(f"there is no {RESULT}")
        answer = RunResult.from_json(json.loads(self._artifacts.path(answer_file).read_bytes()))
        return Result(
            files=files,
            succeeded=answer.state == "succeeded",
            reason=None if answer.reason is None else legible(answer.reason),
            failure=None if answer.failure is None else legible(answer.failure),
            summary=summary_of(answer),
            seconds=seconds or float(answer.provenance.get("seconds", 0.0)),
        )

    def _log_of_a_run(self, lease: Lease) -> tuple[Stored, ...]:
        """The log of a run without result, if it can be read; a publication keeps the files of the last one."""
        if lease.kind is not Kind.RUN:
            return ()
        folder = self._artifacts.attempt_directory(lease)
        try:
            file = self._as_in_rows(describe(folder / LOG))
            self._artifacts.bring_to_disk(folder)
        except OSError:
            return ()
        return (file,)

    def _as_in_rows(self, file: Stored) -> Stored:
        """A file that a worker described, with its path relative to the data directory."""
        return replace(file, path=self._artifacts.relative(Path(file.path)))


def summary_of(result: RunResult) -> Summary:
    """The part of a result that rows store: all fields except histories.

    The values are without their mesh errors where the result has these, and the raw reading stands beside.
    """
    measured = {name: _summarized(measurement) for name, measurement in result.measurements.items()}
    return {"measurements": measured, "flags": result.flags, "numbers": result.numbers, "stop": result.stop}


def _summarized(reading: Measured) -> MeasurementSummary:
    known, raw = reading, MeasurementSummary()
    if error := reading.mesh_error:
        known = without_mesh_error(reading, MeshError(error["bias"], error["scale"], bool(error.get("independent"))))
        raw = {"raw": reading.value}
    bar, flags = known.uncertainty, known.flags
    return {"value": known.value, "uncertainty": bar, "flags": flags, "version": known.version, **raw}
