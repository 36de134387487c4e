"""Threads over kernels that are free of the interpreter lock.

Work is cut so that no two shares touch the same memory and no sum depends on the cut: one thread and many give the
same bits. With one thread kernels are called directly; in a sweep each run has one, because two threads on a machine
whose other core is busy ran six times slower than one.
"""

import os
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from itertools import pairwise
from typing import Any


class Team:
    """A fixed number of threads that run shares of the same kernel."""

    def __init__(self, threads: int | None = None):
        self.threads = threads or int(os.environ.get("WHIPPLE_THREADS", "1"))
        self._pool = ThreadPoolExecutor(self.threads) if self.threads > 1 else None

    def run(self, call: Callable[..., Any], shares: Sequence[Any]) -> None:
        """``call(share)`` for each share, at once where there are threads; returns when all are done."""
        if self._pool is None or len(shares) == 1:
            for share in shares:
                call(share)
            return
        for future in [self._pool.submit(call, share) for share in shares]:
            future.result()

    def ranges(self, count: int, grain: int = 1) -> list[tuple[int, int]]:
        """0..count cut into one range a thread, at multiples of the grain."""
        pieces = max(1, min(self.threads, count // grain))
        edges = [round(piece * count / pieces / grain) * grain for piece in range(pieces)] + [count]
        return list(pairwise(edges))
