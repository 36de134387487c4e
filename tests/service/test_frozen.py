"""A worker or a scheduler that is frozen: the service does not wait for it."""

import os
import signal
import time
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from queue import SimpleQueue

import pytest

from service.attempt import Away, Inbox
from service.execution import Engine
from service.scheduler import ANSWER_SECONDS, Embedded
from tests.service.cluster import (
    Service,
    parent_of,
    patiently,
    pid_of,
    running,
    serving,
    ticket,
)

WORKERS = 2


def test_worker__stop_reaches_the_others(tmp_path: Path) -> None:
    inbox: Inbox = SimpleQueue()
    service = Service(Engine(Embedded(WORKERS, tmp_path / "scratch"), inbox), inbox)
    try:
        service.wait_for_slots(WORKERS)
        stopped, other = ticket(tmp_path, 1, "hang"), ticket(tmp_path, 2, seconds=1.0)
        for order in (stopped, other):
            service.engine.submit(order)
        pid_of(stopped)
        frozen = parent_of(pid_of(other))
        os.kill(frozen, signal.SIGSTOP)
        try:
            begin = time.monotonic()
            for _ in range(3):
                service.engine.stop([stopped.key, other.key])
            assert time.monotonic() - begin < ANSWER_SECONDS
            assert service.end_of(stopped).failure == "Stopped"
        finally:
            os.kill(frozen, signal.SIGCONT)
        service.end_of(other)
        service.wait_for_slots(WORKERS)
    finally:
        service.engine.close(0.0)


def test_scheduler__is_away_and_its_attempts_are_found_again(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    with running(tmp_path / "cluster", 0) as cluster, serving(cluster.remote()) as service:
        [frozen] = cluster.processes
        cluster.start_workers(1)
        service.wait_for_slots(1)
        order = ticket(tmp_path, seconds=3.0)
        service.engine.submit(order)
        pid = pid_of(order)
        monkeypatch.setattr("service.scheduler.ANSWER_SECONDS", 1.0)
        os.killpg(frozen.process.pid, signal.SIGSTOP)
        try:
            with ThreadPoolExecutor(1) as thread:
                assert thread.submit(service.engine.slots).result(60) == 0
            with pytest.raises(OSError, match="away"):
                service.engine.stop([order.key])
            patiently(lambda: isinstance(service.listen()[-1], Away))
            with pytest.raises(OSError, match="away"):
                service.engine.follow("another")
        finally:
            os.killpg(frozen.process.pid, signal.SIGCONT)
        assert service.end_of(order).cause is None
        assert pid_of(order) == pid
        service.wait_for_slots(1)
