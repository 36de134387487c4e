"""What a crash test counts: faults that killed something, and no others."""

import os
import random
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from types import SimpleNamespace
from typing import Any, cast

import pytest

from service.records.jobs import State
from tests.crash.support.crash_test import CrashTest, Work
from tests.crash.support.faults import Fault, KillMoment, ObservedAttempt, Victim
from tests.crash.support.serving import MARK, process_tree
from tests.service.support.fakes import is_gone

SLEEP = [sys.executable, "-c", "import time; time.sleep(20)"]


@pytest.fixture
def here(tmp_path: Path) -> Iterator[CrashTest]:
    """A crash test whose service and store say that all is well, and that work is left while attempts are observed."""
    batches: list[list[ObservedAttempt]] = []
    queue = SimpleNamespace(states=cast(Any, None))

    def observed(_moment: KillMoment) -> list[ObservedAttempt]:
        found = batches.pop(0) if batches else []
        queue.states = {State.RUNNING: len(batches)}
        return found

    service = SimpleNamespace(data=tmp_path, is_alive=lambda: True, log_tail=lambda: "")
    store = SimpleNamespace(
        events=SimpleNamespace(last=lambda: 1), queue=SimpleNamespace(status=lambda: queue), leases=None
    )
    with process_tree() as tree:
        here = CrashTest(Work(1, 1), cast(Any, [service]), tree, cast(Any, store), random.Random(0))
        here.attempts = cast(Any, SimpleNamespace(at=observed, batches=batches))
        yield here


def inject(here: CrashTest, victim: Victim, *pids: int) -> None:
    """A fault, while an attempt after the other is observed."""
    attempts = [ObservedAttempt(cast(Any, SimpleNamespace(id=f"{pid}")), pid, frozenset(KillMoment)) for pid in pids]
    cast(Any, here.attempts).batches += [[attempt] for attempt in attempts]
    here.inject(Fault(0, victim, KillMoment.COMPUTING))


def ended() -> int:
    """The id of a process that is no more."""
    process = subprocess.Popen([sys.executable, "-c", ""])
    process.wait()
    return process.pid


@pytest.mark.parametrize("victim", [Victim.RUN, Victim.WORKER])
def test_blow__that_meets_nobody_is_not_counted(here: CrashTest, victim: Victim) -> None:
    inject(here, victim, ended())
    assert (here.injected, here.killed.total()) == ([], 0)


def test_blow__that_meets_nobody_falls_on_another(here: CrashTest) -> None:
    with subprocess.Popen(SLEEP) as process:
        inject(here, Victim.RUN, ended(), process.pid)
        assert is_gone(process.pid)
    assert len(here.injected) == 1
    assert +here.killed == {f"{process.pid}": 1}


def test_blow__spares_a_parent_that_is_no_worker(here: CrashTest) -> None:
    shell = ["sh", "-c", "sleep 600 & echo $!; read end; kill $!"]
    environment = {name: value for name, value in os.environ.items() if name != MARK}
    with subprocess.Popen(shell, env=environment, stdin=subprocess.PIPE, stdout=subprocess.PIPE) as parent:
        assert parent.stdout is not None
        inject(here, Victim.WORKER, int(parent.stdout.readline()))
        assert not is_gone(parent.pid)
    assert here.injected == []
