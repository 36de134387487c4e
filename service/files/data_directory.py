"""The data directory, and the lock of the one service that works in it."""

import fcntl
import os
import stat
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager, suppress
from pathlib import Path

from service.settings import Settings
from solver.errors import WhippleError
from studies.quantities.findings import Finding, InvalidInput

LOCK = "whipple.lock"  # named as the database is


class DataInUse(WhippleError):
    """Another service or sweep works in this data directory, or on its database."""


@contextmanager
def holding(settings: Settings) -> Iterator[Path]:
    """Lock the data directory until the end of the block; to be done before its database is opened.

    Raises DataInUse. Services that share a PostgreSQL database share the directory too: the
    database gives one of them the right to lead.
    """
    locks: set[Path] = set()
    if not settings.has_replicas:
        # Of the directory and of the database, which may be elsewhere: beside the file itself, not a link to it.
        locks = {(settings.data / LOCK).resolve(), _database_of(settings).with_suffix(".lock").resolve()}
    with ExitStack() as held:
        for lock in sorted(locks):
            held.enter_context(_locked(lock))
        _make_private(settings)
        yield settings.data


def _make_private(settings: Settings) -> None:
    """Take the data directory from other users; from its group too, unless workers or replicas may share it by that."""
    is_shared = settings.has_replicas or settings.engine is not None
    with suppress(OSError):  # not there yet, or another user's
        mode = stat.S_IMODE(settings.data.stat().st_mode)
        settings.data.chmod(mode & (0o770 if is_shared else 0o700))


def check_names(settings: Settings) -> None:
    """Raise InvalidInput for an SQLite database with hard links; to be called before it is opened.

    A service with another of its names would have another lock, and SQLite another log, which damages
    the file. (The file itself cannot be locked: closing it releases the locks that SQLite has on it.)
    """
    if settings.has_replicas:
        return
    database = _database_of(settings)
    names = database.stat().st_nlink if database.exists() else 1
    if names > 1:
        shown = f"{database}, with {names} names"
        cure = "remove the other links, or give each service a separate copy"
        raise InvalidInput([Finding("database", shown, "a file without hard links", cure)])


def _database_of(settings: Settings) -> Path:
    """The file of an SQLite database, not a symbolic link to it."""
    return Path(settings.url.partition(":///")[2]).resolve()


@contextmanager
def _locked(lock: Path) -> Iterator[None]:
    """Hold a lock file; the kernel releases it when the process ends, however it ends."""
    lock.parent.mkdir(parents=True, exist_ok=True)
    with lock.open("a+", encoding="utf-8") as file:
        try:
            fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except OSError:
            file.seek(0)
            owner = file.read().strip() or "unknown"
            cure = "stop it, or choose another directory, for data and database"
            raise DataInUse(f"{lock.parent} is used by process {owner}; {cure}") from None
        file.truncate(0)
        file.write(str(os.getpid()))
        file.flush()
        yield
