"""The child processes that read the documents of requests: who gets one, and what happens when one ends.

``service.api.reading`` is what they do; ``anyio.to_process`` starts and ends them. They work for one request at a time
of each API key, so that no key keeps the others waiting.
"""

from collections.abc import Callable, Mapping
from contextlib import AbstractAsyncContextManager

import anyio
from anyio import to_process

from service.api.errors import ReaderLost
from service.api.reading import USUAL, Given, Made, ReadingLimits, within_limits
from service.api.turns import Places
from service.records.expansion import ExpandedSweep, expand_again
from studies.quantities.parameters import Plain

SLOTS = 2  # children; the other cores belong to the runs
WAIT_SECONDS = 10.0  # longest time that a request waits for a child
LATE = "other sweeps are being read; send this one again"
MOST_WAITING, MOST_WAITING_OF_A_KEY = 256, 16  # requests
# Longest time with a child, which others may keep from computing, or which may be frozen.
WALL_SECONDS = 120.0


class Readers:
    """The children of a service."""

    def __init__(
        self, limits: ReadingLimits = USUAL, *, wait_seconds: float = WAIT_SECONDS, wall_seconds: float = WALL_SECONDS
    ):
        self._limits, self._wait, self._wall = limits, wait_seconds, wall_seconds
        self._slots = Places(SLOTS, 1, waiting=MOST_WAITING, waiting_of_a_caller=MOST_WAITING_OF_A_KEY)
        self._submissions = Places(SLOTS, 1, waiting=MOST_WAITING, waiting_of_a_caller=MOST_WAITING_OF_A_KEY)

    def slot(self, key: str) -> AbstractAsyncContextManager[None]:
        """A child for the duration of a block, one for each key; raises TooManyRequests."""
        return self._slots.place(key, within=self._wait, late=LATE)

    def submission(self, key: str) -> AbstractAsyncContextManager[None]:
        """A place for an expanded sweep for the duration of a block, one for each key; raises TooManyRequests.

        It is kept until the sweep is stored, for which it may wait; a child reads other documents by then.
        """
        return self._submissions.place(key, within=self._wait, late=LATE)

    async def run(self, call: Callable[[*Given], Made], *given: *Given) -> Made:
        """What a child makes of the arguments of a call; called within ``slot``. Raises InvalidInput, ReaderLost."""
        try:
            with anyio.fail_after(self._wall):
                return await to_process.run_sync(within_limits, self._limits, call, *given, cancellable=True)
        except TimeoutError:
            raise ReaderLost(f"it took more than {self._wall:g} s") from None
        except anyio.BrokenWorkerProcess:
            raise ReaderLost("it was killed") from None


def expand_accepted(document: Mapping[str, Plain]) -> ExpandedSweep:
    """An accepted sweep with its runs of this version, by a child of its own; not called by the event loop.

    Raises InvalidInput, ReaderLost.
    """
    return anyio.run(Readers().run, expand_again, document)
