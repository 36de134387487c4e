"""The engine with workers of its own: slots, ends, and that nothing is left."""

import os
import signal
import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace
from datetime import datetime, timedelta, timezone, tzinfo
from pathlib import Path
from queue import SimpleQueue
from types import SimpleNamespace
from typing import Self

import pytest
from distributed import security

from service import execution
from service.attempt import Inbox
from service.execution import Engine
from service.jobs import Cause
from service.scheduler import Connection, Embedded
from tests.service.cluster import Service, family, parent_of, pid_of, ticket
from tests.service.doubles import is_gone, wait_until
from tests.service.targets import STEPS

WORKERS = 2


@contextmanager
def embedded(scratch: Path, workers: int = WORKERS) -> Iterator[Service]:
    """An engine that computes nothing any more after the block."""
    inbox: Inbox = SimpleQueue()
    service = Service(Engine(Embedded(workers, scratch), inbox), inbox)
    try:
        yield service
    finally:
        service.engine.close(0.0)


@pytest.fixture(scope="module")
def service(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Service]:
    with embedded(tmp_path_factory.mktemp("scratch")) as one:
        yield one


def test_slots__are_there_at_once(service: Service) -> None:
    service.wait_for_slots(WORKERS)


def test_attempt__ends_with_its_files(service: Service, tmp_path: Path) -> None:
    order = ticket(tmp_path)
    service.engine.submit(order)
    ending = service.end_of(order)
    assert ending.cause is None
    assert [file.name for file in ending.files] == ["result.json", "state.npz", "log.txt"]


def test_processes__are_as_many_as_slots(service: Service, tmp_path: Path) -> None:
    orders = [ticket(tmp_path, number) for number in range(10)]
    for order in orders:
        service.engine.submit(order)
    assert {service.end_of(order).cause for order in orders} == {None}
    assert len({pid_of(order) for order in orders}) <= WORKERS


def test_progress__is_heard_with_the_last_checkpoint(service: Service, tmp_path: Path) -> None:
    order = ticket(tmp_path, seconds=2.0)
    service.engine.submit(order)
    service.end_of(order)
    told = service.told(order)
    assert told[-1]["checkpoint"] == STEPS
    assert {"fraction", "seconds", "measured"} <= told[-1].keys()


def test_stop__ends_that_attempt_alone(service: Service, tmp_path: Path) -> None:
    stopped, other = ticket(tmp_path, 1, "deaf"), ticket(tmp_path, 2, seconds=3.0)
    for order in (stopped, other):
        service.engine.submit(order)
    pid = pid_of(stopped)
    service.engine.stop([stopped.key])
    assert (service.end_of(stopped).cause, service.end_of(other).cause) == (Cause.LOST, None)
    assert is_gone(pid)


def test_known__until_it_is_forgotten(service: Service, tmp_path: Path) -> None:
    order = ticket(tmp_path)
    service.engine.submit(order)
    service.end_of(order, forget=False)
    assert order.key in service.engine.known()
    service.engine.forget([order.key])
    assert order.key not in service.engine.known()


@pytest.mark.parametrize("victim", ["process", "worker"])
def test_killed__the_attempt_says_so_and_its_neighbour_goes_on(
    service: Service, tmp_path: Path, victim: str
) -> None:
    one, other = ticket(tmp_path, 1, seconds=20.0), ticket(tmp_path, 2, seconds=4.0)
    for order in (one, other):
        service.engine.submit(order)
    pid, neighbour = pid_of(one), pid_of(other)
    os.kill(parent_of(pid) if victim == "worker" else pid, signal.SIGKILL)
    ending = service.end_of(one)
    assert ending.cause is (Cause.LOST if victim == "worker" else Cause.CRASH)
    assert service.end_of(other).cause is None
    assert pid_of(other) == neighbour
    wait_until(lambda: is_gone(pid))
    service.wait_for_slots(WORKERS)
    again = replace(ticket(tmp_path, 3), checkpoint=None)
    service.engine.submit(again)
    assert service.end_of(again).cause is None


def test_close__lets_attempts_write_a_checkpoint_and_leave(tmp_path: Path) -> None:
    with embedded(tmp_path / "scratch") as service:
        runs = [ticket(tmp_path, number, seconds=10.0) for number in (1, 2)]
        for order in runs:
            service.engine.submit(order)
        pids = [pid_of(order) for order in runs]
        everybody = family(os.getpid())
        assert set(pids) <= set(everybody)
        service.engine.close(30.0)
        for order in runs:
            ending = service.end_of(order)
            assert (ending.cause, ending.failure) == (Cause.LOST, "Left")
            assert ending.checkpoint == int(Path(str(order.checkpoint)).read_text())
    wait_until(lambda: all(is_gone(pid) for pid in pids))


def test_close__does_not_wait_for_those_who_cannot_leave(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(execution, "STOP_SECONDS", 60.0)  # for a busy machine
    with embedded(tmp_path / "scratch") as service:
        deaf = ticket(tmp_path, 1, "deaf")
        service.engine.submit(deaf)
        pid = pid_of(deaf)
        begin = time.monotonic()
        service.engine.close(1.0)
        assert time.monotonic() - begin < 120  # the run would go on for 600
        assert service.end_of(deaf).failure == "Stopped"
        assert is_gone(pid)


def test_close__leaves_no_process(tmp_path: Path) -> None:
    before = set(family(os.getpid()))
    with embedded(tmp_path / "scratch") as service:
        orders = [ticket(tmp_path, number) for number in range(WORKERS)]
        for order in orders:
            service.engine.submit(order)
        for order in orders:
            service.end_of(order)
        started = set(family(os.getpid())) - before
        assert len(started) >= 2 * WORKERS  # a worker and a warm process each
        tracker = _resource_tracker()
    wait_until(lambda: all(is_gone(pid) for pid in started - {tracker}))


def test_begin__that_fails_ends_the_workers(tmp_path: Path) -> None:
    ended: list[None] = []

    class Unreachable(Embedded):
        def __init__(self) -> None:
            """Has no workers."""

        def connect(self) -> Connection:
            raise ConnectionError("nobody answers")

        def close(self) -> None:
            ended.append(None)

    with pytest.raises(ConnectionError, match="nobody answers"):
        Engine(Unreachable(), SimpleQueue())
    assert ended == [None]


def _resource_tracker() -> int | None:
    """Python's own, which one process starts once and keeps."""
    from multiprocessing import resource_tracker

    pid: int | None = resource_tracker._resource_tracker._pid  # type: ignore[attr-defined]
    return pid


@pytest.mark.parametrize("days", [1, -400])
def test_clock_that_was_set_since_the_certificates_were_made__keeps_no_worker_away(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, days: int
) -> None:
    class Then(datetime):
        @classmethod
        def now(cls, tz: tzinfo | None = None) -> Self:
            return super().now(tz) + timedelta(days=days)

    made = SimpleNamespace(datetime=Then, timedelta=timedelta, timezone=timezone)
    monkeypatch.setattr(security, "datetime", made)
    with embedded(tmp_path, workers=1) as service:
        wait_until(lambda: service.engine.slots() == 1)
