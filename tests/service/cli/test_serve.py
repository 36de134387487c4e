"""``whipple serve`` as a server: it listens, heeds signals from the first moment, and leaves in order."""

import os
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from queue import SimpleQueue
from typing import Any

import httpx
import pytest
from fastapi import FastAPI, Request

from service.cli import serve
from service.cli.serve import _listening, _Server
from service.cli.signals import handling_end_signals
from service.settings import Settings
from studies.quantities.findings import InvalidInput
from tests.service.support.fakes import DEADLINE

ROOT = Path(__file__).parents[3]


@dataclass
class Recorder:
    """Stands in for the engine and for the event streams, and records the calls."""

    calls: list[str] = field(default_factory=list)

    def leave(self) -> None:
        self.calls.append("leave")

    def close(self) -> None:
        self.calls.append("close")


@pytest.fixture
def recorder() -> Recorder:
    return Recorder()


@pytest.fixture
def app(recorder: Recorder) -> FastAPI:
    made = FastAPI()
    made.state.engine, made.state.at_end = recorder, [recorder.close]
    return made


def serve_until(app: FastAPI, folder: Path, when: Callable[[_Server], Any]) -> str | None:
    """Serve; ``when`` is told of the server as it begins. The signal that was heeded."""
    settings = Settings(data=folder, port=0)
    with handling_end_signals() as leaving, _listening(settings) as listener:
        server = _Server(app, settings, leaving)
        when(server)
        server.run(sockets=[listener])
        wish = leaving.asked()
    return wish.name if wish else None


def once_started(server: _Server, act: Callable[[int], Any]) -> None:
    """Let a thread act as soon as the server listens; it is told the port."""
    startup = server.startup

    async def announce(sockets: Any = None) -> None:
        await startup(sockets)
        threading.Thread(target=act, args=[sockets[0].getsockname()[1]], daemon=True).start()

    server.startup = announce  # type: ignore[method-assign]


@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGINT])
def test_signal__ends_the_server_as_it_listens_and_before(
    app: FastAPI, recorder: Recorder, tmp_path: Path, capsys: pytest.CaptureFixture[str], number: signal.Signals
) -> None:
    """Runs leave while connections close."""

    def signalled(_port: int = 0) -> None:
        os.kill(os.getpid(), number)

    assert serve_until(app, tmp_path, lambda _server: signalled()) == number.name
    assert recorder.calls == ["close"]
    assert "serves" not in capsys.readouterr().out
    assert serve_until(app, tmp_path, lambda server: once_started(server, signalled)) == number.name
    assert recorder.calls == ["close", "leave", "close"]


STUCK = (
    "import sys, threading; from concurrent.futures import ThreadPoolExecutor\n"
    "from contextlib import contextmanager; from pathlib import Path\n"
    "from fastapi import FastAPI\n"
    "from service.cli import serve; from service.settings import Settings\n"
    "from tests.service.cli.test_serve import Recorder\n"
    "@contextmanager\n"
    "def open_service(settings, start_engine):\n"
    "    app = FastAPI()\n"
    "    app.state.engine, app.state.at_end = Recorder(), []\n"
    "    yield app\n"
    "serve.open_service = open_service\n"
    "ThreadPoolExecutor(1).submit(threading.Event().wait)\n"
    "serve.serve(Settings(data=Path(sys.argv[1]), port=0))\n"
)


def test_signal__ends_the_process_though_a_thread_goes_on(tmp_path: Path) -> None:
    process = subprocess.Popen(
        [sys.executable, "-c", STUCK, str(tmp_path)], cwd=ROOT, stdout=subprocess.PIPE, text=True
    )
    try:
        assert process.stdout is not None
        assert process.stdout.readline().startswith("whipple serves")
        begin = time.monotonic()
        process.terminate()
        assert process.wait(DEADLINE) == 0
        assert time.monotonic() - begin < serve.EXIT_SECONDS
    finally:
        process.kill()
        process.communicate()


def test_peer__is_who_is_connected_whatever_it_says(app: FastAPI, tmp_path: Path) -> None:
    @app.get("/peer")
    def peer(request: Request) -> str:
        assert request.client is not None
        return request.client.host

    forged = {"X-Forwarded-For": "10.0.3.7", "X-Forwarded-Proto": "https"}
    seen: SimpleQueue[str] = SimpleQueue()

    def ask(port: int) -> None:
        try:
            seen.put(httpx.get(f"http://127.0.0.1:{port}/peer", headers=forged, timeout=DEADLINE).json())
        finally:
            os.kill(os.getpid(), signal.SIGTERM)

    serve_until(app, tmp_path, lambda server: once_started(server, ask))
    assert seen.get(timeout=DEADLINE) == "127.0.0.1"


def test_port__that_is_taken_is_refused_with_a_cure(tmp_path: Path) -> None:
    with _listening(Settings(data=tmp_path, port=0)) as first:
        taken = Settings(data=tmp_path, port=first.getsockname()[1])
        first.listen()
        with pytest.raises(InvalidInput, match="choose another port"):
            _listening(taken)
