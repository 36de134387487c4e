"""Turns: which requests compute now, so that no caller keeps the others waiting.

A request holds a turn while it computes, and gives it back while it waits for its client, a child process, a lock or a
bucket. What has to wait in a thread has threads of its own (``in_waiting_thread``), so that those of the
event loop stay free.
"""

import math
from collections import Counter, deque
from collections.abc import AsyncIterator, Callable, Iterator
from contextlib import asynccontextmanager
from typing import ParamSpec, TypeVar

from anyio import CapacityLimiter, Event, fail_after, to_thread
from starlette.requests import Request
from starlette.types import ASGIApp, Message, Receive, Scope, Send

from service.api.access import KnownCallers
from service.api.errors import TooManyRequests, problem_response

# Requests that compute at once, those of an owner or an address among them: each takes the event loop 1 ms (2026-11),
# and a probe waits for all of them. Together with the waiting threads they are fewer than the 40 of the event loop.
MOST_READING, MOST_READING_OF_A_CALLER = 16, 2
MOST_WRITING, MOST_WRITING_OF_A_CALLER = 8, 2
# Requests that wait for their turn: fewer than connections, so that a probe finds one.
MOST_WAITING, MOST_WAITING_OF_A_CALLER = 256, 128
MOST_THREADS, MOST_THREADS_OF_A_CALLER = 8, 4  # that wait for a bucket or a lock
READING = frozenset({"GET", "HEAD"})
PROBES = frozenset({"/livez", "/readyz"})  # monitors request them every few seconds, and their answers cost nothing
Given = ParamSpec("Given")
Answer = TypeVar("Answer")


class _Waiter:
    """A request that waits for a place, until it has one or is refused."""

    def __init__(self) -> None:
        self.ended = Event()
        self.has_place = False


class Places:
    """Places that callers share: each has a few at most, and callers that wait get free ones in rotation.

    Used in one event loop.
    """

    def __init__(
        self,
        most: int,
        of_a_caller: int,
        *,
        waiting: int = MOST_WAITING,
        waiting_of_a_caller: int = MOST_WAITING_OF_A_CALLER,
    ):
        self._most, self._of_a_caller = most, of_a_caller
        self._most_waiting, self._waiting_of_a_caller = waiting, waiting_of_a_caller
        self._held = Counter[str]()
        self._waiting: dict[str, deque[_Waiter]] = {}  # callers in the order of their next places

    async def acquire(self, caller: str) -> None:
        """Wait for a place; raises TooManyRequests, also while waiting, where too many wait already."""
        if self._has_place_for(caller) and caller not in self._waiting:
            self._held[caller] += 1
            return
        self._make_room(caller)
        waiter = _Waiter()
        self._waiting.setdefault(caller, deque()).append(waiter)
        try:
            await waiter.ended.wait()
        except BaseException:
            if waiter.has_place:
                self.release(caller)
            else:
                self._remove(caller, waiter)
            raise
        if not waiter.has_place:
            raise TooManyRequests("too many requests wait already, most of them of this caller; send this one again")

    def release(self, caller: str) -> None:
        """Give a place back, and give free ones to those that wait."""
        self._held[caller] -= 1
        if not self._held[caller]:
            del self._held[caller]
        while (following := next(filter(self._has_place_for, self._waiting), None)) is not None:
            queue = self._waiting.pop(following)
            waiter = queue.popleft()
            if queue:
                self._waiting[following] = queue  # the last in the rotation
            self._held[following] += 1
            waiter.has_place = True
            waiter.ended.set()

    @asynccontextmanager
    async def place(self, caller: str, *, within: float = math.inf, late: str = "") -> AsyncIterator[None]:
        """A place for the duration of a block.

        Raises TooManyRequests, of the text ``late`` where none is free within so many seconds.
        """
        try:
            with fail_after(within):
                await self.acquire(caller)
        except TimeoutError:
            raise TooManyRequests(late) from None
        try:
            yield
        finally:
            self.release(caller)

    def _has_place_for(self, caller: str) -> bool:
        return self._held.total() < self._most and self._held[caller] < self._of_a_caller

    def _make_room(self, caller: str) -> None:
        """Refuse the last request of the caller with the longest queue where all together are too long."""
        own = len(self._waiting.get(caller, ()))
        if own >= self._waiting_of_a_caller:
            raise TooManyRequests(f"{own} requests of this caller wait already; send this one again")
        if sum(map(len, self._waiting.values())) < self._most_waiting:
            return
        longest = max(self._waiting, key=lambda waiting: len(self._waiting[waiting]))
        if len(self._waiting[longest]) <= own + 1:
            raise TooManyRequests(f"{self._most_waiting} requests wait already; send this one again")
        waiter = self._waiting[longest][-1]
        self._remove(longest, waiter)
        waiter.ended.set()

    def _remove(self, caller: str, waiter: _Waiter) -> None:
        queue = self._waiting.get(caller)
        if queue and waiter in queue:
            queue.remove(waiter)
            if not queue:
                del self._waiting[caller]


class Turn:
    """The turn of one request: held while it computes, until its response begins.

    ``caller`` is the owner of its key or its address, among which places are shared.
    """

    def __init__(self, places: Places, caller: str):
        self._places, self.caller = places, caller
        self._is_held = self._is_over = False
        self._waits = 0  # blocks within which it waits

    async def take(self) -> None:
        """Wait for the turn, unless the request waits for something else or has a response; raises TooManyRequests."""
        if not (self._is_held or self._is_over or self._waits):
            await self._places.acquire(self.caller)
            self._is_held = True

    def give_back(self) -> None:
        if self._is_held:
            self._is_held = False
            self._places.release(self.caller)

    def end(self) -> None:
        self._is_over = True
        self.give_back()

    @asynccontextmanager
    async def waiting(self) -> AsyncIterator[None]:
        """A block without the turn, which is taken again afterwards; raises TooManyRequests."""
        self.give_back()
        self._waits += 1
        try:
            yield
        finally:
            self._waits -= 1
        await self.take()


def turn_of(request: Request) -> Turn:
    """The turn of a request."""
    turn: Turn = request.state.turn
    return turn


class WaitingThreads:
    """Threads for what waits for a bucket or a lock, apart from those that compute."""

    def __init__(self) -> None:
        self._places = Places(MOST_THREADS, MOST_THREADS_OF_A_CALLER)
        self._threads = CapacityLimiter(MOST_THREADS)

    async def run(self, caller: str, call: Callable[[], Answer]) -> Answer:
        """Call something in such a thread; raises TooManyRequests."""
        async with self._places.place(caller):
            return await to_thread.run_sync(call, limiter=self._threads)

    async def each(self, caller: str, items: Iterator[Answer]) -> AsyncIterator[Answer]:
        """Items that are waited for one by one."""
        while (item := await self.run(caller, lambda: next(items, None))) is not None:
            yield item


async def in_waiting_thread(
    request: Request, call: Callable[Given, Answer], *given: Given.args, **more: Given.kwargs
) -> Answer:
    """Call what may wait for a bucket or a lock, in a thread of its own kind and without the turn of the request."""
    threads: WaitingThreads = request.app.state.waiting_threads
    turn = turn_of(request)
    async with turn.waiting():
        return await threads.run(turn.caller, lambda: call(*given, **more))


class Turns:
    """The middleware that lets a few requests compute at once; probes pass.

    Those that write have turns of their own, because a database has one writer, for which they wait. A response that
    has begun waits for its client alone.
    """

    def __init__(self, app: ASGIApp, callers: KnownCallers):
        self._app, self._callers = app, callers
        self._reading = Places(MOST_READING, MOST_READING_OF_A_CALLER)
        self._writing = Places(MOST_WRITING, MOST_WRITING_OF_A_CALLER)

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        if scope["type"] != "http" or scope["path"] in PROBES:
            await self._app(scope, receive, send)
            return
        places = self._reading if scope["method"] in READING else self._writing
        turn = scope["state"]["turn"] = Turn(places, self._callers.name_of(scope))

        async def receive_waiting() -> Message:
            turn.give_back()
            message = await receive()
            if not message.get("more_body"):
                await turn.take()
            return message

        async def send_after_turn(message: Message) -> None:
            turn.end()
            await send(message)

        try:
            await turn.take()
        except TooManyRequests as error:
            await problem_response(Request(scope), error)(scope, receive, send)
            return
        try:
            await self._app(scope, receive_waiting, send_after_turn)
        finally:
            turn.end()
