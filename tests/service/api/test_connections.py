"""When all connections are taken, one that sends nothing makes room for the next."""

import socket
from contextlib import ExitStack

import httpx

from service.api.middleware import DeadlineProtocol
from tests.service.support.api import Api, served

HALF = b"GET /livez HTTP/1.1\r\nHost: 127.0.0.1\r\nX-Half: "


def test_connection__whose_deadline_is_nearest_makes_room(shared_api: Api) -> None:
    with served(shared_api, http=DeadlineProtocol, limit_concurrency=3) as url, ExitStack() as ends:
        place = httpx.URL(url)
        waiting = []
        for _ in range(2):
            waiting.append(ends.enter_context(socket.create_connection((place.host, place.port or 0), timeout=20.0)))
            waiting[-1].sendall(HALF)
            # Its deadline begins before that of the next one; after the second, room is made.
            assert httpx.get(f"{url}/livez").status_code == 200
        first, second = waiting
        assert first.recv(1) == b""
        second.sendall(b"x\r\nConnection: close\r\n\r\n")
        assert second.recv(1 << 10).startswith(b"HTTP/1.1 200")
