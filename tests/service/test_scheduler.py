"""The processes of workers of our own, as the system knows them, whether or not they answer."""

import os
import signal
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path

import pytest

from service.scheduler import Embedded, has_processes
from tests.service.cluster import family
from tests.service.doubles import is_gone, wait_until


@pytest.fixture
def place(tmp_path: Path) -> Iterator[Embedded]:
    one = Embedded(1, tmp_path)
    yield one
    with suppress(TimeoutError):  # it has killed those that did not go
        one.close()


def workers_of(place: Embedded) -> list[int]:
    """The ids of its processes."""
    return [nanny.pid for nanny in place.cluster.workers.values()]


def test_processes__are_seen_though_nobody_answers(place: Embedded) -> None:
    [worker] = workers_of(place)
    os.kill(worker, signal.SIGSTOP)
    assert has_processes()
    with suppress(TimeoutError):
        place.close()
    wait_until(lambda: not has_processes())


def test_close__that_takes_too_long_kills_the_workers(
    place: Embedded, monkeypatch: pytest.MonkeyPatch
) -> None:
    def close(timeout: float) -> None:
        raise TimeoutError(f"timed out after {timeout} s.")

    [worker] = workers_of(place)
    assert worker in family(os.getpid())
    with monkeypatch.context() as patch:
        patch.setattr(place.cluster, "close", close)
        with pytest.raises(TimeoutError):
            place.close()
    wait_until(lambda: is_gone(worker))
