"""``whipple serve`` of which something is altered, for everything in its process::

    python -m tests.service.support.altered_serve brief serve ...
    python -m tests.service.support.altered_serve FILE serve ...

``brief`` waits for less time: for a lock of the database, a request, and after a full disk. The seconds that a FILE
holds are added to the time of day.
"""

import sys
import time
from datetime import datetime, tzinfo
from pathlib import Path
from typing import Self

from service.api import middleware
from service.cli import main as cli
from service.files import disk_space
from service.store import connection, tables

BRIEF = ("-m", __name__, "brief")
BUSY_MILLISECONDS = 2000
PAUSE_SECONDS = 5.0
HEAD_SECONDS = 4.0
BODY_SECONDS = 2.0


class SettableClock(datetime):
    """The time of day, as somebody has set it."""

    @classmethod
    def now(cls, tz: tzinfo | None = None) -> Self:
        return cls.fromtimestamp(time.time(), tz)


def wait_briefly() -> None:
    """Shorten the times."""
    connection.BUSY_MILLISECONDS = BUSY_MILLISECONDS
    disk_space.PAUSE_SECONDS = PAUSE_SECONDS
    middleware.HEAD_SECONDS = HEAD_SECONDS
    middleware.BODY_SECONDS = BODY_SECONDS


def follow_clock(file: Path) -> None:
    """Set the clock by a file, again and again."""
    right = time.time
    time.time = lambda: right() + float(file.read_text())
    tables.datetime = SettableClock  # type: ignore[misc]


if __name__ == "__main__":
    altered = sys.argv.pop(1)
    wait_briefly() if altered == "brief" else follow_clock(Path(altered))
    cli.main()
