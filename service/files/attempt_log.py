"""The log of an attempt as its supervisor looks at it, while others may write to it."""

import os
from contextlib import suppress
from pathlib import Path

LOG_BYTES = 16 << 20  # of a longer log, the first and the last quarter of it stay
CUT = b"\n... (here the log was too long)\n"


def last_bytes(log: Path, count: int) -> bytes:
    """Its end; nothing if it cannot be read."""
    try:
        with log.open("rb") as opened:
            opened.seek(max(0, log.stat().st_size - count))
            return opened.read(count)
    except OSError:
        return b""


def cut(log: Path) -> None:
    """Take the middle out, if it got too long."""
    quarter = LOG_BYTES // 4
    with suppress(OSError):  # there is none, or the disk is ill
        if log.stat().st_size <= LOG_BYTES:
            return
        last = last_bytes(log, quarter)
        os.truncate(log, quarter)
        with log.open("ab") as end:
            end.write(CUT + last)
