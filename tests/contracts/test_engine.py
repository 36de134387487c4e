"""What every engine must uphold; each test runs on this machine's own, and on a Dask cluster."""

import os
import signal
import time
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, contextmanager
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from queue import SimpleQueue

import pytest

from service.execution.local import LocalEngine
from service.records.attempt import Attempt, Ended, Inbox
from service.records.jobs import Cause
from tests.service.support.attempts import LIMIT
from tests.service.support.cluster import (
    Service,
    family,
    parent_of,
    patiently,
    pid_of,
    running,
    serving,
    ticket,
)
from tests.service.support.fakes import is_gone
from tests.service.support.targets import STEPS

WORKERS = 2


@dataclass(frozen=True)
class Place:
    """A kind of engine, and where it computes."""

    open: Callable[[], AbstractContextManager[Service]]
    worker_of: Callable[[int], int]  # the process that a machine may lose, by that of an attempt
    worker_lost: Cause  # of an attempt whose worker is killed
    foreign: Callable[[], set[int]]  # processes that the engine did not start


@contextmanager
def local() -> Iterator[Service]:
    """An engine of this machine."""
    inbox: Inbox = SimpleQueue()
    service = Service(LocalEngine(WORKERS, inbox), inbox)
    try:
        yield service
    finally:
        service.engine.close(0.0)


@pytest.fixture(scope="module", params=["local", "dask"])
def place(
    request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory
) -> Iterator[Place]:
    if request.param == "local":
        yield Place(local, lambda pid: pid, Cause.CRASH, set)
        return
    with running(tmp_path_factory.mktemp("cluster"), WORKERS) as cluster:

        def foreign() -> set[int]:
            return {pid for process in cluster.processes for pid in process.look()}

        yield Place(partial(serving, cluster.remote()), parent_of, Cause.LOST, foreign)


@pytest.fixture(scope="module")
def service(place: Place) -> Iterator[Service]:
    with place.open() as opened:
        opened.wait_for_slots(WORKERS)
        yield opened


def test_run__ends_with_its_files_and_is_heard_of_once(service: Service, tmp_path: Path) -> None:
    order = ticket(tmp_path)
    service.engine.submit(order)
    ending = service.end_of(order)
    assert ending.cause is None
    assert [file.name for file in ending.files] == ["result.json", "state.npz", "log.txt"]
    later = ticket(tmp_path, 2)
    service.engine.submit(later)
    service.end_of(later)
    keys = [message.key for message in service.listen() if isinstance(message, Ended)]
    assert keys.count(order.key) == 1


def test_progress__is_heard_with_the_last_checkpoint(service: Service, tmp_path: Path) -> None:
    order = ticket(tmp_path, seconds=2.0)
    service.engine.submit(order)
    service.end_of(order)
    told = service.told(order)
    assert told[-1]["checkpoint"] == STEPS
    assert {"fraction", "seconds", "measured"} <= told[-1].keys()


def test_slots__no_more_processes_than_slots_compute(service: Service, tmp_path: Path) -> None:
    orders = [ticket(tmp_path, number) for number in range(10)]
    for order in orders:
        service.engine.submit(order)
    assert {service.end_of(order).cause for order in orders} == {None}
    assert len({pid_of(order) for order in orders}) <= WORKERS


@pytest.mark.parametrize(
    ("behaviour", "limits", "cause", "failure"),
    [
        ("abort", {}, Cause.CRASH, "SIGABRT"),
        ("raise", {}, Cause.ERROR, "RuntimeError"),
        ("deaf", {"seconds_limit": 4.0}, Cause.TIME_LIMIT, "TimeLimit"),
        ("greedy", {"memory_limit": LIMIT}, Cause.MEMORY_LIMIT, "RuntimeError"),
        ("starved", {"memory_limit": LIMIT}, Cause.MEMORY_LIMIT, "SIGABRT"),
    ],
)
def test_trouble__is_reported_as_its_cause(
    service: Service,
    tmp_path: Path,
    behaviour: str,
    limits: dict[str, float],
    cause: Cause,
    failure: str,
) -> None:
    order = replace(ticket(tmp_path, 1, behaviour), **limits)  # type: ignore[arg-type]
    service.engine.submit(order)
    ending = service.end_of(order)
    assert (ending.cause, ending.failure) == (cause, failure)


@pytest.mark.parametrize("victim", ["process", "worker"])
def test_kill__is_reported_and_the_neighbour_goes_on(
    place: Place, service: Service, tmp_path: Path, victim: str
) -> None:
    one, other = ticket(tmp_path, 1, seconds=20.0), ticket(tmp_path, 2, seconds=4.0)
    for order in (one, other):
        service.engine.submit(order)
    pid, neighbour = pid_of(one), pid_of(other)
    os.kill(place.worker_of(pid) if victim == "worker" else pid, signal.SIGKILL)
    assert service.end_of(one).cause is (place.worker_lost if victim == "worker" else Cause.CRASH)
    assert service.end_of(other).cause is None
    assert pid_of(other) == neighbour
    patiently(lambda: is_gone(pid))
    service.wait_for_slots(WORKERS)
    again = ticket(tmp_path, 3)
    service.engine.submit(again)
    assert service.end_of(again).cause is None


def test_stop__ends_that_attempt_alone(service: Service, tmp_path: Path) -> None:
    stopped, other = ticket(tmp_path, 1, "deaf"), ticket(tmp_path, 2, seconds=3.0)
    for order in (stopped, other):
        service.engine.submit(order)
    pid = pid_of(stopped)
    service.engine.stop([stopped.key])
    ending = service.end_of(stopped)
    assert (ending.cause, ending.failure) == (Cause.LOST, "Stopped")
    assert service.end_of(other).cause is None
    assert is_gone(pid)


def test_known__while_it_is_under_way_and_not_when_it_is_forgotten(
    service: Service, tmp_path: Path
) -> None:
    order = ticket(tmp_path, seconds=1.0)
    service.engine.submit(order)
    assert order.key in service.engine.known()
    service.end_of(order)  # and forget it
    assert order.key not in service.engine.known()


def test_follow__what_the_engine_does_not_have_is_lost(service: Service, tmp_path: Path) -> None:
    order = ticket(tmp_path)
    service.engine.follow(order.key)
    ending = service.end_of(order)
    assert (ending.cause, ending.failure) == (Cause.LOST, "Gone")


# --- the end -------------------------------------------------------------------------------------


def submitted(service: Service, *orders: Attempt) -> list[int]:
    """The processes of these attempts, which have begun."""
    service.wait_for_slots(WORKERS)
    for order in orders:
        service.engine.submit(order)
    return [pid_of(order) for order in orders]


def test_close__lets_attempts_write_a_checkpoint_and_leave(place: Place, tmp_path: Path) -> None:
    with place.open() as service:
        orders = [ticket(tmp_path, number, seconds=20.0) for number in range(WORKERS)]
        submitted(service, *orders)
        service.engine.close(30.0)
        for order in orders:
            ending = service.end_of(order, forget=False)
            assert (ending.cause, ending.failure) == (Cause.LOST, "Left")
            assert ending.checkpoint == int(Path(str(order.checkpoint)).read_text())


def test_close__stops_who_cannot_leave(
    place: Place, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    for engine in ("local", "dask"):  # for a busy machine
        monkeypatch.setattr(f"service.execution.{engine}.STOP_SECONDS", 60.0)
    with place.open() as service:
        deaf = ticket(tmp_path, 1, "deaf")
        [pid] = submitted(service, deaf)
        begin = time.monotonic()
        service.engine.close(1.0)
        assert time.monotonic() - begin < 60.0  # the run would go on for 600
        assert service.end_of(deaf, forget=False).failure == "Stopped"
        assert is_gone(pid)


def test_close__leaves_no_process(place: Place, tmp_path: Path) -> None:
    """Neither a process that computes nor an idle one, nor an entry of one that ended and was not waited for."""
    before = set(family(os.getpid()))
    with place.open() as service:
        done, hangs = ticket(tmp_path, 1), ticket(tmp_path, 2, "hang")
        submitted(service, done, hangs)
        service.end_of(done)
        service.engine.close(0.0)
        patiently(lambda: not set(family(os.getpid())) - before - place.foreign())
    assert is_gone(pid_of(hangs))
