"""A disk that is full: nothing is begun, what met it is tried again, and the state says so."""

import errno
import os
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest

from service.files import disk_space as space
from service.files.disk_space import Space, is_full_disk
from service.records.attempt import Ending
from service.records.jobs import Cause, Kind, State, StoreUnavailable, Submission
from tests.service.support.fakes import sweep_of
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
    harness.store.create_sweep(Submission(sweep_of(1)))
    assert harness.tick() == []
    said = harness.dispatcher.blocked_reason()
    assert said is not None
    assert said == harness.store.queue().blocked_reason
    assert "reserve" in said
    disk.free = RESERVE
    assert len(harness.tick()) == 1
    assert harness.dispatcher.blocked_reason() is harness.store.queue().blocked_reason is None


def test_reserve__what_is_under_way_goes_on_and_is_registered(harness: Harness, disk: Disk) -> None:
    harness.store.create_sweep(Submission(sweep_of(1)))
    [ticket] = harness.tick()
    disk.free = 0
    harness.end_well(ticket)
    harness.tick()
    assert harness.run().state is State.SUCCEEDED
    assert harness.engine.stopped == []


@pytest.mark.parametrize("number", [errno.ENOSPC, errno.EDQUOT])
def test_full_disk__the_run_is_queued_again_and_costs_nothing(harness: Harness, disk: Disk, number: int) -> None:
    harness.store.create_sweep(Submission(sweep_of(1)))
    for _ in range(3):
        [ticket] = harness.tick()
        disk.free = RESERVE - 1
        harness.end(ticket, full(os.strerror(number)))
        harness.tick()
        disk.free = RESERVE
    assert len(harness.tick()) == 1
    assert (harness.run().state, harness.run().crashes) == (State.RUNNING, 0)


@pytest.mark.parametrize("number", [errno.ENOSPC, errno.EDQUOT])
def test_full_disk__a_run_that_leaves_room_behind_has_crashed(harness: Harness, number: int) -> None:
    harness.store.create_sweep(Submission(sweep_of(1)))
    for _ in range(3):
        [ticket] = harness.tick()
        harness.end(ticket, full(os.strerror(number)))
    assert [ticket.kind for ticket in harness.tick()] == [Kind.PUBLISH]
    assert (harness.run().state, harness.run().cause) == (State.FAILED, Cause.CRASH)
    assert "the disk was full" in str(harness.run().reason)


def test_full_disk__is_full_without_a_reserve_too(tmp_path: Path, disk: Disk) -> None:
    disk.free = 0
    assert Space(tmp_path, 0).is_used_up()
    assert Space(tmp_path, 0).blocked_reason() is None


def test_full_disk__is_believed_whatever_the_library_says(harness: Harness, disk: Disk) -> None:
    harness.store.create_sweep(Submission(sweep_of(2)))
    one, other = harness.tick()
    disk.free = RESERVE - 1
    harness.end_badly(one, Cause.ERROR, reason="NetCDF: HDF error")
    harness.end_badly(other, Cause.CRASH, reason="the process died: SIGBUS")
    assert harness.tick() == []
    disk.free = RESERVE
    assert len(harness.tick()) == 2
    assert {harness.run(number).crashes for number in (0, 1)} == {0}


@pytest.mark.parametrize(
    ("cause", "reason"),
    [
        (Cause.ERROR, os.strerror(errno.ENOSPC)),
        (Cause.ERROR, "NetCDF: HDF error"),
        (Cause.CRASH, "the process died: SIGBUS"),
    ],
)
def test_full_disk__is_judged_by_the_room_that_there_was(harness: Harness, cause: Cause, reason: str) -> None:
    harness.store.create_sweep(Submission(sweep_of(1)))
    [ticket] = harness.tick()
    harness.end_badly(ticket, cause, reason=reason, free=RESERVE - 1)  # there is room again
    assert len(harness.tick()) == 1
    assert (harness.run().state, harness.run().crashes) == (State.RUNNING, 0)


def test_full_disk__is_judged_once_however_long_the_store_is_away(
    harness: Harness, disk: Disk, monkeypatch: pytest.MonkeyPatch
) -> None:
    def away(*_arguments: Any, **_words: Any) -> State | None:
        raise StoreUnavailable("database or disk is full")

    harness.store.create_sweep(Submission(sweep_of(1)))
    [ticket] = harness.tick()
    disk.free = 0
    harness.end(ticket, replace(full("no room"), free=0))
    with monkeypatch.context() as patch:
        patch.setattr(harness.store, "requeue", away)
        with pytest.raises(StoreUnavailable):
            harness.tick()
    disk.free = 2 * RESERVE
    assert len(harness.tick()) == 1
    assert (harness.run().state, harness.run().crashes) == (State.RUNNING, 0)


def test_full_disk__after_it_nothing_is_begun_for_a_while(harness: Harness, monkeypatch: pytest.MonkeyPatch) -> None:
    harness.store.create_sweep(Submission(sweep_of(1)))
    [ticket] = harness.tick()
    monkeypatch.setattr(space, "PAUSE_SECONDS", 3600.0)
    harness.end(ticket, full())
    assert harness.tick() == []
    assert "full disk" in str(harness.dispatcher.blocked_reason())
    monkeypatch.setattr(space, "PAUSE_SECONDS", 0.0)
    assert len(harness.tick()) == 1


@pytest.mark.parametrize("cause", [None, Cause.LOST, Cause.TIME_LIMIT, Cause.MEMORY_LIMIT])
def test_want_of_space__explains_only_errors_and_crashes(tmp_path: Path, disk: Disk, cause: Cause | None) -> None:
    disk.free = 0
    assert not is_full_disk(Ending(cause, "", "", (), 1.0), Space(tmp_path, RESERVE))


def test_want_of_space__an_error_with_room_on_the_disk_is_an_error(tmp_path: Path, disk: Disk) -> None:
    ending = Ending(Cause.ERROR, "RuntimeError", "something else", (), 1.0)
    assert not is_full_disk(ending, Space(tmp_path, RESERVE))
