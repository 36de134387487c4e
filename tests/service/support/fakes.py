"""Sweeps that cost nothing, an engine that does what a test says, and waiting with a deadline."""

import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, cast

from service.records.attempt import Attempt
from service.records.jobs import Stored
from service.records.settings import Settings
from service.store import Store
from studies.sweeps.sweep import Sweep
from tests.service.support.targets import Run

DEADLINE = 60.0  # s; a busy machine is slow, a hanging test is not waited for


def wait_until(
    condition: Callable[[], Any], *, seconds: float = DEADLINE, pause: float = 0.05
) -> Any:
    """What ``condition`` returns as soon as it is true, looked at after each pause; fails when that takes too long."""
    end = time.monotonic() + seconds
    while not (answer := condition()):
        assert time.monotonic() < end, f"not within {seconds} s"
        time.sleep(pause)
    return answer


def is_gone(pid: int) -> bool:
    """Whether a process has ended; one that its parent has not looked at yet has ended too."""
    try:
        return Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[0] == "Z"
    except (FileNotFoundError, ProcessLookupError):
        return True


def run_id(number: int) -> str:
    """A content id."""
    return f"{number:032x}"


def runs_of(*behaviours: str, first: int = 0, **parameters: Any) -> list[Run]:
    """Runs that behave as said, numbered from ``first``."""
    return [
        Run(run_id(first + place), {"behaviour": word, **parameters})
        for place, word in enumerate(behaviours)
    ]


@dataclass(frozen=True)
class Point:
    """A point of a sweep."""

    index: tuple[int, ...]
    coordinates: Mapping[str, float | str]
    run: Run


@dataclass(frozen=True)
class FakeSweep:
    """What the store needs to know of a sweep."""

    asked: Sequence[Run]
    name: str = "asked"
    title: str = ""
    scenario: str = "thin_plate"

    def document(self) -> dict[str, Any]:
        return {"name": self.name, "runs": [run.id for run in self.asked]}

    def runs(self) -> list[Point]:
        return [
            Point((place,), {"speed": 1000.0 * place}, run) for place, run in enumerate(self.asked)
        ]


def sweep_of(runs: Sequence[Run] | int, *, name: str = "asked") -> Sweep:
    """A sweep of these runs, or of so many fine ones."""
    asked = [Run(run_id(number)) for number in range(runs)] if isinstance(runs, int) else runs
    return cast(Sweep, FakeSweep(asked, name))


def open_store(settings: Settings) -> Store:
    """A store in which every run is expected to cost one core second."""
    return Store.open(settings.url, cost=lambda run: 1.0)


def stored(name: str = "result.json", path: str = "runs/result.json") -> Stored:
    """A file that is nowhere."""
    return Stored(name, path, 2, "00" * 32)


@dataclass
class RecordingEngine:
    """An engine that only remembers what it was asked."""

    free: int = 2
    submitted: list[Attempt] = field(default_factory=list)
    stopped: list[str] = field(default_factory=list)
    under_way: set[str] = field(default_factory=set)  # of earlier lives: what ``known`` tells
    followed: list[str] = field(default_factory=list)
    forgotten: list[str] = field(default_factory=list)
    closed: list[float | None] = field(default_factory=list)  # seconds to leave; None: let go

    def slots(self) -> int:
        return self.free

    def submit(self, ticket: Attempt) -> None:
        self.submitted.append(ticket)

    def stop(self, keys: list[str]) -> None:
        self.stopped.extend(keys)

    def known(self) -> set[str]:
        return set(self.under_way)

    def follow(self, key: str) -> None:
        self.followed.append(key)

    def forget(self, keys: list[str]) -> None:
        self.forgotten.extend(keys)
        self.under_way.difference_update(keys)

    def close(self, leave_seconds: float | None) -> None:
        self.closed.append(leave_seconds)


def settings_in(folder: Path, **given: Any) -> Settings:
    """Settings of a service that computes with ``tests.service.support.targets``."""
    return Settings(data=folder, targets_module="tests.service.support.targets", **given)
