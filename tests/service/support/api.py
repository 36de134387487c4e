"""A service without engine for tests: real store, real interface, and results by hand."""

import hashlib
import json
import socket
import threading
from collections.abc import AsyncIterator, Callable, Iterator
from contextlib import asynccontextmanager, contextmanager
from dataclasses import asdict, dataclass
from io import BytesIO
from pathlib import Path
from typing import Any
from zipfile import ZipFile

import uvicorn
from fastapi.routing import APIRoute
from fastapi.testclient import TestClient

from service.api.app import open_service
from service.api.readers import Readers
from service.api.reading import Given, Made
from service.api.routes import all_routes
from service.conversions.conversions import Conversions
from service.queue.dispatcher import Dispatcher
from service.records.jobs import Cause, Kind, Result, Stored
from service.settings import Settings
from service.store import Store
from studies.reports.cover import ABOUT, DRAWINGS, Cover
from tests.service.support.fakes import put_empty_store, wait_until

ADDRESS = "http://127.0.0.1:8000"
SWEEP: dict[str, Any] = {
    "name": "two-speeds",
    "scenario": "thin_plate",
    "fixed": {
        "projectile": "copper-ofhc",
        "target": "copper-ofhc",
        "projectile_diameter": "8 mm",
        "plate_thickness": "2 mm",
    },
    "axes": {"speed": ["3 km/s", "6 km/s"]},
    "resolution": 8,
}
FILES = {
    "cube.nc": b"\x89HDF not really",
    "report.html": b'<!doctype html><title>report</title><a href="appendix.html" target="_blank">Appendix</a>',
    "appendix.html": b"<!doctype html><title>appendix</title>",
    "runs.csv": b"run_id\n",
    "report.json": b'{"report_version": 1, "title": "Copper plates", "headline": "Use the law; simulation only."}',
}
HEADLINE = "Use the law; simulation only."
SVG = b'<svg xmlns="http://www.w3.org/2000/svg"/>'


def cover() -> bytes:
    """The cover of a report with all of its drawings."""
    content = BytesIO()
    with ZipFile(content, "w") as archive:
        about = Cover(HEADLINE, "Hole diameter against speed", "Laws are lines.", "speed 6 km/s", DRAWINGS)
        archive.writestr(ABOUT, json.dumps(asdict(about)))
        for name in DRAWINGS:
            archive.writestr(name, SVG)
    return content.getvalue()


ALL_RUNS = {"runs-all.csv": b"run_id,solver_seconds [s]\n"}  # offered in place of runs.csv
COVERS = {"cover.zip": cover()}  # what pages show


def sweep_of(**changes: Any) -> dict[str, Any]:
    """The sweep of the tests with some of its words changed."""
    return {**SWEEP, **changes}


# Sweeps of few bytes and nearly ten thousand runs.
LARGE_SWEEPS = {
    "a grid of 999 x 10": sweep_of(
        axes={
            "speed": {"start": "1000 m/s", "stop": "10980 m/s", "step": "10 m/s"},
            "cells_per_diameter": [*range(8, 18)],
        },
        resolution=None,
    ),
    "8 192 points of Sobol": sweep_of(
        axes={"speed": {"low": "4 km/s", "high": "8 km/s"}}, combine="sobol", points=8192, seed=1
    ),
}


def every_route() -> Iterator[APIRoute]:
    """The routes of the interface, those of features among them."""
    for routes in all_routes():
        for router in (*routes.open, *routes.guarded):
            yield from (route for route in router.routes if isinstance(route, APIRoute))


@dataclass
class FakeDispatcher(Dispatcher):
    """Computes nothing; says what it is told to say."""

    reason: str | None = None
    slots: int | None = 2
    refused: bool = False

    def is_alive(self) -> bool:
        return True

    def leads(self) -> bool:
        return self.slots is not None

    def blocked_reason(self) -> str | None:
        return self.reason

    def is_refused(self) -> bool:
        return self.refused

    def workers(self) -> int | None:
        return self.slots


class ReadersHere(Readers):
    """Reads sweeps in this process: the children of a ``TestClient`` would begin anew with each event loop."""

    @asynccontextmanager
    async def slot(self, key: str) -> AsyncIterator[None]:
        yield

    async def run(self, call: Callable[[*Given], Made], *given: *Given) -> Made:
        return call(*given)


class SameFile(Conversions):
    """Gives the same file for everything: the results of these tests are empty."""

    async def _run_child(self, file: Path, inputs: str) -> None:
        file.write_text("{}")


@dataclass(frozen=True)
class Api:
    """The interface, and what is behind it."""

    http: TestClient
    store: Store
    settings: Settings
    engine: FakeDispatcher

    def term(self) -> int:
        """A new reign, of the tests."""
        return self.store.terms.begin("tests")

    def submit(self, **changes: Any) -> str:
        response = self.http.post("/v1/sweeps", json=sweep_of(**changes))
        assert response.status_code == 202, response.text
        return response.json()["id"]

    def compute(self, *, failures: int = 0) -> None:
        """Do what is in the queue: runs end well, the first few fail, publications are made."""
        term = self.term()
        while claims := self.store.leases.take(100, term):
            for claim in claims:
                if claim.kind is Kind.PUBLISH:
                    self.store.leases.publish(claim, self._files(claim.id), seconds=0.1, headline=HEADLINE)
                elif failures > 0:
                    failures -= 1
                    arguments = "density = 3e4 at particle 17 of 'target'"
                    self.store.leases.fail(claim, Cause.ERROR, failure="ValueError", reason=arguments)
                else:
                    self.store.leases.finish(claim, self.result(claim.id))

    def _files(self, name: str) -> list[Stored]:
        return [self._stored(f"{name}/{file}", content) for file, content in {**FILES, **ALL_RUNS, **COVERS}.items()]

    def result(self, name: str) -> Result:
        numbers: dict[str, Any] = {"hole_diameter": {"value": 0.0148, "uncertainty": None, "flags": []}}
        return Result(
            files=(self._stored(f"{name}/result.json", b"{}"),),
            succeeded=True,
            reason=None,
            failure=None,
            summary={"measurements": numbers},
            seconds=1.0,
        )

    def _stored(self, path: str, content: bytes) -> Stored:
        file = self.settings.data / path
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_bytes(content)
        digest = hashlib.sha256(content).hexdigest()
        return Stored(name=file.name, path=path, size=len(content), sha256=digest)


@contextmanager
def open_api(folder: Path, **settings: Any) -> Iterator[Api]:
    """A service without engine, its data in a folder."""
    engine = FakeDispatcher()

    @contextmanager
    def start(settings: Settings, store: Store) -> Iterator[FakeDispatcher]:
        yield engine

    chosen = Settings(data=folder, workers=2, **settings)
    if chosen.database_url is None:
        put_empty_store(folder)
    with open_service(chosen, start) as app:
        app.state.readers = ReadersHere()
        # Entered, its requests share an event loop, as those of a server do.
        with TestClient(app, base_url=ADDRESS, raise_server_exceptions=False) as http:
            yield Api(http, app.state.store, chosen, engine)


@contextmanager
def served(api: Api, *doors: socket.socket, **options: Any) -> Iterator[str]:
    """The same interface over a real connection, and at further sockets; ``options`` of uvicorn; gives its address."""
    config = uvicorn.Config(api.http.app, lifespan="off", log_level="critical", **options)
    server = uvicorn.Server(config)
    thread = threading.Thread(target=server.run, args=[[socket.create_server(("127.0.0.1", 0)), *doors]])
    thread.start()
    try:
        wait_until(lambda: server.started)
        yield f"http://127.0.0.1:{server.servers[0].sockets[0].getsockname()[1]}"
    finally:
        for end in api.http.app.state.at_end:  # type: ignore[attr-defined]
            end()
        server.should_exit = True
        thread.join()
