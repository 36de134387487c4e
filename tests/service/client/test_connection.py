"""The client when the connection breaks: what is sent again, what is told at once, and streams taken up again."""

import json
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import httpx
import pytest
import xarray as xr

import whipple
from service.client import connection
from service.client.client import Client, ServiceError, SweepHandle, Unreachable
from service.records.jobs import Scope
from studies.cubes.variables import SCHEMA_VERSION
from studies.quantities.files import SWEEP_FILES
from tests.service.support.api import FILES, SWEEP, Api, sweep_of

Answer = httpx.Response | Exception
DEADLINE = 60.0
ITEMS: dict[str, Any] = {"items": []}


@pytest.fixture(autouse=True)
def _quick(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(connection, "FIRST_PAUSE", 0.001)
    monkeypatch.setattr(connection, "LONGEST_PAUSE", 0.01)


class Flaky(httpx.BaseTransport):
    """Passes requests on to a service; before or behind some of them the connection breaks."""

    def __init__(self, url: str, *faults: str):
        self._there = httpx.HTTPTransport()
        self._faults = list(faults)
        self.sent: list[httpx.Request] = []

    def handle_request(self, request: httpx.Request) -> httpx.Response:
        self.sent.append(request)
        fault = self._faults.pop(0) if self._faults else ""
        if fault == "before":
            raise httpx.ConnectError("refused")
        response = self._there.handle_request(request)
        if fault == "behind":
            response.read()
            response.close()
            raise httpx.ReadError("reset")
        return response


def scripted(*answers: Answer) -> tuple[Client, list[httpx.Request]]:
    """A client of a service that answers as said, one request after the other."""
    left, sent = list(answers), list[httpx.Request]()

    def answer(request: httpx.Request) -> httpx.Response:
        sent.append(request)
        item = left.pop(0)
        if isinstance(item, Exception):
            raise item
        return item

    return Client(transport=httpx.MockTransport(answer), patience=5.0), sent


def problem(status: int, **headers: str) -> httpx.Response:
    body = {"title": "Database unavailable", "detail": "locked", "status": status}
    kind = {"content-type": "application/problem+json", **headers}
    return httpx.Response(status, content=json.dumps(body), headers=kind)


def test_submission__whose_answer_was_lost_is_accepted_once(shared_api: Api, url: str) -> None:
    before = len(shared_api.store.sweeps.page(limit=1000).items)
    transport = Flaky(url, "behind", "behind")
    with Client(url, transport=transport) as client:
        handle = client.submit(sweep_of(name="sent three times"))
    assert len(transport.sent) == 3
    assert len({request.headers["Idempotency-Key"] for request in transport.sent}) == 1
    assert len(shared_api.store.sweeps.page(limit=1000).items) == before + 1
    assert shared_api.store.sweeps.get(handle.id).name == "sent three times"


def test_delete__whose_answer_was_lost_is_done(shared_api: Api, url: str) -> None:
    with Client(url, transport=Flaky(url, "", "", "behind")) as client:
        handle = client.submit(sweep_of(name="to go", axes={"speed": ["7.1 km/s"]}))
        handle.cancel()
        handle.delete()
        with pytest.raises(ServiceError, match="Not found"):
            handle.delete()


@pytest.mark.parametrize("failure", [httpx.ConnectError("refused"), problem(503, **{"retry-after": "0"})])
def test_service__that_comes_back_is_waited_for(failure: Answer) -> None:
    client, sent = scripted(httpx.Response(200, json=ITEMS), failure, failure, httpx.Response(200, json=ITEMS))
    for _ in range(2):
        assert client.laws() == []
    assert len(sent) == 4


def test_service__that_does_not_come_back_is_given_up_in_time() -> None:
    gone: list[Answer] = [httpx.ConnectError("refused")] * 10_000
    answers: list[Answer] = [httpx.Response(200, json=ITEMS), *gone]
    client, sent = scripted(*answers)
    client._connection._patience = 1.0
    client.laws()
    begin = time.monotonic()
    with pytest.raises(Unreachable, match="whipple serve"):
        client.laws()
    assert time.monotonic() - begin < DEADLINE
    assert len(sent) > 3


def test_address__that_never_answered_is_told_at_once() -> None:
    client, sent = scripted(httpx.ConnectError("refused"))
    with pytest.raises(Unreachable):
        client.submit(SWEEP)
    assert len(sent) == 1


@pytest.mark.parametrize("status", [400, 401, 403, 404, 409, 422, 500])
def test_refusal__is_not_asked_again(status: int) -> None:
    client, sent = scripted(problem(status))
    with pytest.raises(ServiceError):
        client.laws()
    assert len(sent) == 1


def test_download__that_breaks_off_begins_again(shared_api: Api, url: str, tmp_path: Path) -> None:
    with Client(url) as client:
        id = client.submit(sweep_of(name="fetched")).id
    shared_api.compute()
    with Client(url, transport=Flaky(url, "behind", "", "behind")) as client:
        folder = client.sweep(id).fetch(tmp_path)
    assert {file.name for file in folder.iterdir()} == set(SWEEP_FILES)


class Torn(httpx.SyncByteStream):
    """A stream that breaks off, or ends, behind some of its bytes."""

    def __init__(self, content: bytes, error: Exception | None):
        self._content, self._error = content, error

    def __iter__(self) -> Iterator[bytes]:
        yield self._content
        if self._error is not None:
            raise self._error


def event(number: int) -> bytes:
    return f'id: {number}\ndata: {{"number": {number}}}\n\n'.encode()


def test_stream__that_breaks_is_taken_up_where_it_was() -> None:
    def stream(content: bytes, error: Exception | None = None) -> httpx.Response:
        return httpx.Response(200, stream=Torn(content, error))

    half = b'id: 3\ndata: {"num'
    client, sent = scripted(
        stream(b"retry: 1\n\n" + event(1) + event(2) + half, httpx.ReadError("reset")),
        httpx.ConnectError("refused"),
        problem(503),
        stream(event(3)),  # closed in order, as a service does that leaves
        stream(event(4) + b'event: end\ndata: {"state": "succeeded"}\n\n'),
    )
    result = list(client.sweep("x").events())
    assert [item.number for item in result] == [1, 2, 3, 4, None]
    assert [request.headers.get("Last-Event-ID") for request in sent] == [None, "2", "2", "2", "3"]


@pytest.fixture
def published(shared_api: Api, url: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[SweepHandle]:
    cube = xr.Dataset({"hole_diameter": ("speed", [0.1, 0.2])}, {"speed": [3e3, 6e3]})
    cube.attrs = {"quantities": "hole_diameter", "sweep": "{}", "schema_version": SCHEMA_VERSION}
    xr.DataTree.from_dict({"/": cube, "/runs": None}).to_netcdf(tmp_path / "cube.nc", engine="netcdf4")
    (name,) = (each for each in FILES if each.endswith("cube.nc"))
    monkeypatch.setitem(FILES, name, (tmp_path / "cube.nc").read_bytes())
    with Client(url) as client:
        handle = client.submit(sweep_of(name="with a cube"))
        shared_api.compute()
        yield handle


def test_open_cube__reads_a_value_and_gives_the_connection_back(published: SweepHandle) -> None:
    with published.open_cube() as cube:
        assert cube.hole_diameter.sel(speed=6e3).item() == 0.2


def test_open_cube__sends_the_key(shared_api: Api, published: SweepHandle, monkeypatch: pytest.MonkeyPatch) -> None:
    _, secret = shared_api.store.keys.issue("anna", [Scope.READ])
    monkeypatch.setattr(published._connection, "headers", {"Authorization": "Bearer whp_wrong"})
    with pytest.raises(FileNotFoundError):
        published.open_cube()
    right = {"Authorization": f"Bearer {secret}"}
    monkeypatch.setattr(published._connection, "headers", right)
    with published.open_cube() as cube:
        assert cube.sizes == {"speed": 2}


def test_open_cube__sends_the_key_to_the_own_service_alone(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("WHIPPLE_SERVICE", "https://a.org/")
    monkeypatch.setenv("WHIPPLE_API_KEY", "whp_secret")
    monkeypatch.setattr("service.client.client.open_remote", lambda _address, headers: headers)
    for service, is_sent in (("http://[::1]:1", True), ("https://a.org", True), ("https://a.org.net", False)):
        assert bool(whipple.open_cube(f"{service}/v1/cube.nc")) == is_sent
