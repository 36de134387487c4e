"""A scheduler and workers in processes of their own, started by the commands of docs/cluster.md."""

import re
import subprocess
from collections.abc import Iterator, Mapping
from contextlib import AbstractContextManager, contextmanager
from dataclasses import dataclass, field
from pathlib import Path

from service.dask.engine import DaskEngine, Remote
from service.workers.timings import DEFAULT, Timings
from tests.service.support.attempts import EngineUser, using
from tests.service.support.processes import ROOT, ShellProcess, free_port, patiently

DOCUMENT = ROOT / "docs" / "cluster.md"
PRELOAD = "service.dask.worker"
MEMORY_LIMIT = "4GiB"  # of a run
EXAMPLE_HOST, EXAMPLE_PORT, EXAMPLE_COUNT = "scheduler.example.org", "8786", "--nworkers 4"


def documented(beginning: str, language: str = "sh") -> str:
    """The block of commands, or the program, of the document that has a line with this beginning.

    What the document starts in the background runs in the foreground: its process is the command's.
    """
    blocks = re.findall(rf"```{language}\n(.*?)```", DOCUMENT.read_text(), re.DOTALL)
    [block] = [block for block in blocks if re.search(f"^{re.escape(beginning)}", block, re.M)]
    return re.sub(r" 2> \S+ &$", "", block, flags=re.M)


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

    def restart(self, count: int, **environment: str) -> None:
        """Restart scheduler and workers that have died, as systemd does."""
        if self.scheduler().is_dead():
            self.start_scheduler()
        if all(process.is_dead() for process in self.processes if process.name.startswith("workers")):
            self.start_workers(count, **environment)

    def scheduler(self) -> ShellProcess:
        """The last one that was started."""
        return [process for process in self.processes if process.name.startswith("scheduler")][-1]

    def settings(self) -> dict[str, str]:
        """Variables of a service that computes here."""
        remote = self.remote()
        return {
            "WHIPPLE_ENGINE": remote.address,
            "WHIPPLE_TLS_CA": str(remote.ca),
            "WHIPPLE_TLS_CERT": str(remote.certificate),
            "WHIPPLE_TLS_KEY": str(remote.key),
            "WHIPPLE_MEMORY_LIMIT": MEMORY_LIMIT,
        }

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


def serving(
    remote: Remote, timings: Timings = DEFAULT, *, leave_seconds: float | None = 0.0
) -> AbstractContextManager[EngineUser]:
    """An engine on a cluster, until the end of the block."""
    return using(lambda inbox: DaskEngine(remote, inbox, timings), leave_seconds=leave_seconds)
