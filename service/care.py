"""The care of the data directory: what no sweep keeps and what does not count goes, bit by bit.

Never what a row points to: a row forgets its file before the file goes. What was left behind by an
attempt stays for ``retire_seconds``, so that somebody may look at its log, unless the disk is full.
"""

import logging
import shutil
from collections.abc import Iterator
from itertools import islice

from service.artifacts import Artifacts
from service.leftovers import Leftover, Leftovers, Why
from service.settings import Settings
from service.space import Space
from service.store import Store

log = logging.getLogger(__name__)

LOOKED = 200  # folders of sweeps that a step looks at
SHARDS = 16  # of 256, that a step looks at
REMOVED = 50  # files or folders that a step removes
AT_ONCE = frozenset({Why.DELETED, Why.SPENT})


class Care:
    """Goes round the data directory in small steps."""

    def __init__(self, settings: Settings, store: Store, artifacts: Artifacts, space: Space):
        self._store = store
        self._artifacts = artifacts
        self._space = space
        self._retire_seconds = settings.retire_seconds
        self._leftovers = Leftovers(store, artifacts)
        self._round = self._go_round()
        self._may_drop = True

    def step(self) -> None:
        """A bounded part of the work; called by whoever leads, between two claims."""
        if self._may_drop:
            self._may_drop = self._drop() == REMOVED
        looked_at = next(self._round, None)
        if looked_at is None:  # once round
            self._round, self._may_drop = self._go_round(), True
            looked_at = next(self._round, iter(()))
        due = (one for one in looked_at if self._is_due(one))
        for leftover in islice(due, REMOVED):
            log.info("removed: %s (%s)", leftover.path, leftover.why)
            _remove(leftover)

    def _drop(self) -> int:
        """Remove registered files that no sweep keeps any more; how many these were."""
        files = self._store.discardable(REMOVED)
        for id, file in files:
            self._store.forget_files(id, [file.name])
            self._artifacts.path(file).unlink(missing_ok=True)
        return len(files)

    def _go_round(self) -> Iterator[Iterator[Leftover]]:
        """Leftovers of the whole directory, a step at a time."""
        sweeps = self._leftovers.sweep_ids()
        for begin in range(0, len(sweeps), LOOKED):
            yield self._leftovers.of_sweeps(sweeps[begin : begin + LOOKED])
        shards = self._leftovers.shards()
        for begin in range(0, len(shards), SHARDS):
            some = shards[begin : begin + SHARDS]
            yield (one for shard in some for one in self._leftovers.of_shard(shard))

    def _is_due(self, leftover: Leftover) -> bool:
        """Whether it may go now."""
        if leftover.why is Why.STRANGER:
            return False
        if leftover.why in AT_ONCE or self._space.is_short():
            return True
        return leftover.age() > self._retire_seconds


def _remove(leftover: Leftover) -> None:
    if leftover.path.is_dir():
        shutil.rmtree(leftover.path, ignore_errors=True)
    else:
        leftover.path.unlink(missing_ok=True)
