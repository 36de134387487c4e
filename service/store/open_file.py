"""The file of an SQLite database as this process has it open, compared with the file that has its name now.

A file that is removed or replaced stays open: what is written to it then is lost when the process ends. So every
transaction looks at the names before it begins, and a writer once more after its commit.
"""

import os
import threading
from contextlib import suppress
from pathlib import Path

from service.records.jobs import StoreUnavailable

LOG = "-wal"  # added to the name of the database: the write-ahead log, which has what was committed last
CURE = "put it back, or stop the service and start it again with the database that is to be used"

FileId = tuple[int, int]  # device and inode


class DatabaseFileLost(StoreUnavailable):
    """The file of the database that is open was removed, or replaced by another."""

    def __init__(self, what: str):
        super().__init__(f"{what}; {CURE}")
        self.what = what


class OpenFile:
    """The file of a database and its write-ahead log, as the connections of an engine have them open."""

    def __init__(self, database: Path):
        self._database = database
        self._mutex = threading.Lock()
        self._connections = 0
        self._ids: dict[str, FileId] = {}  # by the end of the name

    def add_connection(self) -> None:
        """Note a connection that was opened just now; raises DatabaseFileLost if it is to another file."""
        with self._mutex:
            self._compare()  # of the first one: SQLite may put another log in place of one that was left
            self._connections += 1

    def remove_connection(self) -> None:
        """Note a connection that is closed: SQLite removes the write-ahead log with the last one."""
        with self._mutex:
            self._connections -= 1
            if not self._connections:
                self._ids.pop(LOG, None)

    def check(self) -> None:
        """Raise DatabaseFileLost unless the files of these names are those that are open."""
        with self._mutex:
            if self._ids:
                self._compare()

    def _compare(self) -> None:
        for end in ("", LOG) if self._connections else ("",):
            here, opened = _id_of(Path(f"{self._database}{end}")), self._ids.get(end)
            if opened is None and here is not None:
                self._ids[end] = here
            elif here != opened:
                name = f"{self._database.name}{end}"
                how = "was removed" if here is None else "was replaced by another file"
                raise DatabaseFileLost(f"{name}, which the service has open, {how}")


def _id_of(path: Path) -> FileId | None:
    """The device and the inode of a file; None where it is missing, or cannot be looked at."""
    with suppress(OSError):
        status = os.stat(path)
        return status.st_dev, status.st_ino
    return None
