"""Turns of requests: in rotation over callers, given back while a request waits, and refused where too many wait."""

import re
import socket
from collections.abc import AsyncIterator, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import ExitStack, asynccontextmanager, contextmanager
from pathlib import Path
from typing import Any

import anyio
import httpx
import pytest

from service.api import access
from service.api.access import Caller, KnownCallers
from service.api.browsers import BROWSER, FORM
from service.api.errors import TooManyRequests
from service.api.turns import MOST_READING, Places, Turn
from service.records.expansion import expand
from service.records.jobs import Scope, Submission
from studies.sweeps.sweep import Sweep
from tests.service.support.api import SWEEP, Api, ReadersHere, SameFile, every_route, open_api, served
from tests.service.support.fakes import DEADLINE, wait_until

OPEN_FORMS = {"/login", "/logout"}  # whose forms hold a key or the token, and are read without a key


class Asking:
    """Callers that ask for places one after the other, and keep them."""

    def __init__(self, shared: Places):
        self.places = shared
        self.served: list[str] = []
        self.refused: list[str] = []

    async def ask(self, caller: str) -> None:
        try:
            await self.places.acquire(caller)
        except TooManyRequests:
            self.refused.append(caller)
        else:
            self.served.append(caller)

    async def all(self, callers: Sequence[str]) -> None:
        """Ask, and ask no longer for what is not there at once."""
        async with anyio.create_task_group() as tasks:
            for caller in callers:
                tasks.start_soon(self.ask, caller)
                await anyio.wait_all_tasks_blocked()
            tasks.cancel_scope.cancel()


def test_places__of_a_caller_are_few_and_the_others_stay_free() -> None:
    asking = Asking(Places(4, 2))
    anyio.run(asking.all, [*["ann"] * 5, "bob", "cid", "dan"])
    assert asking.served == ["ann", "ann", "bob", "cid"]
    # Those that ask no longer get none.
    asking.places.release("ann")
    anyio.run(asking.all, ["dan"])
    assert asking.served[4:] == ["dan"]


@pytest.mark.parametrize("first", ["ann", ""])  # nobody's name is empty, but that of a user without a key
def test_places__go_to_waiting_callers_in_rotation(first: str) -> None:
    shared, order = Places(1, 1), []  # type: tuple[Places, list[str]]

    async def hold(caller: str) -> None:
        async with shared.place(caller):
            order.append(caller)
            await anyio.sleep(0)

    async def use() -> None:
        async with anyio.create_task_group() as tasks:
            for caller in (*[first] * 4, "bob", "cid", "bob"):
                tasks.start_soon(hold, caller)

    anyio.run(use)
    assert order == [first, first, "bob", "cid", first, "bob", first]


def test_places__that_too_many_wait_for_are_refused_to_the_caller_with_the_longest_queue() -> None:
    own = Asking(Places(1, 1, waiting_of_a_caller=2))
    anyio.run(own.all, [*["ann"] * 5, "bob"])
    assert own.refused == ["ann"] * 2
    all_together = Asking(Places(1, 1, waiting=4))
    anyio.run(all_together.all, [*["ann"] * 6, "bob", "cid", "dan"])
    assert all_together.refused == ["ann"] * 4  # the fifth and sixth; then bob and cid come in for two others


def test_turn__is_given_back_while_the_request_waits_and_after_its_response() -> None:
    shared = Asking(Places(1, 1))

    async def free() -> bool:
        with anyio.move_on_after(0.0):
            async with shared.places.place("bob"):
                return True
        return False

    async def use() -> None:
        turn = Turn(shared.places, "ann")
        await turn.take()
        assert not await free()
        async with turn.waiting():
            async with turn.waiting():
                assert await free()
            await turn.take()  # as for a body that has come
            assert await free()
        assert not await free()
        with pytest.raises(ZeroDivisionError):
            async with turn.waiting():
                raise ZeroDivisionError
        turn.end()
        await turn.take()
        assert await free()

    anyio.run(use)


def test_caller__is_known_by_its_key_once_that_was_valid_and_by_its_address_before() -> None:
    known = KnownCallers()

    def sent(key: str, address: str = "2001:db8::7") -> Any:
        headers = [(b"authorization", f"Bearer {key}".encode())]
        return {"type": "http", "headers": headers, "client": (address, 1), "server": ("::1", 2)}

    ann = Caller("ann", frozenset({Scope.READ}), "1")
    assert known.name_of(sent("a")) == known.name_of(sent("b", "2001:db8::8")) == "address 2001:0db8:0000:0000"
    known.remember(sent("a"), ann)
    known.remember(sent("b"), access.WITHOUT_KEY)
    assert known.name_of(sent("a")) == "key ann"
    assert known.name_of(sent("b")).startswith("address")
    for number in range(access.MOST_NAMES):
        known.remember(sent(str(number)), ann)
    assert known.name_of(sent("a")).startswith("address")
    known.forget(sent("5"))
    assert known.name_of(sent("5")).startswith("address")


# --- requests that wait -----------------------------------------------------------------------------


@pytest.fixture
def strict(tmp_path: Path) -> Iterator[tuple[Api, str, httpx.Client]]:
    """A service that asks for keys, its address, and a client with one."""
    with open_api(tmp_path, trust_loopback=False) as api:
        _, secret = api.store.keys.issue("ann", [Scope.READ])
        key = {"Authorization": f"Bearer {secret}"}
        with served(api) as url, httpx.Client(base_url=url, headers=key, timeout=DEADLINE) as client:
            yield api, url, client


@contextmanager
def half_sent(url: str, method: str, path: str, *headers: str) -> Iterator[socket.socket]:
    """A request with a form of which a byte is sent."""
    host = httpx.URL(url)
    lines = [f"{method} {path} HTTP/1.1", f"Host: {host.host}:{host.port}", f"Cookie: {BROWSER}=x", *headers]
    lines += [f"Content-Type: {FORM}", "Content-Length: 100"]
    with socket.create_connection((host.host, host.port), timeout=DEADLINE) as connection:
        connection.sendall("\r\n".join([*lines, "", "x"]).encode())
        yield connection


def test_body__of_a_sender_without_a_key_is_never_waited_for(strict: tuple[Api, str, httpx.Client]) -> None:
    _, url, client = strict
    routes = [*every_route()]
    for route in routes:
        path = re.sub(r"\{.*?\}", "a", route.path)
        for method in sorted({*(route.methods or ()), "HEAD", "OPTIONS"} - ({"POST"} if path in OPEN_FORMS else set())):
            with half_sent(url, method, path) as connection:
                assert connection.recv(1 << 16).startswith(b"HTTP/1.1 "), (method, path)
    assert len(routes) > 30
    # The framework itself reads a body before anybody is authenticated.
    assert not [route.path for route in routes if route.body_field]
    assert client.get("/v1/sweeps").status_code == 200


@pytest.mark.parametrize(("method", "path"), [("GET", "/v1/sweeps"), ("POST", "/login"), ("POST", "/v1/sweeps")])
def test_half_sent_requests__leave_the_others_their_turns(
    strict: tuple[Api, str, httpx.Client], method: str, path: str
) -> None:
    _, url, client = strict
    with ExitStack() as connections:
        for _ in range(MOST_READING + 4):
            connections.enter_context(half_sent(url, method, path))
            connections.enter_context(half_sent(url, method, path, f"Authorization: {client.headers['authorization']}"))
        assert client.get("/v1/sweeps", timeout=5.0).status_code == 200


class Gate:
    """What requests wait at until the end of a test."""

    def __init__(self) -> None:
        self.waiting, self.is_open = 0, False

    async def passed(self) -> None:
        self.waiting += 1
        while not self.is_open:
            await anyio.sleep(0.005)


class BusyReaders(ReadersHere):
    """Children of which none is free."""

    def __init__(self, gate: Gate) -> None:
        super().__init__()
        self._gate = gate

    @asynccontextmanager
    async def slot(self, key: str) -> AsyncIterator[None]:
        await self._gate.passed()
        raise TooManyRequests("no child is free")
        yield


class BusyConversions(SameFile):
    """Files of which none is made."""

    def __init__(self, folder: Path, gate: Gate) -> None:
        super().__init__(folder)
        self._gate = gate

    async def _run_child(self, file: Path, inputs: str) -> None:
        await self._gate.passed()
        await super()._run_child(file, inputs)


def test_requests__that_wait_for_a_child_leave_the_others_their_turns(strict: tuple[Api, str, httpx.Client]) -> None:
    check_that_waiting_leaves_turns(*strict, "/v1/sweeps/ID/cube.nc?partial=true")


def check_that_waiting_leaves_turns(api: Api, url: str, client: httpx.Client, path: str) -> None:
    """Requests for a path, which wait for a child process, leave others their turns."""
    gate, state = Gate(), api.http.app.state  # type: ignore[attr-defined]
    state.readers, state.conversions = BusyReaders(gate), BusyConversions(api.settings.data / "cache", gate)
    _, secret = api.store.keys.issue("bob", [Scope.SUBMIT])
    if "ID" in path:
        path = path.replace("ID", with_a_result(api))
    with (
        httpx.Client(base_url=url, headers={"Authorization": f"Bearer {secret}"}, timeout=DEADLINE) as others,
        ThreadPoolExecutor(MOST_READING + 4) as senders,
    ):
        try:
            for _ in range(MOST_READING + 4):
                senders.submit(others.get, path)
            wait_until(lambda: gate.waiting)
            assert client.get("/v1/sweeps", timeout=5.0).status_code == 200
        finally:
            gate.is_open = True


def with_a_result(api: Api) -> str:
    """A sweep of which a run has ended."""
    id = api.store.sweeps.create(Submission(expand(Sweep.parse(SWEEP), lambda _: 1.0))).id
    [lease, *_] = api.store.leases.take(2, api.term())
    api.store.leases.finish(lease, api.result(lease.id))
    return id
