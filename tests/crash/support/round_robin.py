"""A proxy that gives each connection to the next of several services that takes it, as one before replicas does."""

import asyncio
import threading
from collections import Counter
from collections.abc import Iterator, Sequence
from contextlib import contextmanager, suppress
from itertools import cycle

from tests.service.support.cluster import free_port

BLOCK = 1 << 16


class RoundRobin:
    """Its address, how many connections each port took, and how often one refused."""

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
