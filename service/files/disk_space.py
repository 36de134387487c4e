"""Disk space: below a reserve nothing is begun, so that attempts under way can end."""

import errno
import os
import shutil
import time
from pathlib import Path

# After a run met a full disk: its own files are gone, so that there seems to be space.
PAUSE_SECONDS = 60.0
LITTLE = 16 << 20  # bytes; with less of them free a disk is full, whatever the reserve
MESSAGES = tuple(os.strerror(number) for number in (errno.ENOSPC, errno.EDQUOT))


class Space:
    """The free space of the data directory."""

    def __init__(self, folder: Path, reserve: int):
        self._folder = folder
        self._reserve = reserve
        self._full = -PAUSE_SECONDS  # monotonic

    def lacking(self) -> int:
        """Bytes that are missing to the reserve; negative where more is free."""
        return self._reserve - free_bytes(self._folder)

    def is_used_up(self, free: int | None = None) -> bool:
        """Whether ``free`` bytes (None: those free now) are less than the reserve, or next to nothing."""
        if free is None:
            free = free_bytes(self._folder)
        return free < max(self._reserve, LITTLE)

    def blocked_reason(self) -> str | None:
        """The reason, as a text, why no run may start; None: there is enough space."""
        free = free_bytes(self._folder)
        if free < self._reserve:
            return f"only {shown_size(free)} of disk are free, the reserve is {shown_size(self._reserve)}"
        if time.monotonic() - self._full < PAUSE_SECONDS:
            return f"a run met a full disk less than {PAUSE_SECONDS:.0f} s ago"
        return None

    def note_full_disk(self) -> None:
        """Note that a run met a full disk: nothing is begun for a while."""
        self._full = time.monotonic()


def names_full_disk(reason: str) -> bool:
    """Whether the message of an error says that a disk was full."""
    return any(message in reason for message in MESSAGES)


def free_bytes(folder: Path) -> int:
    """Bytes that this process may use on the disk of a folder."""
    return shutil.disk_usage(folder).free


def shown_size(size: float) -> str:
    """A size for people.

    >>> shown_size(3 * 2**30), shown_size(700_000)
    ('3.0 GiB', '0.7 MiB')
    """
    return f"{size / 2**30:.1f} GiB" if size >= 2**30 else f"{size / 2**20:.1f} MiB"
