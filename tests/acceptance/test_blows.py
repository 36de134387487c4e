"""What a drill counts: blows that killed something, and no others."""

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
from tests.acceptance.blows import Blow, Moment, Target, Victim
from tests.acceptance.drill import Drill, Work
from tests.acceptance.herd import MARK, herded
from tests.service.support.fakes import is_gone

SLEEP = [sys.executable, "-c", "import time; time.sleep(20)"]


@dataclass
class Told:
    """Stands in for service, store and field: says what it was told, one answer after the other."""

    data: Path
    found: list[list[Target]] = field(default_factory=list)

    def is_alive(self) -> bool:
        return True

    def said(self) -> str:
        return ""

    def last_event(self) -> int:
        return 1

    def queue(self) -> SimpleNamespace:
        return SimpleNamespace(states={State.RUNNING: len(self.found)})

    def targets(self, _moment: Moment) -> list[Target]:
        return self.found.pop(0) if self.found else []


@pytest.fixture
def here(tmp_path: Path) -> Iterator[Drill]:
    told = cast(Any, Told(tmp_path))
    with herded() as herd:
        drill = Drill(Work(1, 1), tmp_path, told, herd, told, random.Random(0))
        drill.field = told
        yield drill


def target(id: str, pid: int) -> Target:
    return Target(cast(Any, SimpleNamespace(id=id)), pid, frozenset(Moment))


def ended() -> int:
    """The id of a process that is no more."""
    process = subprocess.Popen([sys.executable, "-c", ""])
    process.wait()
    return process.pid


@pytest.mark.parametrize("victim", [Victim.RUN, Victim.WORKER])
def test_blow__that_meets_nobody_is_not_counted(here: Drill, victim: Victim) -> None:
    cast(Any, here.field).found = [[target("a", ended())]]
    here.strike(Blow(0, victim, Moment.COMPUTING))
    assert (here.done, here.hit.total()) == ([], 0)


def test_blow__that_meets_nobody_falls_on_another(here: Drill) -> None:
    with subprocess.Popen(SLEEP) as process:
        cast(Any, here.field).found = [[target("a", ended())], [target("b", process.pid)], []]
        here.strike(Blow(0, Victim.RUN, Moment.COMPUTING))
        assert is_gone(process.pid)
    assert len(here.done) == 1
    assert (here.hit["a"], here.hit["b"]) == (0, 1)


def test_blow__spares_a_parent_that_is_no_worker(here: Drill) -> None:
    shell = ["sh", "-c", "sleep 600 & echo $!; read end; kill $!"]
    others = {name: value for name, value in os.environ.items() if name != MARK}
    with subprocess.Popen(
        shell, env=others, stdin=subprocess.PIPE, stdout=subprocess.PIPE
    ) as parent:
        assert parent.stdout is not None
        cast(Any, here.field).found = [[target("a", int(parent.stdout.readline()))]]
        here.strike(Blow(0, Victim.WORKER, Moment.COMPUTING))
        assert not is_gone(parent.pid)
    assert here.done == []
