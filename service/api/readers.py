"""The child processes that read the documents of requests: who gets one, and what happens when one ends.

``service.api.reading`` is what they do. ``anyio.to_process`` starts them when they are needed, a new one in place of
one that ended, and ends them with the event loop. They work for one request at a time of each API key, so that no
key keeps the others waiting; a request that finds no child in time is refused with 429.
"""

import json
import sys
from collections import Counter, defaultdict
from collections.abc import AsyncIterator, Callable, Mapping
from contextlib import asynccontextmanager
from typing import Any

import anyio
from anyio import CapacityLimiter, to_process

from service.api.errors import ReaderLost, TooManyRequests
from service.api.reading import USUAL, Posted, Read, ReadingLimits, Refusal, expanded_anew, read_within_limits
from service.records.expansion import ExpandedSweep
from studies.quantities.findings import InvalidInput

SLOTS = 2  # children; the other cores belong to the runs
WAIT_SECONDS = 10.0  # longest time that a request waits for a child
MOST_WAITING = 16  # requests of one key
# Longest time with a child, which others may keep from computing, or which may be frozen.
WALL_SECONDS = 120.0


class Readers:
    """The children of a service."""

    def __init__(
        self, limits: ReadingLimits = USUAL, *, wait_seconds: float = WAIT_SECONDS, wall_seconds: float = WALL_SECONDS
    ):
        self._limits, self._wait, self._wall = limits, wait_seconds, wall_seconds
        self._slots = CapacityLimiter(SLOTS)
        self._keys: defaultdict[str, CapacityLimiter] = defaultdict(lambda: CapacityLimiter(1))
        self._waiting: Counter[str] = Counter()

    @asynccontextmanager
    async def slot(self, key: str) -> AsyncIterator[None]:
        """A child for the duration of a block; raises TooManyRequests.

        A key waits for itself first, so that each has at most one request among those that wait for a child.
        """
        if self._waiting[key] >= MOST_WAITING:
            raise TooManyRequests(f"{MOST_WAITING} sweeps of this key wait to be read already")
        holder = object()
        taken: list[CapacityLimiter] = []
        self._waiting[key] += 1
        try:
            try:
                with anyio.fail_after(self._wait):
                    for limiter in (self._keys[key], self._slots):
                        await limiter.acquire_on_behalf_of(holder)
                        taken.append(limiter)
            except TimeoutError:
                raise TooManyRequests("other sweeps are being read; send this one again") from None
            finally:
                self._waiting[key] -= 1
            yield
        finally:
            for limiter in taken:
                limiter.release_on_behalf_of(holder)

    async def read(self, posted: Posted, part: Callable[[Any, Posted], Read]) -> Read | Refusal:
        """Read a body in a child; called within ``slot``. Raises ReaderLost."""
        try:
            with anyio.fail_after(self._wall):
                return await to_process.run_sync(read_within_limits, posted, part, self._limits, cancellable=True)
        except TimeoutError:
            raise ReaderLost(f"it took more than {self._wall:g} s") from None
        except anyio.BrokenWorkerProcess:
            raise ReaderLost("it was killed") from None


def expand_accepted(document: Mapping[str, Any]) -> ExpandedSweep:
    """An accepted sweep with its runs of this version, by a child of its own; not called by the event loop.

    Raises InvalidInput, ReaderLost.
    """
    posted = Posted("application/json", json.dumps(document).encode(), sys.maxsize)
    read = anyio.run(Readers().read, posted, expanded_anew)
    if isinstance(read, Refusal):
        raise InvalidInput(read.findings)
    return read
