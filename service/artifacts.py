"""Where a file of a run or a sweep lives, its checksum, and how it is copied out whole.

::

    DIR/whipple.db
    DIR/runs/<two digits>/<run id>/a<attempt>-<token>/   result.json, state.npz, log.txt
    DIR/sweeps/<sweep id>/a<attempt>-<token>/            cube.nc, report.html, report.json, log.txt

Each attempt writes into a folder of its own, so nothing is ever published in place: the row says
which folder counts. Paths in rows are relative to DIR and made of ids that the service gave, never
of words that a user wrote.
"""

import hashlib
import json
import os
import re
import shutil
from collections.abc import Iterable
from pathlib import Path
from typing import Any

from service.jobs import Claim, Kind, Stored
from studies.atomic import write_atomically

RUNS, SWEEPS = "runs", "sweeps"
LOG = "log.txt"
_ID = re.compile("[0-9a-f]{32}")
_CHUNK = 1 << 20  # bytes read at once for a digest


class Artifacts:
    """The files below one data directory."""

    def __init__(self, root: Path):
        self.root = root.absolute()

    def attempt_directory(self, claim: Claim) -> Path:
        """The folder that one attempt of a job writes into."""
        attempt = f"a{claim.attempt}-{claim.token}"
        if claim.kind is Kind.RUN:
            return self.root / RUNS / _checked(claim.id)[:2] / claim.id / attempt
        assert claim.sweep_id is not None
        return self.root / SWEEPS / _checked(claim.sweep_id) / attempt

    def relative(self, file: Path) -> str:
        """A file's path as rows have it."""
        return file.relative_to(self.root).as_posix()

    def path(self, stored: Stored) -> Path:
        """Where a registered file is."""
        path = (self.root / stored.path).resolve()
        if not path.is_relative_to(self.root.resolve()):
            raise ValueError(f"{stored.path!r} leaves the data directory")
        return path

    def is_intact(self, stored: Stored) -> bool:
        """Whether the file is there with the registered size and digest."""
        path = self.path(stored)
        if not path.is_file() or path.stat().st_size != stored.size:
            return False
        return digest(path) == stored.sha256

    def bring_to_disk(self, folder: Path) -> None:
        """Make the names of ``folder`` and of the folders above it survive a power cut.

        Files are brought to the disk by whoever writes them; a row must not outlive their names.
        """
        for place in (folder, *folder.parents):
            if not place.is_relative_to(self.root):
                return
            descriptor = os.open(place, os.O_RDONLY)
            try:
                os.fsync(descriptor)
            finally:
                os.close(descriptor)

    def read_json(self, stored: Stored) -> Any:
        """What a registered JSON file says."""
        return json.loads(self.path(stored).read_bytes())

    def copy_out(self, stored: Stored, folder: Path) -> Path:
        """Copy a file into ``folder``, whole or not at all.

        A copy, not a link: whoever edits it there must not change what is registered here.
        """
        source = self.path(stored)
        return write_atomically(folder / stored.name, lambda part: shutil.copyfile(source, part))

    def sweep_ids(self) -> list[str]:
        """Sweeps that have files."""
        folder = self.root / SWEEPS
        names = [entry.name for entry in folder.iterdir()] if folder.is_dir() else []
        return [name for name in names if _ID.fullmatch(name)]

    def discard_sweeps(self, ids: Iterable[str]) -> None:
        """Delete the files of sweeps that are no longer in the store."""
        for id in ids:
            shutil.rmtree(self.root / SWEEPS / _checked(id), ignore_errors=True)


def describe(file: Path) -> Stored:
    """A complete file: name, place, size and digest."""
    return Stored(file.name, str(file), file.stat().st_size, digest(file))


def digest(path: Path) -> str:
    """SHA-256 of a file, in hex."""
    sha256 = hashlib.sha256()
    with path.open("rb") as file:
        while chunk := file.read(_CHUNK):
            sha256.update(chunk)
    return sha256.hexdigest()


def _checked(id: str) -> str:
    """An id that is safe as the name of a folder."""
    if not _ID.fullmatch(id):
        raise ValueError(f"{id!r} is not an id of this service")
    return id
