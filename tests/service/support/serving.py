"""``whipple serve`` as a process of its own, which can be killed and started again."""

import os
import subprocess
import sys
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Any

import httpx

from tests.service.support import fault_points
from tests.service.support.fakes import wait_until
from tests.service.support.processes import ROOT, free_port

if TYPE_CHECKING:
    from service.client.client import Client

SERVICE = ("-m", "service")
ARMED = ("-m", fault_points.__name__)  # the program of a life that ends at a fault point
START_SECONDS = 120.0  # deadlines, for machines that are busy with something else
LEAVE_SECONDS = 30.0
LAST_BYTES = 3000  # of the log, for whoever reads why a test failed


@cache
def http() -> httpx.Client:
    """One for all questions, for making one reads the machine's certificates: 50 ms; no connection is kept."""
    return httpx.Client(limits=httpx.Limits(max_keepalive_connections=0))


@dataclass
class Service:
    """A service on a port of its own; each of its lives has a log of its own."""

    data: Path
    environment: Mapping[str, str] = field(default_factory=dict)  # WHIPPLE_...
    name: str = "service"  # of its logs
    program: tuple[str, ...] = SERVICE
    port: int = field(default_factory=free_port)
    lives: int = 0
    process: "subprocess.Popen[bytes] | None" = None

    @property
    def url(self) -> str:
        return f"http://127.0.0.1:{self.port}"

    @property
    def log(self) -> Path:
        """Of this life."""
        return self.data.with_name(f"{self.name}-{self.lives}.log")

    def start(self, *, fault: str | None = None, **more: str) -> None:
        """Begin a life; with ``fault`` it ends at that point."""
        self.lives += 1
        command = ["serve", "--port", str(self.port), "--data", str(self.data)]
        variables = {**os.environ, "PYTHONPATH": str(ROOT), **self.environment, **more}
        with self.log.open("wb") as log:
            self.process = subprocess.Popen(
                [sys.executable, *(ARMED if fault else self.program), *command],
                cwd=ROOT,
                env={**variables, fault_points.VARIABLE: fault} if fault else variables,
                stdin=subprocess.DEVNULL,
                stdout=log,
                stderr=log,
            )

    def wait_until_listening(self) -> None:
        wait_until(self._answers, seconds=START_SECONDS)

    def wait_until_ready(self) -> None:
        wait_until(lambda: self.get("/readyz") == 200, seconds=START_SECONDS)

    def get(self, path: str) -> int | None:
        """The status of an answer; None where nobody answers."""
        try:
            return http().get(self.url + path, timeout=30).status_code
        except httpx.TransportError:
            return None

    def text(self, path: str) -> str:
        """The text of an answer, whatever its status."""
        return http().get(self.url + path, timeout=30).text

    def client(self) -> "Client":
        from service.client.client import Client  # a feature, which few tests need

        return Client(self.url)

    @property
    def pid(self) -> int:
        assert self.process is not None
        return self.process.pid

    def post(self, document: Mapping[str, Any]) -> int | None:
        """The status of the answer to a sweep; None where nobody answers."""
        try:
            return http().post(f"{self.url}/v1/sweeps", json=document, timeout=60).status_code
        except httpx.TransportError:
            return None

    def submit(self, document: Mapping[str, Any], **query: Any) -> str:
        """Give it a sweep; the sweep's id."""
        answer = http().post(f"{self.url}/v1/sweeps", params=query, json=document, timeout=60)
        assert answer.status_code == 202, answer.text
        return str(answer.json()["id"])

    def is_alive(self) -> bool:
        return self.process is not None and self.process.poll() is None

    def log_tail(self) -> str:
        return self.log.read_text(errors="replace")[-LAST_BYTES:]

    def kill(self) -> None:
        assert self.process is not None
        self.process.kill()
        self.process.wait()

    def die(self) -> int:
        """Wait for the end that a fault point brings; its status."""
        assert self.process is not None
        return self.process.wait(START_SECONDS)

    def leave(self) -> int:
        """SIGTERM; its status."""
        assert self.process is not None
        self.process.terminate()
        return self.process.wait(LEAVE_SECONDS)

    def end(self) -> None:
        """Let it leave in order, or kill it when it does not in time."""
        if self.is_alive():
            try:
                self.leave()
            except subprocess.TimeoutExpired:
                self.kill()
                raise

    def _answers(self) -> bool:
        assert self.is_alive(), self.log_tail()
        return self.get("/livez") == 200


@contextmanager
def serving(data: Path, *program: str, **environment: str) -> Iterator[Service]:
    """A service that listens, until the end of the block."""
    service = Service(data, environment, program=program or SERVICE)
    try:
        service.start()
        service.wait_until_listening()
        yield service
    finally:
        service.end()
