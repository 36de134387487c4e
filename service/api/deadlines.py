"""Connections that send their requests in time, and make room where too many are open.

A request that is still arriving costs whoever sends it nothing, and the service one of the few
connections that may be open: five hundred half-sent heads made every answer a 503, for as long as they
stayed. So a head and a body each have a deadline, and where all connections are taken, the one whose
deadline is nearest makes room for a new one. What the event loop may compute to read one request is
bounded too, because nobody else is answered meanwhile.
"""

import asyncio
import time
from typing import Any

import h11
from uvicorn.protocols.http.h11_impl import H11Protocol

LONGEST_HEAD = 32 * 1024  # bytes of request line and headers; an address has a few hundred
HEAD_SECONDS = 10.0  # for a head; of a connection that is kept, from the end of the answer before
BODY_SECONDS = 120.0  # for a body: the longest one at 35 kB/s
PIECE = 16 * 1024  # bytes that are read between two looks at the clock
READING_SECONDS = 0.1  # of computing that reading a request may cost, beside what its bytes may:
READING_RATE = 10e6  # bytes/s; packets are read at 160e6, chunks of one byte at 1e6 (2026-11)


class DeadlineProtocol(H11Protocol):
    """A connection that is closed when a request has not arrived in time, or costs too much to read."""

    _deadline: asyncio.TimerHandle | None = None  # of what is arriving
    _arriving: Any = None  # state of h11 that the deadline belongs to
    _spent = 0.0  # s of computing on this request, beyond what its bytes may cost

    def connection_made(self, transport: asyncio.Transport) -> None:  # type: ignore[override] # as uvicorn's own
        super().connection_made(transport)
        self._set_deadline()
        self._make_room()

    def data_received(self, data: bytes) -> None:
        for place in range(0, len(data), PIECE):
            piece = data[place : place + PIECE]
            begin = time.thread_time()
            super().data_received(piece)
            self._set_deadline()
            seconds = time.thread_time() - begin
            self._spent = max(0.0, self._spent + seconds - len(piece) / READING_RATE)
            if self._spent > READING_SECONDS:
                self.transport.close()
            if self.transport.is_closing():
                return

    def on_response_complete(self) -> None:
        super().on_response_complete()
        self._set_deadline()

    def connection_lost(self, exc: Exception | None) -> None:
        self._forget_deadline()
        super().connection_lost(exc)

    def _set_deadline(self) -> None:
        """Begin the time of a head or a body; what has arrived whole has none."""
        state = self.conn.their_state
        if state is self._arriving or self.transport.is_closing():
            return
        self._forget_deadline()
        self._arriving = state
        if state is h11.IDLE:
            self._spent = 0.0
        seconds = {h11.IDLE: HEAD_SECONDS, h11.SEND_BODY: BODY_SECONDS}.get(state)
        if seconds is not None:
            self._deadline = self.loop.call_later(seconds, self.transport.close)

    def _forget_deadline(self) -> None:
        if self._deadline is not None:
            self._deadline.cancel()
            self._deadline = None

    def _make_room(self) -> None:
        """Where as many are open as may be, close the one whose deadline is nearest."""
        if self.limit_concurrency is None or len(self.connections) < self.limit_concurrency:
            return
        others = (one for one in self.connections - {self} if isinstance(one, DeadlineProtocol))
        arriving = {one: one._deadline.when() for one in others if one._deadline is not None}
        if arriving:
            nearest = min(arriving, key=arriving.__getitem__)
            nearest.transport.close()
            self.connections.discard(nearest)
