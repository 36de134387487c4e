"""Sweeps that cost nothing, an engine that records, a store whose parts fail, and waiting with a deadline."""

import atexit
import shutil
import tempfile
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import ExitStack, closing, contextmanager
from dataclasses import dataclass, field
from functools import cache
from hashlib import sha256
from pathlib import Path
from typing import Any, cast
from unittest.mock import patch

import psutil

from service.records.expansion import ExpandedSweep, expanded_points
from service.records.jobs import Scope, Stored, StoreUnavailable
from service.settings import Settings
from service.store import Store
from service.store.leadership import Leadership, Terms
from service.workers.attempt import Attempt
from studies.runs.run import Run
from studies.sweeps.sweep import Point
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
        return psutil.Process(pid).status() == psutil.STATUS_ZOMBIE
    except psutil.NoSuchProcess:
        return True


def run_id(number: int) -> str:
    """A content id."""
    return f"{number:032x}"


def runs_of(*behaviours: str, first: int = 0, **parameters: Any) -> list[FakeRun]:
    """Runs that behave as named, numbered from ``first``."""
    return [FakeRun(run_id(first + place), {"behaviour": word, **parameters}) for place, word in enumerate(behaviours)]


def sweep_of(runs: Sequence[FakeRun] | int, *, name: str = "asked") -> ExpandedSweep:
    """A sweep of these runs, or of so many fine ones, each of one core second unless it says what it costs."""
    asked = [FakeRun(run_id(number)) for number in range(runs)] if isinstance(runs, int) else runs
    points = [Point((place,), {"speed": 1000.0 * place}, cast(Run, fake_run)) for place, fake_run in enumerate(asked)]
    return ExpandedSweep(
        name=name,
        title=name,
        scenario="thin_plate",
        document={"name": name, "runs": [fake_run.id for fake_run in asked]},
        points=tuple(expanded_points(points, cost=lambda run: float(str(run.parameters.get("cost", 1.0))))),
    )


@cache
def _empty_store() -> Path:
    """A folder with the database of an empty store."""
    folder = Path(tempfile.mkdtemp(prefix="whipple-empty-"))
    atexit.register(shutil.rmtree, folder, ignore_errors=True)
    Store.open(Settings(data=folder).url).close()
    return folder


def put_empty_store(folder: Path) -> None:
    """Copy the database of an empty store to a folder that has none: four times as fast as to make its tables."""
    if folder.is_dir() and not (folder / "whipple.db").exists():
        shutil.copytree(_empty_store(), folder, dirs_exist_ok=True)


def issue_key(folder: Path, name: str, *scopes: Scope) -> str:
    """The secret of a new key of the store in a folder; a service that others reach does not start without one."""
    with closing(Store.open(Settings(data=folder).url)) as store:
        return store.keys.issue(name, scopes)[1]


def open_store(settings: Settings) -> Store:
    """A store with its tables."""
    if settings.database_url is None:
        put_empty_store(settings.data)
    return Store.open(settings.url)


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


@contextmanager
def failing(part: object, *methods: str) -> Iterator[None]:
    """Let these methods of a part of a store fail as if the database was away, until the end of the block."""

    def fail(*_arguments: object, **_options: object) -> None:
        raise StoreUnavailable("the database is away")

    with ExitStack() as ends:
        for method in methods:
            ends.enter_context(patch.object(part, method, fail))
        yield


class LosableTerms(Terms):
    """Terms of a real store whose lead can be refused and lost."""

    grants_lead = True
    has_lost_lead = False

    def lead(self, owner: str) -> Leadership | None:
        """The lead, as often as it is asked for, unless another service has it."""
        self.has_lost_lead = False
        return LosableLeadership(self) if self.grants_lead else None


class LosableLeadership(Leadership):
    """The lead, until its terms say that it is lost."""

    def __init__(self, terms: LosableTerms):
        super().__init__()
        self._terms = terms

    def holds(self) -> bool:
        return not self._terms.has_lost_lead


def settings_in(folder: Path, **options: Any) -> Settings:
    """Settings of a service that computes with ``tests.service.support.targets``."""
    return Settings(data=folder, **{"targets_module": "tests.service.support.targets", "scrub_rate": 0, **options})
