"""``whipple serve`` as a server: it listens, heeds signals from the first moment, and leaves in order."""

import os
import signal
import threading
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import pytest
from fastapi import FastAPI

from service.leaving import heeding
from service.serve import _listening, _Server
from service.settings import Settings
from studies.errors import InvalidInput


@dataclass
class Watched:
    """Stands in for the engine and for the event streams: remembers what it was told."""

    told: list[str] = field(default_factory=list)

    def leave(self) -> None:
        self.told.append("leave")

    def close(self) -> None:
        self.told.append("close")


@pytest.fixture
def watched() -> Watched:
    return Watched()


@pytest.fixture
def app(watched: Watched) -> FastAPI:
    made = FastAPI()
    made.state.engine = made.state.live = watched
    return made


def serve_until(app: FastAPI, folder: Path, when: Callable[[_Server], Any]) -> str | None:
    """Serve; ``when`` is told of the server as it begins. The signal that was heeded."""
    settings = Settings(data=folder, port=0)
    with heeding() as leaving, _listening(settings) as listener:
        server = _Server(app, settings, leaving)
        when(server)
        server.run(sockets=[listener])
        wish = leaving.asked()
    return wish.name if wish else None


@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGINT])
def test_signal__lets_runs_leave_while_connections_close(
    app: FastAPI, watched: Watched, tmp_path: Path, number: signal.Signals
) -> None:
    def soon(server: _Server) -> None:
        def ask() -> None:
            started.wait()
            os.kill(os.getpid(), number)

        started = threading.Event()
        startup = server.startup

        async def announce(sockets: Any = None) -> None:
            await startup(sockets)
            started.set()

        server.startup = announce  # type: ignore[method-assign]
        threading.Thread(target=ask, daemon=True).start()

    assert serve_until(app, tmp_path, soon) == number.name
    assert watched.told == ["leave", "close"]


def test_signal__that_came_before_the_server_is_heeded_too(
    app: FastAPI, watched: Watched, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    def at_once(_server: _Server) -> None:
        os.kill(os.getpid(), signal.SIGTERM)

    assert serve_until(app, tmp_path, at_once) == "SIGTERM"
    assert watched.told == ["close"]
    assert "serves" not in capsys.readouterr().out


def test_port__that_is_taken_is_refused_with_a_cure(tmp_path: Path) -> None:
    with _listening(Settings(data=tmp_path, port=0)) as first:
        taken = Settings(data=tmp_path, port=first.getsockname()[1])
        first.listen()
        with pytest.raises(InvalidInput, match="choose another port"):
            _listening(taken)
