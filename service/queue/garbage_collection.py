"""Garbage collection in the data directory: expired sweeps, orphans and files that no sweep retains go, in small steps.

The folder of a job's last attempt counts, and so does whatever a row points to: a row forgets its file before the file
goes. The folder of a run or sweep that the store does not know stays: the directory may belong to another database, or
be newer than a restored backup. What an attempt left stays for ``retire_seconds``, so that its log can be read,
unless the disk is full. Orphans come first: on a full disk no row can be written.

Nothing goes by age while the clock is not believed (``clock_watch``), and by rule at most a tenth of the sweeps, and of
the runs, goes in a day.
"""

import logging
import re
import shutil
import time
from collections.abc import Iterator, Mapping, Sequence, Set
from contextlib import suppress
from dataclasses import dataclass
from enum import StrEnum
from itertools import islice
from pathlib import Path

from service.files.artifacts import CHECKPOINT, ID, PART, RUNS, SWEEPS, Artifacts, name_of_attempt
from service.files.disk_space import Space
from service.queue.clock_watch import ClockWatch
from service.records.clock import DAY
from service.records.jobs import KEPT_BY, TERMINAL, Conflict, LastAttempt, NotFound, State, Stored
from service.settings import Settings
from service.store import Store
from service.store.tables import batches
from service.workers.timings import DEFAULT, Timings

log = logging.getLogger(__name__)

ATTEMPT = re.compile(r"a(\d+)-[0-9a-f]+")
SHARD = re.compile("[0-9a-f]{2}")
SHARDS = [f"{number:02x}" for number in range(256)]
MOST_REMOVED = 50  # files or folders, in a step
MOST_DELETED = 5  # sweeps, in a step
FOLDERS_AT_ONCE = 50  # folders for which the store is asked together


class Reason(StrEnum):
    """The reason why a file or folder is an orphan."""

    ATTEMPT = "an attempt that does not count"
    TEMPORARY = "a temporary file"
    TEMPORARY_IN_USE = "a temporary file of a run that is under way"
    OLD_CHECKPOINT = "a checkpoint of a run that has a result"
    CHECKPOINT = "a checkpoint of a run that ended without a result"
    NOT_RETAINED = "a file that no sweep retains"
    DELETED = "left by a deleted sweep"
    FORGOTTEN = "left by a run that has had no sweep for a long time"


AT_ONCE = frozenset({Reason.DELETED, Reason.FORGOTTEN, Reason.OLD_CHECKPOINT})


@dataclass(frozen=True)
class Orphan:
    """A file or folder that does not count."""

    path: Path
    reason: Reason

    def age(self) -> float:
        """Seconds since something was written there."""
        try:
            newest = max(file.stat().st_mtime for file in (self.path, *self.path.glob("*")))
        except OSError:  # it was removed just now
            return 0.0
        return time.time() - newest

    def remove(self) -> None:
        """Remove the file, or the folder with all it holds."""
        if self.path.is_dir():
            shutil.rmtree(self.path, ignore_errors=True)
        else:
            self.path.unlink(missing_ok=True)


class GarbageCollector:
    """Goes round the data directory."""

    def __init__(
        self,
        settings: Settings,
        store: Store,
        artifacts: Artifacts,
        space: Space,
        clock: ClockWatch,
        timings: Timings = DEFAULT,
    ):
        self._store = store
        self._clock = clock
        self._artifacts = artifacts
        self._space = space
        self._timings = timings
        self._retire_seconds = settings.retire_seconds
        self._forget_seconds = settings.forget_seconds
        self._retention_days = settings.retention_days
        self._round = self._orphans()
        self._may_forget = True
        self._shards: Iterator[str] = iter(())
        self._shard: str | None = None
        self._began = -1  # number of the last event when the round of shards began

    def step(self) -> None:
        """Do a bounded part of the work; called by the leader at some of its ticks."""
        self._clock.look()
        self._remove_orphans(time.monotonic() + self._timings.collection_step)
        self._drop_files(time.monotonic() + self._timings.collection_drop)
        if self._may_forget:
            forgets_more = self._forget_runs()
            self._may_forget = self._delete_expired() or forgets_more

    def _forget_runs(self) -> bool:
        """Forget a few runs that have had no sweep for the time of the setting; whether there may be more."""
        if self._clock.is_paused(self._forget_seconds):
            return False
        retention = self._store.retention
        most = min(MOST_REMOVED, self._clock.may_go("runs", retention.runs, at_least=MOST_REMOVED))
        before = self._clock.moment_before(self._forget_seconds)
        if forgotten := retention.forget_runs(before, most) if most else 0:
            self._clock.note_gone("runs", forgotten)
        return forgotten == MOST_REMOVED

    def _delete_expired(self) -> bool:
        """Delete a few sweeps that ended more than the days of the setting ago; whether there are more."""
        if not self._retention_days or self._clock.is_paused(self._retention_days * DAY):
            return False
        expired = [*self._store.retention.expired(self._clock.moment_before(self._retention_days * DAY))]
        most = (
            min(MOST_DELETED, self._clock.may_go("sweeps", self._store.retention.sweeps, at_least=1)) if expired else 0
        )
        if going := expired[:most]:
            self._clock.note_gone("sweeps", len(going))
        for id in going:
            log.info("deleted: the sweep %s, which ended more than %g days ago", id, self._retention_days)
            with suppress(Conflict, NotFound):  # it was pinned, retried or deleted just now
                self._store.sweeps.delete(id)
        return len(going) == MOST_DELETED

    def _remove_orphans(self, end: float) -> None:
        """Remove orphans, from where the last step ended."""
        removed = 0
        while True:
            batch = next(self._round, None)
            if batch is None:  # once round
                self._round, self._may_forget = self._orphans(), True
                return
            due = (orphan for orphan in batch if self._is_due(orphan))
            for orphan in [*islice(due, MOST_REMOVED - removed)]:
                log.info("removed: %s (%s)", orphan.path, orphan.reason)
                orphan.remove()
                removed += 1
            if removed == MOST_REMOVED or time.monotonic() > end:
                return

    def _is_due(self, orphan: Orphan) -> bool:
        """Whether an orphan may go now."""
        if orphan.reason in AT_ONCE:
            return True
        if orphan.reason is Reason.TEMPORARY_IN_USE or self._space.lacking() <= 0:
            return not self._clock.is_paused(self._retire_seconds) and orphan.age() > self._retire_seconds
        is_temporary = orphan.reason is Reason.TEMPORARY
        return not is_temporary or orphan.age() > self._timings.temporary_file_age

    def _next_shard(self) -> str | None:
        """The next shard of the round; None while nothing has happened since the last round began."""
        shard = next(self._shards, None)
        if shard is None and (last := self._store.events.last()) != self._began:
            self._began, self._shards = last, iter(SHARDS)
            shard = next(self._shards)
        return shard

    def _drop_files(self, end: float) -> None:
        """Remove registered files that no sweep retains, in one shard after the other."""
        if self._shard is None:
            self._shard = self._next_shard()
        files: tuple[tuple[str, Stored], ...] = ()
        while not files and self._shard is not None:
            files = self._store.retention.discardable(MOST_REMOVED, self._shard)
            if len(files) < MOST_REMOVED:
                self._shard = self._next_shard()
            if time.monotonic() > end:
                break
        for _, file in self._store.retention.drop(files) if files else ():
            self._artifacts.path(file).unlink(missing_ok=True)

    # --- orphans ---------------------------------------------------------------------------------

    def _orphans(self) -> Iterator[Iterator[Orphan]]:
        """All orphans, in batches that take a moment each."""
        root = self._artifacts.root
        for folders in batches(_folders(root / SWEEPS, ID), FOLDERS_AT_ONCE):
            yield self._of_sweeps(folders)
        for shard in _folders(root / RUNS, SHARD):
            for folders in batches(_folders(shard, ID), FOLDERS_AT_ONCE):
                yield self._of_runs(folders)

    def _of_sweeps(self, folders: Sequence[Path]) -> Iterator[Orphan]:
        """Deleted sweeps, and replaced publications; the youngest one may be under way."""
        deleted = self._store.retention.deleted_sweeps([folder.name for folder in folders])
        for folder in folders:
            if folder.name in deleted:
                yield Orphan(folder, Reason.DELETED)
            elif len(attempts := _attempts(folder)) > 1:
                files = self._store.publications.files(folder.name)
                counting = {self._artifacts.path(file).parent for file in files}
                for attempt in attempts[:-1]:
                    if counting and attempt not in counting:
                        yield Orphan(attempt, Reason.ATTEMPT)

    def _of_runs(self, folders: Sequence[Path]) -> Iterator[Orphan]:
        """Orphans of runs that are neighbours in the order of ids: a few statements for all of them."""
        ids = [folder.name for folder in folders]
        attempts, registered = self._store.retention.last_attempts(ids), self._registered(ids)
        forgotten = self._store.retention.forgotten_runs([id for id in ids if id not in attempts])
        for folder in folders:
            if folder.name in attempts:
                yield from _of_run(folder, attempts[folder.name], registered[folder.name])
            elif folder.name in forgotten:
                yield Orphan(folder, Reason.FORGOTTEN)

    def _registered(self, ids: Sequence[str]) -> Mapping[str, Set[Path]]:
        """Files that rows of these runs point to."""
        by_run: dict[str, set[Path]] = {id: set() for id in ids}
        for id, file in self._store.retention.files_between(ids[0], ids[-1]):
            if id in by_run:
                by_run[id].add(self._artifacts.root / file.path)
        return by_run


def _of_run(folder: Path, last: LastAttempt, registered: Set[Path]) -> Iterator[Orphan]:
    """Orphans of one run: of its last attempt once that has ended, and all other attempts without registered files."""
    last_name = name_of_attempt(last.attempt, last.token) if last.token else ""
    has_ended = last.state in TERMINAL
    for attempt in _attempts(folder):
        if attempt.name != last_name:
            if not any(file.is_relative_to(attempt) for file in registered):
                yield Orphan(attempt, Reason.ATTEMPT)
        elif has_ended:
            for file in attempt.glob(PART):
                yield Orphan(file, Reason.TEMPORARY)
            for file in (attempt / name for name in KEPT_BY):
                if file not in registered and file.exists():
                    yield Orphan(file, Reason.NOT_RETAINED)
    is_under_way = last.state in (State.RUNNING, State.CANCELLING)
    for file in folder.glob(f".{CHECKPOINT}{PART}"):
        yield Orphan(file, Reason.TEMPORARY_IN_USE if is_under_way else Reason.TEMPORARY)
    if has_ended:
        has_result = last.state is State.SUCCEEDED
        for file in folder.glob(f"{CHECKPOINT}*"):
            yield Orphan(file, Reason.OLD_CHECKPOINT if has_result else Reason.CHECKPOINT)


def _attempts(folder: Path) -> list[Path]:
    """The folders of attempts, the youngest last."""
    matches = ((ATTEMPT.fullmatch(entry.name), entry) for entry in folder.glob("a*"))
    return [entry for _, entry in sorted((int(match[1]), entry) for match, entry in matches if match)]


def _folders(parent: Path, name: re.Pattern[str]) -> list[Path]:
    """The entries whose names match, in order."""
    if not parent.is_dir():
        return []
    return sorted(entry for entry in parent.iterdir() if name.fullmatch(entry.name))


def forget_lost_states(store: Store, artifacts: Artifacts, sweep_id: str) -> None:
    """Forget final states of a sweep's runs that are lost or damaged, so that a retry makes them again.

    Reads all of them: about 0.7 s a gigabyte (2026-11).
    """
    for run in store.runs.measured(sweep_id):
        if run.kept is not None and not (artifacts.is_in_bucket(run.kept) or artifacts.is_intact(run.kept)):
            store.retention.forget_files(run.id, [run.kept.name])
