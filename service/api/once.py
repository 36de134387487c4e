"""What never changes while the service runs, and is built when it is first asked for."""

from collections.abc import Callable, Hashable
from functools import cache, wraps
from threading import Lock
from typing import TypeVar

Built = TypeVar("Built")


def built_once(build: Callable[..., Built]) -> Callable[..., Built]:
    """``functools.cache`` of which simultaneous first calls build once: the others wait for it."""
    cached, lock = cache(build), Lock()

    @wraps(build)
    def locked(*arguments: Hashable) -> Built:
        with lock:
            return cached(*arguments)

    return locked
