"""A scheduler and workers in processes of their own, started by the commands of docs/cluster.md."""

import os
import random
import re
import signal
import socket
import subprocess
import sys
from collections.abc import Callable, Iterator, Mapping
from contextlib import AbstractContextManager, contextmanager, suppress
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path
from queue import Empty, SimpleQueue

import psutil

from service.dask.engine import DaskEngine, Remote
from service.execution.protocol import Engine
from service.records.jobs import Kind
from service.workers.attempt import Attempt, Ended, Ending, Inbox, Message, ProgressMessage
from service.workers.timings import DEFAULT, Timings
from tests.service.support.fakes import is_gone, run_id, wait_until
from tests.service.support.targets import FakeRun

ROOT = Path(__file__).parents[3]
DOCUMENT = ROOT / "docs" / "cluster.md"
patiently = partial(wait_until, seconds=180.0)  # what imports Dask starts slowly on a busy machine
PRELOAD = "service.dask.worker"
EXAMPLE_HOST, EXAMPLE_PORT, EXAMPLE_COUNT = "scheduler.example.org", "8786", "--nworkers 4"


def documented(beginning: str, language: str = "sh") -> str:
    """The block of commands, or the program, of the document that has a line with this beginning.

    What the document starts in the background runs in the foreground: its process is the command's.
    """
    blocks = re.findall(rf"```{language}\n(.*?)```", DOCUMENT.read_text(), re.DOTALL)
    [block] = [block for block in blocks if re.search(f"^{re.escape(beginning)}", block, re.M)]
    return re.sub(r" 2> \S+ &$", "", block, flags=re.M)


def free_port() -> int:
    """Below those that the system gives to whoever asks for any: nobody gets it meanwhile."""
    while True:
        port = random.SystemRandom().randrange(10_000, 32_000)
        with socket.socket() as candidate, suppress(OSError):  # it is taken
            candidate.bind(("127.0.0.1", port))
            return port


def environment() -> dict[str, str]:
    """With the commands of this Python first, and this checkout of whipple."""
    path = os.pathsep.join([str(Path(sys.executable).parent), os.environ["PATH"]])
    return {**os.environ, "PATH": path, "PYTHONPATH": str(ROOT)}


def family(pid: int) -> list[int]:
    """A process and all that descend from it."""
    with suppress(psutil.NoSuchProcess):
        return [pid, *(child.pid for child in psutil.Process(pid).children(recursive=True))]
    return [pid]


def parent_of(pid: int) -> int:
    return psutil.Process(pid).ppid()


@dataclass
class ShellProcess:
    """A shell command in a session of its own, and what it says."""

    command: str
    folder: Path
    name: str
    more: Mapping[str, str] = field(default_factory=dict)  # environment
    descendants: set[int] = field(default_factory=set)  # ids of all that descended from it

    def __post_init__(self) -> None:
        self.log_file = self.folder / f"{self.name}.log"
        with self.log_file.open("ab") as log:
            self.process = subprocess.Popen(
                ["bash", "-c", self.command.rstrip().replace("\ndask ", "\nexec dask ")],
                cwd=self.folder,
                env={**environment(), **self.more},
                stdout=log,
                stderr=log,
                start_new_session=True,
            )

    def look(self) -> list[int]:
        """It, and what descends from it now."""
        pids = family(self.process.pid)
        self.descendants |= set(pids)
        return pids

    def kill(self) -> None:
        """Kill -9 all of it, as when a machine goes; what it had started must follow by itself."""
        self.look()
        for pid in family(self.process.pid):
            with suppress(ProcessLookupError):
                os.kill(pid, signal.SIGKILL)
        self.process.wait(60)

    def is_gone(self) -> bool:
        """Whether nothing is left of it and of all that it was seen to have started."""
        return all(is_gone(pid) for pid in self.descendants | {self.process.pid})


@dataclass
class DaskCluster:
    """A scheduler on a port of the loopback, its workers and the certificates."""

    folder: Path
    port: int = field(default_factory=free_port)
    processes: list[ShellProcess] = field(default_factory=list)

    def certify(self) -> None:
        subprocess.run(
            ["bash", "-ec", documented("openssl")], cwd=self.folder, check=True, capture_output=True, timeout=120
        )

    def remote(self, port: int | None = None) -> Remote:
        """What a service needs to know of it."""
        tls = self.folder / "tls"
        address = f"tls://127.0.0.1:{port or self.port}"
        return Remote(address, tls / "ca.pem", tls / "cert.pem", tls / "key.pem")

    def start_scheduler(self) -> ShellProcess:
        return self._start(documented("dask scheduler"), "scheduler")

    def start_workers(self, count: int = 1, *, preload: str = "", **more: str) -> ShellProcess:
        command = documented("dask worker").replace(EXAMPLE_COUNT, f"--nworkers {count}")
        if preload:
            command = command.replace(f"--preload {PRELOAD}", preload)
        return self._start(command, "workers", more)

    def end(self) -> None:
        """End everything that was started, and see that nothing is left of it."""
        for process in self.processes:
            process.kill()
        patiently(lambda: all(process.is_gone() for process in self.processes))

    def _start(self, command: str, name: str, more: Mapping[str, str] | None = None) -> ShellProcess:
        command = command.replace(EXAMPLE_HOST, "127.0.0.1").replace(EXAMPLE_PORT, str(self.port))
        process = ShellProcess(command, self.folder, f"{name}-{len(self.processes)}", more or {})
        self.processes.append(process)
        return process


@contextmanager
def running(folder: Path, workers: int = 2) -> Iterator[DaskCluster]:
    """A cluster until the end of the block; nothing of it is left behind."""
    folder.mkdir(exist_ok=True)
    cluster = DaskCluster(folder)
    cluster.certify()
    try:
        cluster.start_scheduler()
        if workers:
            cluster.start_workers(workers)
        yield cluster
    finally:
        cluster.end()


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


def serving(
    remote: Remote, timings: Timings = DEFAULT, *, leave_seconds: float | None = 0.0
) -> AbstractContextManager[EngineUser]:
    """An engine on a cluster, until the end of the block."""
    return using(lambda inbox: DaskEngine(remote, inbox, timings), leave_seconds=leave_seconds)


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
    return int(Path(str(attempt.checkpoint)).read_text())
