"""Files of runs and sweeps: their paths, their checksums, and complete copies of them.

::

    DIR/whipple.db
    DIR/runs/<two digits>/<run id>/a<attempt>-<token>/   result.json, state.npz, film.npz, sections.npz, log.txt
    DIR/runs/<two digits>/<run id>/checkpoint.npz        of every attempt, while there is no result
    DIR/sweeps/<sweep id>/a<attempt>-<token>/            cube.nc, runs.csv, runs-all.csv, report.html,
                                                         appendix.html, report.json, log.txt

Each attempt writes into a folder of its own, so nothing is ever published in place: the row says which folder counts.
Paths in rows are relative to DIR and made of ids that the service gave, never of text from users.

With a bucket (``service.files.stores``) DIR is where attempts work, and for the rest a cache of it.
"""

import hashlib
import os
import re
import shutil
from collections.abc import Iterable, Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import suppress
from functools import lru_cache
from pathlib import Path
from typing import TYPE_CHECKING, Self

from service.files.stores import Bucket, bucket_at
from service.records.jobs import Kind, Lease, Stored
from studies.quantities.files import FILM, RESULT, SECTIONS, STATE, to_disk, write_atomically

if TYPE_CHECKING:
    from service.settings import Settings

RUNS, SWEEPS = "runs", "sweeps"
LOG = "log.txt"
OF_A_RUN = (RESULT, STATE, FILM, SECTIONS, LOG)  # the result is written last but for the log
FOR_PUBLICATIONS = frozenset({RESULT, SECTIONS})  # what the publication of a sweep reads of each run
CHECKPOINT = "checkpoint"
PART = "*.part"  # a temporary file, of a running process or a killed one
ID = re.compile("[0-9a-f]{32}")
# Name of an attempt.
KEY = re.compile(rf"(?P<id>{ID.pattern})-(?P<attempt>\d+)-(?P<token>[0-9a-f]+)")
_CHUNK = 1 << 20  # bytes read at once for a digest


class Artifacts:
    """The files below one data directory, and in its bucket if it has one."""

    def __init__(self, root: Path, bucket: Bucket | None = None):
        self.root = root.absolute()
        self.bucket = bucket

    @classmethod
    def of(cls, settings: "Settings") -> Self:
        """Those of a service; raises InvalidInput for a bucket that cannot be opened."""
        return cls(settings.data, None if settings.artifacts is None else bucket_at(settings.artifacts))

    def attempt_directory(self, lease: Lease) -> Path:
        attempt = name_of_attempt(lease.attempt, lease.token)
        if lease.kind is Kind.RUN:
            return self.run_folder(lease.id) / attempt
        assert lease.sweep_id is not None
        return self.sweep_folder(lease.sweep_id) / attempt

    def has_attempt(self, key: str) -> bool:
        """Whether the attempt with this key is of this directory: a scheduler may serve other services too."""
        match = KEY.fullmatch(key)
        if match is None:
            return False
        name = name_of_attempt(int(match["attempt"]), match["token"])
        is_run = (self.run_folder(match["id"]) / name).is_dir()
        return is_run or any(self.root.glob(f"{SWEEPS}/*/{name}"))

    def make_folder(self, folder: Path) -> None:
        """Make a folder and those above it, except the data directory: where that is missing, its disk is away."""
        for place in reversed((folder, *folder.parents)):
            if place.is_relative_to(self.root) and place != self.root:
                place.mkdir(exist_ok=True)

    def run_folder(self, id: str) -> Path:
        return self.root / RUNS / _checked(id)[:2] / id

    def sweep_folder(self, id: str) -> Path:
        return self.root / SWEEPS / _checked(id)

    def log_of(self, run_id: str, attempt: int, token: str) -> Path:
        return self.run_folder(run_id) / name_of_attempt(attempt, token) / LOG

    def checkpoint(self, run_id: str) -> Path:
        """The checkpoint that the attempts of a run share."""
        return self.run_folder(run_id) / f"{CHECKPOINT}.npz"

    def discard_checkpoint(self, run_id: str) -> None:
        """Remove the checkpoints of a run, and their temporary files."""
        folder = self.run_folder(run_id)
        for pattern in (f"{CHECKPOINT}*", f".{CHECKPOINT}*"):
            for file in folder.glob(pattern):
                file.unlink(missing_ok=True)

    def complete_files(self, lease: Lease) -> tuple[Stored, ...]:
        """The files of an attempt of a run, if there is a result; else none."""
        directory = self.attempt_directory(lease)
        if not (directory / RESULT).is_file():
            return ()
        files = (directory / name for name in OF_A_RUN)
        return tuple(describe(file) for file in files if file.is_file())

    def relative(self, file: Path) -> str:
        """Path of a file relative to the data directory, as in rows."""
        return file.relative_to(self.root).as_posix()

    def path(self, stored: Stored) -> Path:
        """Path of a registered file; raises ValueError outside the data directory."""
        path = (self.root / stored.path).resolve()
        if not path.is_relative_to(self.root.resolve()):
            raise ValueError(f"{stored.path!r} leaves the data directory")
        return path

    def is_there(self, stored: Stored) -> bool:
        """Whether the file is there with the registered size."""
        path = self.path(stored)
        return path.is_file() and path.stat().st_size == stored.size

    def is_intact(self, stored: Stored) -> bool:
        """Whether the file is there with the registered size and digest."""
        return self.is_there(stored) and digest(self.path(stored)) == stored.sha256

    def may_be_shown(self, stored: Stored) -> bool:
        """Whether the file is there with the registered digest, by the last reading of it: see ``known_digest``."""
        is_known = self.is_there(stored) and known_digest(self.path(stored)) == stored.sha256
        return is_known or self.bring_back(stored)

    # --- the bucket ------------------------------------------------------------------------------

    def keep(self, files: Iterable[Stored]) -> None:
        """Write files to the bucket, before rows name them; raises FilesAway."""
        if self.bucket is not None:
            for stored in files:
                self.bucket.put(self.path(stored), stored.path)

    def is_in_bucket(self, stored: Stored) -> bool:
        """Whether the bucket has the file with the registered size; raises FilesAway."""
        return self.bucket is not None and self.bucket.size(stored.path) == stored.size

    def local(self, stored: Stored) -> Path:
        """Path of a registered file, brought back from the bucket if the disk lacks it, whole; raises FilesAway."""
        if self.bucket is not None:
            self.may_be_shown(stored)
        return self.path(stored)

    def bring_back(self, stored: Stored) -> bool:
        """Whether the bucket had the file, which is then on the disk, whole; raises FilesAway."""
        path, bucket = self.path(stored), self.bucket
        if bucket is None:
            return False

        def fill(part: Path) -> None:
            bucket.get(stored.path, part)
            if digest(part) != stored.sha256:
                raise FileNotFoundError(f"the object {stored.path} is damaged")

        try:
            self.make_folder(path.parent)
            write_atomically(path, fill)
        except FileNotFoundError:
            return False
        return True

    def mend(self, stored: Stored) -> bool:
        """Whether disk or bucket have the file, whole; the other then has it too. Raises FilesAway."""
        with suppress(FileNotFoundError):
            if self.is_intact(stored):
                self.keep([stored])
                return True
        return self.bring_back(stored)

    def bring_to_disk(self, folder: Path) -> None:
        """Make ``folder``, its files and the names of the folders above it survive a power cut."""
        files = [file for file in folder.iterdir() if file.is_file()]
        folders = [place for place in (folder, *folder.parents) if place.is_relative_to(self.root)]
        # Side by side the disk is waited for once: 1 ms instead of 23 for the eight of a small run (2026-11).
        with ThreadPoolExecutor(len(files) + len(folders)) as threads:
            list(threads.map(to_disk, files + folders))

    def copy_out(self, stored: Stored, folder: Path, name: str = "") -> Path:
        """Copy a file into ``folder``, whole or not at all, under its own name by default.

        A copy, not a link: edits of it leave the registered file as it is.
        """
        source = self.path(stored)
        return write_atomically(folder / (name or stored.name), lambda part: shutil.copyfile(source, part))


def describe(file: Path) -> Stored:
    """The record of a complete file, with its absolute path."""
    return Stored(file.name, str(file), file.stat().st_size, digest(file))


def name_of_attempt(attempt: int, token: str) -> str:
    return f"a{attempt}-{token}"


def digest(path: Path) -> str:
    """SHA-256 of a file, in hex."""
    with path.open("rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()


def chunks(path: Path, *, from_disk: bool = False) -> Iterator[bytes]:
    """The bytes of a file in pieces; ``from_disk``: not those that the system has in memory."""
    with path.open("rb") as file:
        if from_disk:
            os.posix_fadvise(file.fileno(), 0, 0, os.POSIX_FADV_DONTNEED)
        while chunk := file.read(_CHUNK):
            yield chunk


def known_digest(path: Path) -> str:
    """The SHA-256 of a file, which is read anew only when its size or a time of it changes."""
    status = path.stat()
    version = status.st_dev, status.st_ino, status.st_size, status.st_mtime_ns, status.st_ctime_ns
    return _digest_of_version(path, version)


@lru_cache(maxsize=4096)
def _digest_of_version(path: Path, _version: tuple[int, ...]) -> str:
    """The SHA-256 of a version of a file: 0.8 s for each GB (2026-11), once."""
    return digest(path)


def _checked(id: str) -> str:
    """An id that is safe as the name of a folder."""
    if not ID.fullmatch(id):
        raise ValueError(f"{id!r} is not an id of this service")
    return id
