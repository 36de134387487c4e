"""Verification of what attempts left: whether it is whole, in text that rows take, beside the ticks."""

import errno
import json
import os
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path

import pytest

from service.files.artifacts import Artifacts, describe
from service.records.jobs import Cause, State, Stored
from service.workers.attempt import Ending
from tests.service.support.fakes import DEADLINE, run_id, runs_of
from tests.service.support.harness import AT_ONCE, Harness, open_harness

NO_DOUBT = replace(AT_ONCE, verification_retry_limit=0.0)


def test_text__that_no_database_takes_is_made_legible(tmp_path: Path, database_url: str) -> None:
    reason = "cannot read 'caf\udce9.toml'\0" + 5000 * "!"
    with open_harness(tmp_path, database_url=database_url) as harness:
        harness.engine.free = 3
        crashed, failed, verdict = harness.begin(runs_of("fine", "fine", "verdict"))
        harness.end_badly(crashed, Cause.CRASH, reason=reason)
        harness.end_badly(failed, Cause.ERROR, reason=reason, failure="\0")
        file = Path(harness.compute(verdict).files[0].path)
        file.write_text(json.dumps(json.loads(file.read_text()) | {"reason": "at \ud83d\0"}))
        harness.end(verdict, Ending(None, "", "", (describe(file),), 1.0))
        harness.tick()
        assert [harness.run(number).state for number in (0, 1)] == [State.RUNNING, State.FAILED]
        assert str(harness.run(1).reason).startswith("cannot read 'caf\ufffd.toml'\ufffd!")
        row = harness.run(2)
        assert (row.cause, row.reason) == (Cause.VERDICT, "at \ufffd\ufffd")


Checks = dict[str, Callable[[], None]]


@pytest.fixture
def checks(monkeypatch: pytest.MonkeyPatch) -> Iterator[Checks]:
    """Functions that are called before the digest of a file is compared, by the id of its run."""
    is_intact, before = Artifacts.is_intact, Checks()

    def check(artifacts: Artifacts, file: Stored) -> bool:
        for id, call in before.items():
            if id in file.path:
                call()
        return is_intact(artifacts, file)

    monkeypatch.setattr(Artifacts, "is_intact", check)
    yield before
    before.clear()


def fails(number: int, tried: list[int] | None = None) -> Callable[[], None]:
    """A check that meets an error of the system, and counts how often."""

    def fail() -> None:
        if tried is not None:
            tried.append(number)
        raise OSError(number, os.strerror(number))

    return fail


@pytest.mark.parametrize("cause", [None, Cause.LOST])
@pytest.mark.parametrize("number", [errno.EIO, errno.ENOENT, errno.EMFILE])
def test_disk_that_fails__is_tried_again_and_costs_the_run_nothing(
    harness: Harness, checks: Checks, number: int, cause: Cause | None
) -> None:
    [attempt] = harness.begin(1)
    ending = harness.compute(attempt)
    harness.end(attempt, ending if cause is None else Ending(cause, "", "", (), 1.0))
    checks[run_id(0)] = fails(number)
    harness.tick()
    harness.tick()
    checks.clear()
    harness.tick()
    assert harness.is_first_success()


@pytest.mark.parametrize("damage", ["{}", "", None])
def test_damaged_result__is_computed_again_unless_the_disk_was_late(tmp_path: Path, damage: str | None) -> None:
    with open_harness(tmp_path, NO_DOUBT) as harness:
        late, damaged = harness.begin(2)
        files = [Path(harness.compute(one).files[0].path) for one in (late, damaged)]
        whole = files[0].read_bytes()
        for attempt, file in zip((late, damaged), files, strict=True):
            harness.end(attempt, Ending(None, "", "", (describe(file),), 1.0))
            file.unlink() if damage is None else file.write_text(damage)
        assert harness.tick() == []
        files[0].write_bytes(whole)
        [again] = harness.tick()
        assert again.directory != damaged.directory
        assert harness.is_first_success()
        assert harness.run(1).crashes == 1


@contextmanager
def slow(checks: Checks, number: int) -> Iterator[None]:
    """Let the digests of a run take until the end of the block."""
    may_go_on = threading.Event()

    def wait() -> None:
        assert may_go_on.wait(DEADLINE)

    checks[run_id(number)] = wait
    try:
        yield
    finally:
        may_go_on.set()


def test_large_result__does_not_hold_up_the_ticks(tmp_path: Path, checks: Checks) -> None:
    with open_harness(tmp_path, replace(AT_ONCE, verification_wait=1.0)) as harness:
        large, small = harness.begin(3)
        with slow(checks, 0):
            harness.end_well(large)
            assert len(harness.tick()) == 1  # its slot is free
            harness.end_well(small)
            harness.tick()
            states = [harness.run(number).state for number in (0, 1)]
            assert states == [State.RUNNING, State.SUCCEEDED]
        assert harness.inbox is not None
        assert harness.inbox.get(timeout=DEADLINE) is None  # a tick is asked for
        harness.tick()
        assert harness.is_first_success()
