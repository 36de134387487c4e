"""The bucket of a data directory.

Its objects are listed round and round, and those that no row names are removed: of attempts that ended between upload
and commit, of deleted sweeps, and files that no sweep retains. The files on the disk are a cache: beyond its size those
go that were read least recently.
"""

import logging
import time
from collections import Counter
from collections.abc import Iterator, Mapping
from contextlib import suppress
from itertools import groupby

from service.files.artifacts import FOR_PUBLICATIONS, RUNS, SWEEPS, Artifacts
from service.files.disk_space import Space
from service.files.stores import Bucket
from service.queue.clock_watch import ClockWatch
from service.queue.garbage_collection import FOLDERS_AT_ONCE, SHARDS
from service.queue.keepers import Keeper
from service.settings import Settings
from service.store import Store
from service.store.tables import batches
from service.workers.timings import Timings

log = logging.getLogger(__name__)

HOUR = 3600.0  # a file that was used later stays on the disk; some file systems note uses of a day once
FILES_AT_ONCE = 1000  # records that are looked at together
DONE = object()


class BucketKeeper(Keeper):
    """Removes objects that no row names, and limits the cache; without a bucket it has nothing to do."""

    def __init__(self, settings: Settings, store: Store, artifacts: Artifacts, clock: ClockWatch, _timings: Timings):
        self._store, self._clock, self._artifacts = store, clock, artifacts
        self._space = Space(settings.data, settings.disk_reserve)
        self._grace = settings.retire_seconds
        self._cache = settings.artifacts_cache
        self._sweep: Iterator[None] = iter(())  # over the objects
        self._look: Iterator[None] = iter(())  # at the files on the disk
        self._cutoff = 0.0  # seconds since the epoch: files used before it leave the disk

    def step(self) -> None:
        """Look at some of the objects, and at some of the files."""
        if self._artifacts.bucket is None:
            return
        if next(self._sweep, DONE) is DONE:
            self._sweep = self._folders(self._artifacts.bucket)
        if next(self._look, DONE) is DONE:
            self._look = self._pages()

    # --- objects ---------------------------------------------------------------------------------

    def _folders(self, bucket: Bucket) -> Iterator[None]:
        """Remove the objects that no row names, a part of the bucket at a time."""
        for folder in (SWEEPS, *(f"{RUNS}/{shard}" for shard in SHARDS)):
            ours = (name for name in bucket.names(folder) if name.count("/") >= 3)
            of_jobs = ((id, [*names]) for id, names in groupby(ours, lambda name: name.split("/")[-3]))
            for batch in batches(of_jobs, FOLDERS_AT_ONCE):
                self._remove_unnamed(bucket, dict(batch), folder == SWEEPS)
                yield
            yield

    def _remove_unnamed(self, bucket: Bucket, names: dict[str, list[str]], are_sweeps: bool) -> None:
        """Remove the objects of some runs or sweeps that no row names; a job that the store does not know keeps them.

        Attempts under way are asked for before registered files, so that none is missed that ends meanwhile.
        """
        ids, retention = list(names), self._store.retention
        held = {self._artifacts.relative(self._artifacts.attempt_directory(it)) for it in self._store.leases.held()}
        if are_sweeps:
            registered = {file.path for id in ids for file in self._store.publications.files(id)}
            known, gone = {*self._store.sweeps.statuses(ids)}, retention.deleted_sweeps(ids)
        else:
            registered = {file.path for _, file in retention.files_between(ids[0], ids[-1])}
            known, gone = {*retention.last_attempts(ids)}, retention.forgotten_runs(ids)
        for id in (known | gone) & names.keys():
            for name in names[id]:
                is_named = name in registered or name.rpartition("/")[0] in held
                if not is_named and (id not in known or self._is_old(bucket, name)):
                    bucket.remove(name)
                    log.info("removed from the bucket: %s", name)

    def _is_old(self, bucket: Bucket, name: str) -> bool:
        return not self._clock.is_paused(self._grace) and bucket.age(name) > self._grace

    # --- the cache -------------------------------------------------------------------------------

    def _pages(self) -> Iterator[None]:
        """Look at all registered files on the disk, and remove those that the last look found to be too many."""
        after, total = ("", ""), 0
        ages = Counter[int]()  # bytes that may go, by the hour of the last use
        while page := self._store.retention.files(after=after, limit=FILES_AT_ONCE):
            for _, file in page:
                path = self._artifacts.path(file)
                with suppress(FileNotFoundError):
                    status = path.stat()
                    used = max(status.st_atime, status.st_mtime)
                    may_go = file.name not in FOR_PUBLICATIONS
                    if may_go and used < self._cutoff and self._artifacts.is_in_bucket(file):
                        path.unlink()
                        continue
                    total += status.st_size
                    ages[int(used // HOUR)] += status.st_size if may_go else 0
            job, last = page[-1]
            after = job, last.name
            yield
        excess = max(total - self._cache, self._space.lacking())
        self._cutoff = min(_cutoff(ages, excess), time.time() - HOUR)


def _cutoff(ages: Mapping[int, int], excess: int) -> float:
    """The time, in seconds since the epoch, before which the bytes in excess were used for the last time.

    >>> _cutoff({7: 100, 8: 100, 9: 100}, 150) / HOUR, _cutoff({7: 100}, 0)
    (9.0, 0.0)
    """
    cutoff = 0.0
    for hour, size in sorted(ages.items()):
        if excess <= 0:
            break
        cutoff, excess = (hour + 1) * HOUR, excess - size
    return cutoff
