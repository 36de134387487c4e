"""Scrubbing: all registered files are read round and round, slowly, and compared with their digests.

A disk may change a bit of a file that nobody reads for years. What is damaged, or missing, is made again like a lost
result, within the limits for all of them; beyond these it waits. The store remembers how far a pass is.
"""

import hashlib
import logging
import os
import time
from collections.abc import Generator, Iterator
from contextlib import suppress
from dataclasses import replace

from service.files.artifacts import Artifacts, chunks
from service.files.stores import FilesAway
from service.queue import data_identity as identity
from service.queue.clock_watch import ClockWatch
from service.queue.keepers import Keeper
from service.queue.retry import make_again
from service.records.jobs import Scrub, Stored
from service.settings import Settings
from service.store import Store
from service.workers.timings import Timings

log = logging.getLogger(__name__)

FILES_AT_ONCE = 100  # records that are read together
BYTES_TO_OPEN = 4096  # that opening a file counts for


class Scrubber(Keeper):
    """Goes round the registered files."""

    def __init__(self, settings: Settings, store: Store, artifacts: Artifacts, _clock: ClockWatch, timings: Timings):
        self._settings = settings
        self._store = store
        self._artifacts = artifacts
        self._timings = timings
        self._due = 0.0  # bytes; negative after a piece that was larger than due
        self._last = self._noted = time.monotonic()  # of the last step, and of the last note
        self._sizes = self._pass()
        self._waiting: list[Stored] = []  # damaged files beyond the limits

    def step(self) -> None:
        """Read what is due since the last step; called by the leader at some of its ticks."""
        now = time.monotonic()
        self._due = min(self._due, 0.0) + self._settings.scrub_rate * (now - self._last)
        self._last = now
        while self._due > 0 and time.monotonic() - now < self._timings.scrub_step:
            size = next(self._sizes, None)
            if size is None:  # once round, or interrupted by an error
                self._sizes = self._pass()
                break
            self._due -= size
        if self._waiting and make_again(self._store, self._waiting[0]) is not None:
            del self._waiting[0]

    def _pass(self) -> Iterator[int]:
        """Read each file once, from where the last pass ended if it was interrupted; yields sizes of pieces."""
        scrub = self._store.retention.scrub()
        if not scrub.name:
            if time.time() - scrub.began < self._timings.scrub_interval:
                return
            scrub = replace(scrub, began=time.time())
        while page := self._store.retention.files(after=(scrub.job_id, scrub.name), limit=FILES_AT_ONCE):
            for job_id, file in page:
                is_damaged = not (yield from self._is_whole(file)) and self._is_damaged(file)
                damaged = scrub.damaged + is_damaged
                scrub = replace(scrub, job_id=job_id, name=file.name, files=scrub.files + 1, damaged=damaged)
                if is_damaged or time.monotonic() - self._noted > self._timings.scrub_note:
                    self._store.retention.note_scrub(scrub)
                    self._noted = time.monotonic()
        self._store.retention.note_scrub(Scrub(scrub.began, whole=(time.time(), scrub.files, scrub.damaged)))

    def _is_whole(self, file: Stored) -> Generator[int, None, bool]:
        """Whether each copy of a file has its digest; yields sizes of pieces.

        With a bucket one is there, and another on the disk unless the disk lacks the file. Raises FilesAway.
        """
        path, bucket = self._artifacts.path(file), self._artifacts.bucket
        copies = [] if bucket is None else [bucket.chunks(file.path)]
        if bucket is None or path.exists():
            copies.append(chunks(path, from_disk=True))
        digests = set()
        for copy in copies:
            digests.add((yield from _digest(copy)))
        return digests == {file.sha256}

    def _is_damaged(self, file: Stored) -> bool:
        """Whether a file that counts is damaged at a second look too; then it is made again.

        Where only the copy on the disk or that in the bucket is, the other one replaces it.
        """
        bucket = self._artifacts.bucket
        if bucket is None:
            with suppress(OSError):
                if self._artifacts.is_intact(file):
                    return False
        identity.check(self._settings, self._store)  # the whole disk may be away
        if bucket is not None:
            is_new = bucket.size(file.path) is None  # as where files were there before the bucket
            if self._artifacts.mend(file):
                log.warning("%s was damaged or missing; its copy on the disk or in the bucket replaces it", file.path)
                return not is_new
        with suppress(OSError):
            os.utime(self._artifacts.path(file))  # no digest that a service remembers is of this file
        registered = make_again(self._store, file)
        if registered is None and file not in self._waiting:
            self._waiting.append(file)
        if registered is not False:
            log.error("%s is lost or damaged; it is made again%s", file.path, "" if registered else " later")
        return registered is not False


def _digest(pieces: Iterator[bytes]) -> Generator[int, None, str]:
    """The SHA-256 of a copy of a file, empty where it cannot be read; yields sizes of pieces."""
    sha256 = hashlib.sha256()
    yield BYTES_TO_OPEN
    try:
        for piece in pieces:
            sha256.update(piece)
            yield len(piece)
    except FilesAway:
        raise
    except OSError:
        return ""
    return sha256.hexdigest()
