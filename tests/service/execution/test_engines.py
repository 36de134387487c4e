"""The engine that the settings ask for, and what is particular to the one of this machine."""

from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

import pytest

from service.execution.local import LocalEngine
from service.records.jobs import Cause
from service.workers.supervisor import Supervisor
from service.workers.timings import DEFAULT
from tests.service.support.attempts import attempt_in, using
from tests.service.support.fakes import is_gone

ONE_SLOT = partial(LocalEngine, 1)


def test_slot__whose_supervisor_fails_serves_the_next_attempt(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def fail(*_arguments: Any) -> None:
        raise ZeroDivisionError("an unexpected error")

    with using(ONE_SLOT) as user:
        with monkeypatch.context() as patch:
            patch.setattr(Supervisor, "run", fail)
            [ending] = user.compute(attempt_in(tmp_path, 1))
        assert (ending.cause, ending.failure) == (Cause.LOST, "ZeroDivisionError")
        assert user.compute(attempt_in(tmp_path, 2))[0].cause is None


def test_close__an_attempt_that_waits_for_a_slot_does_not_begin(tmp_path: Path) -> None:
    first, waiting = attempt_in(tmp_path, 1, "hang"), attempt_in(tmp_path, 2)
    with using(ONE_SLOT) as user:
        user.begin(first)
        user.engine.submit(waiting)
    assert {user.end_of(attempt).failure for attempt in (first, waiting)} == {"Stopped"}
    assert not Path(waiting.directory, "pid").exists()


def test_close__reports_that_a_slot_is_still_busy(tmp_path: Path) -> None:
    impatient = partial(LocalEngine, 1, timings=replace(DEFAULT, stop=-1.0))
    with using(impatient, leave_seconds=60.0) as user:
        [pid] = user.begin(attempt_in(tmp_path, 1, "deaf"))
        with pytest.raises(TimeoutError, match="1 of 1 slots"):
            user.engine.close(0.0)
    assert is_gone(pid)
