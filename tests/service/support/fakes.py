"""Sweeps that cost nothing, an engine that records, a store that fails, and waiting with a deadline."""

import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from hashlib import sha256
from pathlib import Path
from typing import Any, cast

from service.records.attempt import Attempt
from service.records.jobs import Stored, StoreUnavailable
from service.records.settings import Settings
from service.store import Leadership, Store
from studies.sweeps.sweep import Sweep
from tests.service.support.targets import FakeRun

DEADLINE = 60.0  # s; a busy machine is slow, a hanging test is not waited for


def wait_until(condition: Callable[[], Any], *, seconds: float = DEADLINE, pause: float = 0.05) -> Any:
    """Poll ``condition`` until it is true, and return its value; fails after so many seconds."""
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


def runs_of(*behaviours: str, first: int = 0, **parameters: Any) -> list[FakeRun]:
    """Runs that behave as named, numbered from ``first``."""
    return [FakeRun(run_id(first + place), {"behaviour": word, **parameters}) for place, word in enumerate(behaviours)]


@dataclass(frozen=True)
class FakePoint:
    """A point of a sweep."""

    index: tuple[int, ...]
    coordinates: Mapping[str, float | str]
    run: FakeRun


@dataclass(frozen=True)
class FakeSweep:
    """What the store needs to know of a sweep."""

    asked: Sequence[FakeRun]
    name: str = "asked"
    title: str = ""
    scenario: str = "thin_plate"

    def document(self) -> dict[str, Any]:
        return {"name": self.name, "runs": [run.id for run in self.asked]}

    def runs(self) -> list[FakePoint]:
        return [FakePoint((place,), {"speed": 1000.0 * place}, run) for place, run in enumerate(self.asked)]

    every_run = runs


def sweep_of(runs: Sequence[FakeRun] | int, *, name: str = "asked") -> Sweep:
    """A sweep of these runs, or of so many fine ones."""
    asked = [FakeRun(run_id(number)) for number in range(runs)] if isinstance(runs, int) else runs
    return cast(Sweep, FakeSweep(asked, name))


def open_store(settings: Settings) -> Store:
    """A store in which every run is expected to cost one core second."""
    return Store.open(settings.url, cost=lambda run: 1.0)


def stored(name: str = "result.json", path: str = "runs/result.json") -> Stored:
    """A file that exists in rows alone, unless a test writes ``b"..."``."""
    return Stored(name, path, 3, sha256(b"...").hexdigest())


@dataclass
class RecordingEngine:
    """An engine that computes nothing and records what it is asked."""

    free: int = 2
    submitted: list[Attempt] = field(default_factory=list)
    stopped: list[str] = field(default_factory=list)
    under_way: set[str] = field(default_factory=set)  # of earlier lives: what ``attempts`` returns
    followed: list[str] = field(default_factory=list)
    forgotten: list[str] = field(default_factory=list)
    closed: list[float | None] = field(default_factory=list)  # seconds to leave; None: abandoned
    refuses: bool = False  # every attempt
    while_closing: Callable[[], None] = lambda: None

    def slots(self) -> int:
        return self.free

    def submit(self, attempt: Attempt) -> None:
        if self.refuses:
            raise OSError("the scheduler is away")
        self.submitted.append(attempt)

    def stop(self, keys: list[str]) -> None:
        self.stopped.extend(keys)

    def attempts(self) -> set[str]:
        return set(self.under_way)

    def follow(self, key: str) -> None:
        self.followed.append(key)

    def forget(self, keys: list[str]) -> None:
        self.forgotten.extend(keys)
        self.under_way.difference_update(keys)

    def close(self, leave_seconds: float | None) -> None:
        self.while_closing()
        self.closed.append(leave_seconds)


class FlakyStore:
    """A real store some of whose methods fail as if the database was away, and whose lead can be lost."""

    def __init__(self, store: Store):
        self._store = store
        self.failing: set[str] = set()  # names of methods
        self.overrides: dict[str, Callable[..., Any]] = {}  # methods in place of the store's own
        self.grants_lead = True
        self.has_lost_lead = False

    def __getattr__(self, name: str) -> Any:
        if name in self.failing:
            raise StoreUnavailable("the database is away")
        return self.overrides.get(name) or getattr(self._store, name)

    def lead(self, owner: str) -> Leadership | None:
        """The lead, as often as it is asked for, unless another service has it."""
        if "lead" in self.failing:
            raise StoreUnavailable("the database is away")
        self.has_lost_lead = False
        return FakeLeadership(self) if self.grants_lead else None


class FakeLeadership(Leadership):
    """The lead, until the store says that it is lost."""

    def __init__(self, store: FlakyStore):
        super().__init__()
        self._flaky = store

    def holds(self) -> bool:
        return not self._flaky.has_lost_lead


def settings_in(folder: Path, **options: Any) -> Settings:
    """Settings of a service that computes with ``tests.service.support.targets``."""
    return Settings(data=folder, targets_module="tests.service.support.targets", **options)
