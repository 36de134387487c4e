"""What a crash_test counts: faults that killed something, and no others."""

import os
import random
import subprocess
import sys
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from types import SimpleNamespace
from typing import Any, cast

import pytest

from service.records.jobs import State
from tests.acceptance.support.crash_test import CrashTest, Work
from tests.acceptance.support.faults import Fault, KillMoment, ObservedAttempt, Victim
from tests.acceptance.support.process_tree import MARK, process_tree
from tests.service.support.fakes import is_gone

SLEEP = [sys.executable, "-c", "import time; time.sleep(20)"]


@dataclass
class FakeService:
    """Stands in for service, store and field: says what it was told, one answer after the other."""

    data: Path
    batches: list[list[ObservedAttempt]] = field(default_factory=list)

    def is_alive(self) -> bool:
        return True

    def log_tail(self) -> str:
        return ""

    def last_event(self) -> int:
        return 1

    def queue(self) -> SimpleNamespace:
        return SimpleNamespace(states={State.RUNNING: len(self.batches)})

    def at(self, _moment: KillMoment) -> list[ObservedAttempt]:
        return self.batches.pop(0) if self.batches else []


@pytest.fixture
def here(tmp_path: Path) -> Iterator[CrashTest]:
    fake = cast(Any, FakeService(tmp_path))
    with process_tree() as tree:
        tested = CrashTest(Work(1, 1), tmp_path, fake, tree, fake, random.Random(0))
        tested.attempts = fake
        yield tested


def target(id: str, pid: int) -> ObservedAttempt:
    return ObservedAttempt(cast(Any, SimpleNamespace(id=id)), pid, frozenset(KillMoment))


def ended() -> int:
    """The id of a process that is no more."""
    process = subprocess.Popen([sys.executable, "-c", ""])
    process.wait()
    return process.pid


@pytest.mark.parametrize("victim", [Victim.RUN, Victim.WORKER])
def test_blow__that_meets_nobody_is_not_counted(here: CrashTest, victim: Victim) -> None:
    cast(Any, here.attempts).batches = [[target("a", ended())]]
    here.inject(Fault(0, victim, KillMoment.COMPUTING))
    assert (here.injected, here.killed.total()) == ([], 0)


def test_blow__that_meets_nobody_falls_on_another(here: CrashTest) -> None:
    with subprocess.Popen(SLEEP) as process:
        cast(Any, here.attempts).batches = [[target("a", ended())], [target("b", process.pid)], []]
        here.inject(Fault(0, Victim.RUN, KillMoment.COMPUTING))
        assert is_gone(process.pid)
    assert len(here.injected) == 1
    assert (here.killed["a"], here.killed["b"]) == (0, 1)


def test_blow__spares_a_parent_that_is_no_worker(here: CrashTest) -> None:
    shell = ["sh", "-c", "sleep 600 & echo $!; read end; kill $!"]
    environment = {name: value for name, value in os.environ.items() if name != MARK}
    with subprocess.Popen(shell, env=environment, stdin=subprocess.PIPE, stdout=subprocess.PIPE) as parent:
        assert parent.stdout is not None
        cast(Any, here.attempts).batches = [[target("a", int(parent.stdout.readline()))]]
        here.inject(Fault(0, Victim.WORKER, KillMoment.COMPUTING))
        assert not is_gone(parent.pid)
    assert here.injected == []
