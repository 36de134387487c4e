"""Two services behind a proxy are restarted one after the other, and no request of their clients fails."""

import asyncio
import threading
from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import ExitStack, contextmanager, suppress
from dataclasses import dataclass, field, replace
from functools import partial
from itertools import cycle
from pathlib import Path
from typing import Any

import httpx
import pytest

from service.client.client import Client
from tests.claims.marked import Compared
from tests.claims.rows import Row, at_least, equal
from tests.service.support import inspection
from tests.service.support.crash_test import CrashTest, Work, crash_test
from tests.service.support.processes import free_port
from tests.service.support.serving import Service

WORK = Work(speeds=2, sweeps=1)
ROUNDS = 2  # restarts of each service
PAUSE = 1.5  # s, between two sweeps of a client: about as long as the two runs that are new take, and a publication
LOOKERS, LOOK_PAUSE = 3, 0.02
BLOCK = 1 << 16  # bytes that the proxy carries at a time


class Counted(httpx.HTTPTransport):
    """Counts the statuses of responses, and the errors in place of one."""

    def __init__(self, met: Counter[str]):
        super().__init__()
        self._met = met

    def handle_request(self, request: httpx.Request) -> httpx.Response:
        try:
            response = super().handle_request(request)
        except httpx.TransportError as error:
            self._met[type(error).__name__] += 1
            raise
        self._met[str(response.status_code)] += 1
        return response


@dataclass
class Clients:
    """People at the same address: one who submits, others who look, and a stream of events of each sweep."""

    url: str
    ids: list[str] = field(default_factory=list)  # of sweeps, in the order of submission
    streams: dict[str, list[int]] = field(default_factory=dict)  # numbers of events, by sweep
    met: Counter[str] = field(default_factory=Counter)  # responses by status, and broken connections
    failed: list[str] = field(default_factory=list)  # calls that raised
    over: threading.Event = field(default_factory=threading.Event)

    def submit(self) -> None:
        """Submit a sweep after another, and follow each."""
        with ThreadPoolExecutor(100) as followers, self._client() as client:
            while not self.over.is_set():
                document = replace(WORK, sweeps=len(self.ids) + 1).documents()[-1]
                sweep = self._call(partial(client.submit, document))
                if sweep is None:
                    return
                self.ids.append(sweep.id)
                followers.submit(self._call, partial(self._follow, sweep.id))
                self.over.wait(PAUSE)

    def look(self) -> None:
        """Look at the newest sweep, and at the list."""
        with self._client() as client:
            while not self.over.wait(LOOK_PAUSE):
                for id in self.ids[-1:]:
                    self._call(client.sweep(id).status)
                self._call(partial(next, client.sweeps(), None))

    def _follow(self, id: str) -> None:
        with self._client() as client:
            self.streams[id] = [event.number for event in client.sweep(id).events() if event.number is not None]

    def _client(self) -> Client:
        return Client(self.url, transport=Counted(self.met))

    def _call(self, act: Callable[[], Any]) -> Any:
        try:
            return act()
        except Exception as error:
            self.failed.append(f"{type(error).__name__}: {error}")
            return None


@pytest.mark.claim("doors", "rolling-restart", minutes=2.0)
def test_services__restarted_one_after_the_other_fail_no_request(
    tmp_path: Path, postgresql_url: str, compared: Compared
) -> None:
    """Two services behind a proxy that are restarted in turn fail no request, lose no event, compute no run twice."""
    with ExitStack() as ends:
        here = ends.enter_context(crash_test(WORK, tmp_path, database_url=postgresql_url, count=2))
        [*_] = map(Service.wait_until_ready, here.services)
        proxy = ends.enter_context(round_robin([service.port for service in here.services]))
        clients = Clients(proxy.url)
        with ThreadPoolExecutor() as people:
            people.submit(clients.submit)
            for _ in range(LOOKERS):
                people.submit(clients.look)
            try:
                statuses = [_restart(here, service) for _ in range(ROUNDS) for service in here.services]
            finally:
                clients.over.set()
                here.wait_for_the_end(clients.ids)

        compared(equal("exit statuses of restarts", expected=[0] * 2 * ROUNDS, got=statuses))
        compared(Row(f"responses and broken connections of {len(clients.ids)} sweeps", "", dict(clients.met), None))
        compared(at_least("connections that a stopped service refused", limit=1, got=proxy.refused))
        compared(equal("services that took connections", expected=2, got=len(proxy.taken)))
        compared(equal("calls that failed", expected=[], got=clients.failed))
        compared(equal("event streams with a gap or a repetition", expected=[], got=_uneven(here, clients)))
        work = replace(WORK, sweeps=len(clients.ids))
        compared(*here.rows_of_results(clients.ids, tmp_path / "first", work))
        logs = here.artifacts.root.glob("runs/*/*/*/log.txt")
        begun = Counter(log.parents[1].name for log in logs if "begins at step 0" in log.read_text())
        twice = [id for id, times in begun.items() if times > 1]
        compared(equal("runs that began twice at their start", expected=[], got=twice))
        compared(inspection.row_of_checkpoints(here.store, here.artifacts, clients.ids))
        here.services[0].leave()
        first = [tmp_path / "first" / id / "cube.nc" for id in clients.ids]
        compared(*inspection.rows_of_cubes(first, here.fetch(clients.ids, tmp_path / "other")))


def _restart(here: CrashTest, service: Service) -> int:
    """Stop a service while runs are under way, and start it again; its exit status."""
    here.wait_until_computing()
    status = service.leave()
    service.start()
    service.wait_until_ready()
    return status


def _uneven(here: CrashTest, clients: Clients) -> list[str]:
    """Sweeps whose stream is not what the store has of them."""
    return [
        id
        for id in clients.ids
        if clients.streams.get(id) != [event.number for event in here.store.events.of_sweep(id)]
    ]


# --- a proxy before both -----------------------------------------------------------------------------


class RoundRobin:
    """A proxy that gives each connection to the next of several services that takes it.

    Its address, how many connections each port took, and how often one refused.
    """

    def __init__(self, ports: Sequence[int]):
        self.url = f"http://127.0.0.1:{(port := free_port())}"
        self.port = port
        self.taken, self.refused = Counter[int](), 0
        self._ports, self._turn = len(ports), cycle(ports)

    async def serve(self, reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        """Carry one connection, until either side ends it."""
        for port in (next(self._turn) for _ in range(self._ports)):
            try:
                there_reader, there_writer = await asyncio.open_connection("127.0.0.1", port)
            except OSError:
                self.refused += 1
                continue
            self.taken[port] += 1
            await asyncio.gather(_carry(reader, there_writer), _carry(there_reader, writer))
            return
        writer.close()


async def _carry(reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
    with suppress(OSError):
        while block := await reader.read(BLOCK):
            writer.write(block)
            await writer.drain()
    writer.close()


@contextmanager
def round_robin(ports: Sequence[int]) -> Iterator[RoundRobin]:
    """A proxy of these ports, until the end of the block."""
    proxy, loop = RoundRobin(ports), asyncio.new_event_loop()
    thread = threading.Thread(target=loop.run_forever)
    thread.start()
    serving = asyncio.run_coroutine_threadsafe(asyncio.start_server(proxy.serve, "127.0.0.1", proxy.port), loop)
    try:
        serving.result()
        yield proxy
    finally:
        loop.call_soon_threadsafe(loop.stop)
        thread.join()
