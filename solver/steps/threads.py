"""Threads over kernels that are free of the interpreter lock.

Work is cut so that no two shares touch the same memory and no sum depends on the cut: one thread and many give the
same bits. With one thread kernels are called directly. A step by two threads takes a tenth to a fifth more processor
time than by one (3-D linear, 117 k particles, 2026-11-22), so that runs share the cores of a machine among them before
threads of a run do.
"""

import os
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from itertools import pairwise
from typing import TypeVar

AUTO = "auto"
Share = TypeVar("Share")
Result = TypeVar("Result")


def available_cores() -> int:
    """Cores that this process may use (a container often allows fewer than the machine has)."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


def asked_threads() -> int:
    """Threads that WHIPPLE_THREADS asks for, which may be "auto": one for each core; without it, one."""
    word = os.environ.get("WHIPPLE_THREADS", "1")
    return available_cores() if word == AUTO else int(word)


class ThreadPool:
    """A fixed number of threads that run shares of the same kernel."""

    def __init__(self, threads: int):
        self.threads = threads
        self._pool = ThreadPoolExecutor(threads) if threads > 1 else None

    def close(self) -> None:
        """End the threads."""
        if self._pool is not None:
            self._pool.shutdown()

    def run(self, call: Callable[[Share], Result], shares: Sequence[Share]) -> None:
        """``call(share)`` for each share, at once where there are threads; returns when all are done."""
        if self._pool is None or len(shares) == 1:
            for share in shares:
                call(share)
            return
        for future in [self._pool.submit(call, share) for share in shares]:
            future.result()

    def ranges(self, count: int) -> list[tuple[int, int]]:
        """0..count cut into one range a thread."""
        pieces = max(1, min(self.threads, count))
        edges = [round(piece * count / pieces) for piece in range(pieces)] + [count]
        return list(pairwise(edges))
