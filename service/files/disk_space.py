"""Room on the disk: below a reserve nothing is begun, so that what is under way can end."""

import errno
import os
import shutil
import time
from pathlib import Path

from service.records.attempt import Ending
from service.records.jobs import Cause

REST_SECONDS = (
    60.0  # after a run met a full disk: its own files are gone, so there seems to be room
)
LITTLE = 16 << 20  # bytes; with less of them free a disk is full, reserve or not
WORDS = tuple(os.strerror(number) for number in (errno.ENOSPC, errno.EDQUOT))


class Space:
    """The free space of the data directory."""

    def __init__(self, folder: Path, reserve: int):
        self._folder = folder
        self._reserve = reserve
        self._rested = -REST_SECONDS  # monotonic

    def is_short(self) -> bool:
        """Whether the reserve is being used up."""
        return free_bytes(self._folder) < self._reserve

    def is_used_up(self, free: int | None = None) -> bool:
        """Whether the reserve is, or there is next to nothing, with so many bytes free; None: with those now."""
        have = free_bytes(self._folder) if free is None else free
        return have < max(self._reserve, LITTLE)

    def shortage(self) -> str | None:
        """Why nothing should be begun, for people; None: there is room."""
        free = free_bytes(self._folder)
        if free < self._reserve:
            have, want = in_words(free), in_words(self._reserve)
            return f"only {have} of disk are free, the reserve is {want}"
        if time.monotonic() - self._rested < REST_SECONDS:
            return f"a run met a full disk less than {REST_SECONDS:.0f} s ago"
        return None

    def rest(self) -> None:
        """A run met a full disk: begin nothing for a while."""
        self._rested = time.monotonic()


def is_want_of_space(ending: Ending, space: Space) -> bool:
    """Whether an attempt ended because a disk was full: it says so, or there was no room at its end.

    Libraries say it in many ways (a short write, a signal from a mapped file), so whatever ends badly
    while the reserve is used up is not held against the run.
    """
    if ending.cause not in (Cause.ERROR, Cause.CRASH):
        return False
    return any(word in ending.reason for word in WORDS) or space.is_used_up(ending.free)


def free_bytes(folder: Path) -> int:
    """Space that we may use on the disk of a folder."""
    return shutil.disk_usage(folder).free


def in_words(size: float) -> str:
    """A size for people.

    >>> in_words(3 * 2**30), in_words(700_000)
    ('3.0 GiB', '0.7 MiB')
    """
    return f"{size / 2**30:.1f} GiB" if size >= 2**30 else f"{size / 2**20:.1f} MiB"
