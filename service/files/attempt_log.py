"""The log of an attempt, which its process may write to meanwhile."""

import os
from contextlib import suppress
from pathlib import Path

LOG_BYTES = 16 << 20  # limit; of a longer log the first and the last quarter of it stay
CUT = b"\n... (here the log was too long)\n"


def last_bytes(log: Path, count: int) -> bytes:
    """The end of a log; empty if it cannot be read."""
    try:
        with log.open("rb") as opened:
            opened.seek(max(0, log.stat().st_size - count))
            return opened.read(count)
    except OSError:
        return b""


def cut(log: Path) -> None:
    """Cut the middle out of a log that is too long."""
    quarter = LOG_BYTES // 4
    with suppress(OSError):  # no log, or a disk error
        if log.stat().st_size <= LOG_BYTES:
            return
        last = last_bytes(log, quarter)
        os.truncate(log, quarter)
        with log.open("ab") as end:
            end.write(CUT + last)
