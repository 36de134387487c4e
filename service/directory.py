"""The data directory, and who works in it."""

import fcntl
import os
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from service.settings import Settings
from solver.errors import WhippleError

LOCK = "whipple.lock"


class DataInUse(WhippleError):
    """Another service, or sweep, works in this data directory."""


@contextmanager
def holding(settings: Settings) -> Iterator[Path]:
    """The data directory, ours until the end of the block; to be taken before its database is opened.

    Raises DataInUse. Services that share a PostgreSQL database share the directory too: they agree
    by way of the database who of them leads.
    """
    settings.data.mkdir(parents=True, exist_ok=True)
    if settings.has_replicas:
        yield settings.data
        return
    with _locked(settings.data):
        yield settings.data


@contextmanager
def _locked(directory: Path) -> Iterator[None]:
    """Hold a lock file; the kernel gives it back when the process ends, however it ends."""
    with (directory / LOCK).open("a+", encoding="utf-8") as file:
        try:
            fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except OSError:
            file.seek(0)
            owner = file.read().strip() or "unknown"
            cure = "stop it, or choose another directory"
            raise DataInUse(f"{directory} is used by process {owner}; {cure}") from None
        file.truncate(0)
        file.write(str(os.getpid()))
        file.flush()
        yield
