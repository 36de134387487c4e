"""Attempts in warm processes of this one or by an engine, and what is read of them."""

import json
import threading
from collections.abc import Callable, Iterator, Mapping
from contextlib import AbstractContextManager, contextmanager, suppress
from dataclasses import dataclass, replace
from pathlib import Path
from queue import Empty, SimpleQueue
from typing import Any

from service.execution.protocol import Engine
from service.records.jobs import AttemptProgress, Cause, Kind
from service.workers.attempt import Attempt, Ended, Ending, Inbox, Message, ProgressMessage, Publication
from service.workers.supervisor import SendProgress, Supervisor
from service.workers.timings import DEFAULT, Timings
from service.workers.warm import Slot
from studies.runs.run import RunSpec
from tests.service.support.fakes import run_id, wait_until
from tests.service.support.processes import patiently
from tests.service.support.targets import MEBIBYTE, FakeRun

SLOT = Slot()  # of all attempts in this process
LIMIT = 1024 * MEBIBYTE  # of memory; imports of the tests' targets take a tenth of it
NO_PAUSE = replace(DEFAULT, broken_worker_pause=0.0)
TARGETS = "tests.service.support.targets"


def attempt_at(folder: Path, behaviour: str = "fine", *, limit: float = 120.0, **more: Any) -> Attempt:
    """An attempt at a run that behaves as named."""
    run = FakeRun(run_id(1), {"behaviour": behaviour, **more})
    folder.mkdir(parents=True, exist_ok=True)
    directory = str(folder / "a1-token")
    return Attempt(directory, Kind.RUN, directory, run.as_json(), limit, TARGETS)


def with_checkpoint(folder: Path, **more: Any) -> Attempt:
    """An attempt at a run of many steps that writes a checkpoint."""
    return replace(attempt_at(folder, **more), checkpoint=str(folder / "checkpoint"))


def published(attempt: Attempt) -> Publication:
    """What an attempt to publish a sweep gets."""
    assert "outcomes" in attempt.spec
    return attempt.spec


def computed(attempt: Attempt) -> RunSpec:
    """What an attempt to compute a run gets."""
    assert "parameters" in attempt.spec
    return attempt.spec


def ignore(_progress: AttemptProgress) -> None:
    """Ignore progress."""


def supervise(attempt: Attempt, send: SendProgress = ignore, timings: Timings = NO_PAUSE) -> Ending:
    """Compute an attempt here and now."""
    return Supervisor(attempt, send, timings).run(SLOT)


class RunningAttempt:
    """An attempt under way in a thread."""

    def __init__(self, attempt: Attempt, timings: Timings = NO_PAUSE):
        self.attempt = attempt
        self.progress: list[AttemptProgress] = []
        self.supervisor = Supervisor(attempt, self.progress.append, timings)
        self._endings: list[Ending] = []
        self._thread = threading.Thread(target=self._run)
        self._thread.start()

    def _run(self) -> None:
        self._endings.append(self.supervisor.run(SLOT))

    def is_over(self) -> bool:
        """Whether it has ended, though its thread may not have."""
        return bool(self._endings)

    def end(self) -> Ending:
        """How it ended, once its thread is gone, with which a waiting process goes."""
        self._thread.join(120)
        ending = self._endings[0]
        task = Path(f"/proc/self/task/{self._thread.native_id}")  # a little longer than the thread
        wait_until(lambda: not task.exists(), pause=0.01)
        return ending

    def pid(self, name: str = "pid") -> int:
        """The process, or another one that wrote its id into a file of that name."""
        file = Path(self.attempt.directory) / name
        return int(wait_until(lambda: file.is_file() and file.read_text()))


@contextmanager
def under_way(attempt: Attempt, timings: Timings = NO_PAUSE) -> Iterator[RunningAttempt]:
    """An attempt that is stopped at the latest when the block ends."""
    running = RunningAttempt(attempt, timings)
    try:
        yield running
    finally:
        running.supervisor.stop()
        running.end()


def result_of(ending: Ending) -> dict[str, Any]:
    plain: dict[str, Any] = json.loads(Path(ending.files[0].path).read_text())
    return plain


def surroundings(ending: Ending) -> dict[str, Any]:
    provenance: dict[str, Any] = result_of(ending)["provenance"]
    return provenance


def process_of(ending: Ending) -> int:
    return int(surroundings(ending)["process"])


def log_of(attempt: Attempt) -> str:
    return (Path(attempt.directory) / "log.txt").read_text()


# --- by an engine ------------------------------------------------------------------------------------


class EngineUser:
    """An engine, and all messages that it sent."""

    def __init__(self, engine: Engine, inbox: Inbox):
        self.engine = engine
        self._inbox = inbox
        self.messages: list[Message] = []

    def receive(self) -> list[Message]:
        with suppress(Empty):
            while True:
                message = self._inbox.get_nowait()
                if message is not None:
                    self.messages.append(message)
        return self.messages

    def begin(self, *attempts: Attempt) -> list[int]:
        """Submit attempts; their processes, as soon as they have begun."""
        for attempt in attempts:
            self.engine.submit(attempt)
        return [pid_of(attempt) for attempt in attempts]

    def compute(self, *attempts: Attempt) -> list[Ending]:
        """Submit attempts; how they ended."""
        for attempt in attempts:
            self.engine.submit(attempt)
        return [self.end_of(attempt) for attempt in attempts]

    def end_of(self, attempt: Attempt, *, forget: bool = True) -> Ending:
        """How an attempt ended, as soon as it has."""

        def find() -> Ended | None:
            ended = (message for message in self.receive() if isinstance(message, Ended))
            return next((message for message in ended if message.key == attempt.key), None)

        message: Ended = patiently(find)
        if forget:  # else Dask computes it again when the worker dies that has the answer
            self.engine.forget([attempt.key])
        return message.ending

    def progress_of(self, attempt: Attempt) -> list[Mapping[str, object]]:
        """The progress of an attempt so far."""
        messages = (message for message in self.receive() if isinstance(message, ProgressMessage))
        return [message.progress for message in messages if message.key == attempt.key]

    def wait_for(self, kind: type[Message]) -> None:
        """Wait until the last message is of a kind."""
        patiently(lambda: self.receive() and isinstance(self.messages[-1], kind))

    def wait_for_slots(self, count: int) -> None:
        patiently(lambda: self.engine.slots() == count)


@contextmanager
def using(engine_of: Callable[[Inbox], Engine], *, leave_seconds: float | None = 0.0) -> Iterator[EngineUser]:
    """An engine until the end of the block."""
    inbox: Inbox = SimpleQueue()
    user = EngineUser(engine_of(inbox), inbox)
    try:
        yield user
    finally:
        user.engine.close(leave_seconds)


@dataclass(frozen=True)
class Place:
    """A kind of engine, and where it computes."""

    open: Callable[[], AbstractContextManager[EngineUser]]
    worker_of: Callable[[int], int]  # the process that a machine may lose, by that of an attempt
    worker_lost: Cause  # of an attempt whose worker is killed
    foreign: Callable[[], set[int]]  # processes that the engine did not start


def attempt_in(folder: Path, number: int = 1, behaviour: str = "fine", **more: object) -> Attempt:
    """An attempt at a run that behaves as named, with a checkpoint beside its folder."""
    home = folder / run_id(number)
    home.mkdir(parents=True, exist_ok=True)
    name = f"a{len(list(home.glob('a*'))) + 1}-token"
    (home / name).mkdir()
    run = FakeRun(run_id(number), {"behaviour": behaviour, **more})
    return Attempt(
        key=f"{run.id}-1-{folder.name}{name}",
        kind=Kind.RUN,
        directory=str(home / name),
        spec=run.as_json(),
        seconds_limit=120.0,
        targets="tests.service.support.targets",
        checkpoint=str(home / "checkpoint.npz"),
    )


def pid_of(attempt: Attempt) -> int:
    """The process of an attempt, as soon as there is one."""
    file = Path(attempt.directory) / "pid"
    return int(patiently(lambda: file.is_file() and file.read_text()))


def checkpoint_step(attempt: Attempt) -> int:
    """The step of an attempt's checkpoint."""
    step: int = json.loads(Path(str(attempt.checkpoint)).read_text())[1]
    return step
