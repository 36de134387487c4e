"""Clients that send a head without end, half a head, a head piece by piece, or a body byte by byte, slowly and fast.

Another one asks meanwhile how long the service takes to say that it is alive.
"""

import socket
import threading
import time
from collections.abc import Iterator, Sequence
from contextlib import ExitStack, closing, contextmanager, suppress
from dataclasses import dataclass, field
from http.client import HTTPConnection, HTTPException
from itertools import pairwise

BLOCK = 1 << 20
HALF = b"GET /livez HTTP/1.1\r\nHost: 127.0.0.1\r\nX-Half: "
WHOLE = b"GET /livez HTTP/1.1\r\nHost: 127.0.0.1\r\nConnection: close\r\n\r\n"
BODY = b"POST /v1/sweeps HTTP/1.1\r\nHost: 127.0.0.1\r\nContent-Length: 1000000\r\n\r\n"
CHUNKED = BODY.replace(b"Content-Length: 1000000", b"Transfer-Encoding: chunked")
CHUNK = b"1\r\n \r\n"
PATIENCE_SECONDS = 30.0
PAUSE_SECONDS = 0.2
PROBE_PAUSE_SECONDS = 0.02


def send_header(port: int, size: int) -> int:
    """Send a header of so many bytes; how many were taken before the connection ended."""
    sent, block = 0, b"x" * BLOCK
    with connected(port) as client:
        client.sendall(HALF)
        try:
            while sent < size:
                client.sendall(block)
                sent += BLOCK
        except OSError:
            return sent
    return sent


def send_slowly(port: int, seconds: float, pieces: int = 8) -> bytes:
    """Send a head in pieces that take so long; the first line of the answer."""
    places = [len(WHOLE) * number // pieces for number in range(pieces + 1)]
    with connected(port) as client:
        for begin, end in pairwise(places):
            client.sendall(WHOLE[begin:end])
            time.sleep(seconds / pieces)
        return client.recv(BLOCK).partition(b"\r\n")[0]


def dribble(port: int, seconds: float) -> float:
    """Send a body byte by byte for at most so long; when the connection was ended."""
    begin = time.monotonic()
    with connected(port) as client:
        client.sendall(BODY)
        while (now := time.monotonic() - begin) < seconds:
            try:
                client.sendall(b" ")
            except OSError:
                return now
            time.sleep(PAUSE_SECONDS)
    return seconds


def send_chunks(port: int, count: int) -> None:
    """Send a body of so many chunks of one byte, until it is answered or the connection ended."""
    with connected(port) as client, suppress(OSError):
        client.sendall(CHUNKED + CHUNK * count + b"0\r\n\r\n")
        client.recv(1)


@contextmanager
def half_sent(port: int, count: int) -> Iterator[list[socket.socket]]:
    with ExitStack() as ends:
        clients = [ends.enter_context(connected(port)) for _ in range(count)]
        for client in clients:
            client.sendall(HALF)
        yield clients


@contextmanager
def pipelining(port: int, count: int, path: str) -> Iterator[list[socket.socket]]:
    """So many connections that send requests without end, as far as they are taken, and read nothing."""
    requests = f"GET {path} HTTP/1.1\r\nHost: 127.0.0.1\r\n\r\n".encode() * 1000
    with ExitStack() as ends:
        clients = [ends.enter_context(connected(port)) for _ in range(count)]
        for client in clients:
            client.setblocking(False)
            with suppress(OSError):  # taken in part, or refused
                client.send(requests)
        yield clients


def still_open(clients: Sequence[socket.socket], seconds: float) -> int:
    """How many connections the service has not ended after so long."""
    end, count = time.monotonic() + seconds, 0
    for client in clients:
        client.settimeout(max(0.001, end - time.monotonic()))
        try:
            count += client.recv(1) != b""
        except TimeoutError:
            count += 1
        except OSError:  # it was ended
            continue
    return count


def connected(port: int) -> socket.socket:
    return socket.create_connection(("127.0.0.1", port), timeout=PATIENCE_SECONDS)


@dataclass
class LivenessProbe:
    """What another client was answered, which asks ``/livez`` again and again, each time over a new connection."""

    slowest: float = 0.0  # s, of all answers
    statuses: list[int | str] = field(default_factory=list)  # of each answer, or the name of what was met instead


@contextmanager
def probing(port: int) -> Iterator[LivenessProbe]:
    """Ask until the end of the block, once at least."""
    probe, stopped = LivenessProbe(), threading.Event()

    def ask() -> None:
        while True:
            begin = time.monotonic()
            with closing(HTTPConnection("127.0.0.1", port, timeout=PATIENCE_SECONDS)) as connection:
                try:
                    connection.request("GET", "/livez")
                    probe.statuses.append(connection.getresponse().status)
                except (OSError, HTTPException) as error:
                    probe.statuses.append(type(error).__name__)
            probe.slowest = max(probe.slowest, time.monotonic() - begin)
            if stopped.wait(PROBE_PAUSE_SECONDS):
                return

    thread = threading.Thread(target=ask)
    thread.start()
    try:
        yield probe
    finally:
        stopped.set()
        thread.join()
