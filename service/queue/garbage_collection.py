"""The care of the data directory: what no sweep keeps and what does not count goes, bit by bit.

Never what a row points to: a row forgets its file before the file goes. What was left behind by an
attempt stays for ``retire_seconds``, so that somebody may look at its log, unless the disk is full.
What needs no row to be written comes first: on a full disk none can be.
"""

import logging
import shutil
import time
from collections.abc import Iterator
from datetime import UTC, datetime, timedelta
from itertools import cycle, islice

from service.files.artifacts import Artifacts
from service.files.disk_space import Space
from service.queue.orphans import Leftover, Leftovers, Why
from service.records.jobs import Stored
from service.records.settings import Settings
from service.store import Store

log = logging.getLogger(__name__)

STEP_SECONDS = 0.04  # after which a step looks no further; whoever leads waits for it
DROP_SECONDS = 0.01  # besides, for what no sweep keeps
DRAFT_SECONDS = 600.0  # for which what is half-written stays: somebody may be at it, row or not
SHARDS = [f"{number:02x}" for number in range(256)]
REMOVED = 50  # files or folders that a step removes
AT_ONCE = frozenset({Why.DELETED, Why.FORGOTTEN, Why.SPENT})


class GarbageCollector:
    """Goes round the data directory in small steps."""

    def __init__(self, settings: Settings, store: Store, artifacts: Artifacts, space: Space):
        self._store = store
        self._artifacts = artifacts
        self._space = space
        self._retire_seconds = settings.retire_seconds
        self._forget_seconds = settings.forget_seconds
        self._leftovers = Leftovers(store, artifacts)
        self._round = self._leftovers.parts()
        self._may_forget = True
        self._shards = cycle(SHARDS)
        self._shard = next(self._shards)

    def step(self) -> None:
        """A bounded part of the work; called by whoever leads, between two claims."""
        self._go_on(time.monotonic() + STEP_SECONDS)
        self._drop(time.monotonic() + DROP_SECONDS)
        if self._may_forget:
            self._may_forget = self._forget() == REMOVED

    def _go_on(self, end: float) -> None:
        """Remove what is left over, from where the last step ended."""
        removed = 0
        while True:
            part = next(self._round, None)
            if part is None:  # once round
                self._round, self._may_forget = self._leftovers.parts(), True
                return
            removed += self._remove_of(part, REMOVED - removed)
            if removed == REMOVED or time.monotonic() > end:
                return

    def _remove_of(self, part: Iterator[Leftover], most: int) -> int:
        """Remove what is due of it; how many these were."""
        due = [*islice((one for one in part if self._is_due(one)), most)]
        for leftover in due:
            log.info("removed: %s (%s)", leftover.path, leftover.why)
            _remove(leftover)
        return len(due)

    def _drop(self, end: float) -> None:
        """Remove registered files that no sweep keeps any more, in one shard after the other."""
        files: tuple[tuple[str, Stored], ...] = ()
        while not files:
            files = self._store.discardable(REMOVED, self._shard)
            if len(files) < REMOVED:
                self._shard = next(self._shards)
            if time.monotonic() > end:
                break
        for _, file in self._store.drop(files) if files else ():
            self._artifacts.path(file).unlink(missing_ok=True)

    def _forget(self) -> int:
        """Forget runs that no sweep has had for long; how many these were. Their files go later."""
        before = datetime.now(UTC) - timedelta(seconds=self._forget_seconds)
        return self._store.forget_runs(before, REMOVED)

    def _is_due(self, leftover: Leftover) -> bool:
        """Whether it may go now."""
        if leftover.why in AT_ONCE:
            return True
        if leftover.why is Why.DRAFT or not self._space.is_short():
            return leftover.age() > self._retire_seconds
        return leftover.why is not Why.PART or leftover.age() > DRAFT_SECONDS


def _remove(leftover: Leftover) -> None:
    if leftover.path.is_dir():
        shutil.rmtree(leftover.path, ignore_errors=True)
    else:
        leftover.path.unlink(missing_ok=True)


def forget_lost_states(store: Store, artifacts: Artifacts, sweep_id: str) -> None:
    """Forget final states of a sweep's runs that are lost or damaged, so that a retry makes them again.

    Reads all of them: about 0.7 s a gigabyte (2026-11).
    """
    for run in store.measured_runs(sweep_id):
        if run.kept is not None and not artifacts.is_intact(run.kept):
            store.forget_files(run.id, [run.kept.name])
