"""A disk that is full: nothing is begun, what met it is tried again, and the state says so."""

import errno
import os
from collections.abc import Iterator
from pathlib import Path
from types import SimpleNamespace

import pytest

from service.files import disk_space as space
from service.files.disk_space import Space
from service.queue.retry import excuse_full_disk
from service.records.jobs import Cause
from service.workers.attempt import Ending
from tests.service.support.harness import Harness, open_harness

RESERVE = 1 << 30


class Disk:
    """As much free space as a test says."""

    def __init__(self, monkeypatch: pytest.MonkeyPatch):
        self.free = 2 * RESERVE
        monkeypatch.setattr(space.shutil, "disk_usage", self._usage)

    def _usage(self, _folder: Path) -> SimpleNamespace:
        return SimpleNamespace(free=self.free)


@pytest.fixture
def disk(monkeypatch: pytest.MonkeyPatch) -> Disk:
    return Disk(monkeypatch)


@pytest.fixture
def harness(tmp_path: Path, disk: Disk, monkeypatch: pytest.MonkeyPatch) -> Iterator[Harness]:
    monkeypatch.setattr(space, "PAUSE_SECONDS", 0.0)
    with open_harness(tmp_path, disk_reserve=RESERVE) as opened:
        yield opened


def full(words: str = os.strerror(errno.ENOSPC)) -> Ending:
    """How an attempt ends that met a full disk."""
    return Ending(Cause.ERROR, "OSError", f"[Errno 28] {words}: 'state.npz'", (), 1.0)


def test_reserve__nothing_is_begun_below_it_and_the_state_says_so(harness: Harness, disk: Disk) -> None:
    disk.free = RESERVE - 1
    harness.submit(1)
    assert harness.tick() == []
    said = harness.dispatcher.blocked_reason()
    assert said is not None
    assert said == harness.store.queue.status().blocked_reason
    assert "reserve" in said
    disk.free = RESERVE
    assert len(harness.tick()) == 1
    assert harness.dispatcher.blocked_reason() is harness.store.queue.status().blocked_reason is None


FULL, PLENTY = RESERVE - 1, 2 * RESERVE  # free bytes
NO_SPACE, NO_QUOTA = os.strerror(errno.ENOSPC), os.strerror(errno.EDQUOT)


@pytest.mark.parametrize(
    ("cause", "reason", "free_at_end", "counts_as"),
    [
        (Cause.ERROR, NO_SPACE, FULL, Cause.LOST),
        (Cause.ERROR, NO_QUOTA, FULL, Cause.LOST),
        (Cause.ERROR, "NetCDF: HDF error", FULL, Cause.LOST),  # whatever the library says
        (Cause.CRASH, "the process died: SIGBUS", FULL, Cause.LOST),
        (Cause.ERROR, NO_SPACE, PLENTY, Cause.CRASH),  # it left room behind: it may never fit
        (Cause.ERROR, NO_QUOTA, PLENTY, Cause.CRASH),
        (Cause.ERROR, "something else", PLENTY, Cause.ERROR),
        (None, NO_SPACE, FULL, None),
        (Cause.LOST, NO_SPACE, FULL, Cause.LOST),
        (Cause.TIME_LIMIT, NO_SPACE, FULL, Cause.TIME_LIMIT),
        (Cause.MEMORY_LIMIT, NO_SPACE, FULL, Cause.MEMORY_LIMIT),
    ],
)
@pytest.mark.parametrize("is_known", [True, False])
def test_full_disk__is_judged_by_the_room_at_the_end_of_the_attempt_or_now(
    tmp_path: Path, disk: Disk, cause: Cause | None, reason: str, free_at_end: int, counts_as: Cause, is_known: bool
) -> None:
    disk.free = PLENTY if is_known else free_at_end
    ending = Ending(cause, "", reason, (), 1.0, free=free_at_end if is_known else None)
    assert excuse_full_disk(ending, Space(tmp_path, RESERVE)).cause is counts_as


def test_full_disk__after_it_nothing_is_begun_for_a_while(harness: Harness, monkeypatch: pytest.MonkeyPatch) -> None:
    [ticket] = harness.begin(1)
    monkeypatch.setattr(space, "PAUSE_SECONDS", 3600.0)
    harness.end(ticket, full())
    assert harness.tick() == []
    assert "full disk" in str(harness.dispatcher.blocked_reason())
    monkeypatch.setattr(space, "PAUSE_SECONDS", 0.0)
    assert len(harness.tick()) == 1
