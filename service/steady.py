"""A time that nobody sets, for Dask and tornado within our processes.

Both wait for a time of day. Where the clock is set back while a stream of messages pauses between two
batches, it pauses until the old time comes round again (``distributed.batched``), and so does what is
done every so often (https://github.com/tornadoweb/tornado/issues/2333). Where it is set forward, a
scheduler takes its workers for dead (``worker-ttl``).
"""

import sys
import time
from typing import Any

from tornado.ioloop import IOLoop

_BEGIN = time.time() - time.monotonic()


def now() -> float:
    """Seconds since the epoch as they were when this process began, and steady from then on."""
    return _BEGIN + time.monotonic()


def keep_time() -> None:
    """Let Dask and tornado look at this clock instead of the machine's; loops may run already."""
    IOLoop.time = _of_loop  # type: ignore[method-assign]
    for name, module in list(sys.modules.items()):
        if name.partition(".")[0] == "distributed" and vars(module).get("time") is time.time:
            vars(module)["time"] = now


def dask_setup(server: Any) -> None:
    """Called in a scheduler that was started with ``--preload service.steady``."""
    del server
    keep_time()


def _of_loop(self: IOLoop) -> float:
    del self
    return now()
